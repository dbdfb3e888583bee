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
  const std::string otherwise = required ? "" : "; default: that of \"contact\"";
  Section<P> section("The interface between soil and body");
  const auto friction = maybe(number("-", not_negative().at_most(100.)));
  if (required)
    section.required("friction coefficient", &P::friction_coefficient, friction,
                     "Coulomb's coefficient; 0: frictionless");
  else
    section.optional("friction coefficient", &P::friction_coefficient, friction, "Coulomb's coefficient" + otherwise);
  section.optional(
      "adhesion", &P::adhesion, maybe(number("Pa", not_negative())),
      "Shear stress that the interface carries in addition to friction, or at most: see \"tangential limit\"" +
          (required ? std::string("; default: none, friction alone") : otherwise));
  section.optional(
      "tangential limit", &P::tangential_limit,
      maybe(choice<TangentialLimit>({{"smaller", TangentialLimit::smaller}, {"sum", TangentialLimit::sum}})),
      "Shear stress at which the soil slips at a pressure p: the smaller of friction coefficient x p and "
      "adhesion, or their sum, which has all of the adhesion from a pressure of a tenth of it on" +
          (required ? std::string("; default: \"smaller\", because in undrained clay a higher total pressure does not "
                                  "make the interface stronger")
                    : otherwise));
  section.optional(
      "bonded", &P::bonded, maybe(on_off()),
      "\"on\": a corner of a material point stays bonded once it has touched the surface, or if it lies "
      "within half a point's size of a body that is wished in place; it resists any tension, also that of soil which "
      "the end of a sliding body leaves behind, and with "
      "adhesion \"smaller\" means the adhesion alone" +
          (required ? std::string("; default: \"off\"") : otherwise));
  return section;
}
} // namespace kedge
