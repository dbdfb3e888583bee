#include <kedge/bodies/interface.h>
#include <kedge/parameters/section.h>

namespace kedge
{
using namespace schema;

InterfaceParameters InterfaceParameters::or_else(const InterfaceParameters& general) const
{
  InterfaceParameters result = *this;
  const auto complete = [](auto& value, const auto& other)
  {
    if (!value)
      value = other;
  };
  complete(result.friction_coefficient, general.friction_coefficient);
  complete(result.adhesion, general.adhesion);
  complete(result.tangential_limit, general.tangential_limit);
  complete(result.bonded, general.bonded);
  return result;
}

TangentialLimit InterfaceParameters::limit() const
{
  return adhesion ? tangential_limit.value_or(TangentialLimit::smaller) : TangentialLimit::friction;
}

Section<InterfaceParameters> interface_section(const bool required)
{
  using P = InterfaceParameters;
  const std::string otherwise = required ? "" : "; without it that of \"contact\"";
  Section<P> section("The interface between soil and body");
  const auto friction = maybe(number("-", not_negative()));
  if (required)
    section.required("friction coefficient", &P::friction_coefficient, friction,
                     "Coulomb's coefficient; 0: frictionless");
  else
    section.optional("friction coefficient", &P::friction_coefficient, friction, "Coulomb's coefficient" + otherwise);
  section.optional(
      "adhesion", &P::adhesion, maybe(number("Pa", not_negative())),
      "Shear stress that the interface carries besides friction, or at most, as \"tangential limit\" says" +
          (required ? std::string("; without it friction alone counts") : otherwise));
  section.optional(
      "tangential limit", &P::tangential_limit,
      maybe(choice<TangentialLimit>({{"smaller", TangentialLimit::smaller}, {"sum", TangentialLimit::sum}})),
      "Shear stress at which the soil slips at a pressure p: the smaller of friction coefficient x p and "
      "adhesion, or their sum" +
          (required ? std::string("; without it \"smaller\", as in undrained clay a higher total pressure "
                                  "does not make the interface stronger")
                    : otherwise));
  section.optional("bonded", &P::bonded, maybe(on_off()),
                   "\"on\": a corner of a material point that has touched the surface, or lies within half a point's "
                   "size of a body wished in place, does not come off: it pulls without limit, and with adhesion "
                   "\"smaller\" means the adhesion alone" +
                       (required ? std::string("; without it \"off\"") : otherwise));
  section.check(
      [](const P& interface, const Place& place)
      {
        if (interface.tangential_limit && !interface.adhesion)
          place.key("tangential limit")
              .fail("there is no \"adhesion\" beside it that it could combine with friction",
                    "add \"adhesion\" (Pa), or remove the key for friction alone");
      });
  return section;
}
} // namespace kedge
