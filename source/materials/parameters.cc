#include <algorithm>
#include <kedge/materials/laws.h>
#include <kedge/materials/parameters.h>
#include <kedge/parameters/section.h>

namespace kedge
{
using namespace schema;

std::string shown_number(const double value) { return shown(value); }

namespace
{
Section<Overburden> overburden_section()
{
  Section<Overburden> section("Stiffness by depth: E = E_ref (sigma_v / reference stress)^exponent, with sigma_v the "
                              "weight above a material point's first position");
  section.required("reference stress", &Overburden::reference_stress, number("Pa", positive()),
                   "Vertical stress at which Young's modulus is \"E\"");
  section.required("exponent", &Overburden::exponent, number("-", not_negative()),
                   "Power of the vertical stress; 0: E is constant");
  return section;
}

Bounds bounds_of(const Range& range)
{
  Bounds bounds;
  if (std::isfinite(range.lower))
    range.open_below ? bounds.above(range.lower) : bounds.at_least(range.lower);
  if (std::isfinite(range.upper))
    range.open_above ? bounds.below(range.upper) : bounds.at_most(range.upper);
  return bounds;
}

/// A key with the names of the laws that have it.
struct KeyOfLaws
{
  const LawKey* key;
  std::vector<std::string> laws;
};

/// The keys of all laws in the order in which the list first names them.
std::vector<KeyOfLaws> keys_of_laws()
{
  std::vector<KeyOfLaws> keys;
  Laws::for_each(
      [&](const auto tag)
      {
        using Law = typename decltype(tag)::type;
        for (const LawKey* key : Law::keys)
        {
          const auto same = [&](const KeyOfLaws& other) { return other.key == key; };
          const auto known = std::find_if(keys.begin(), keys.end(), same);
          if (known == keys.end())
            keys.push_back({key, {Law::name}});
          else
            known->laws.push_back(Law::name);
        }
      });
  return keys;
}

void add_keys_of_laws(Section<MaterialParameters>& section)
{
  for (const auto& [key, laws] : keys_of_laws())
  {
    const auto set = [name = std::string(key->name)](MaterialParameters& into, const double value)
    { into.constants.values[name] = value; };
    const Format<double> format = number(key->unit, bounds_of(key->range));
    Key& declared = key->required ? section.required(key->name, set, format, key->sentence)
                                  : section.optional(key->name, set, format, key->sentence);
    if (!std::isnan(key->standard))
      declared.standard = key->standard;
    declared.only_for("type", laws);
  }
}

void check_constants(const MaterialParameters& material, const Place& place)
{
  const Refuse refuse = [&](const LawKey& key, const std::string& problem, const std::string& remedy)
  { place.key(key.name).fail(problem, remedy); };
  Laws::visit(material.law, [&](const auto tag) { decltype(tag)::type::check(material.constants, refuse); });
}
} // namespace

Section<MaterialParameters> material_section()
{
  using P = MaterialParameters;
  std::vector<std::pair<std::string, unsigned int>> types;
  Laws::for_each(
      [&](const auto tag)
      {
        using Law = typename decltype(tag)::type;
        types.emplace_back(Law::name, law_index<Law>);
      });
  Section<P> section("Constitutive law of a layer, at finite strain (Hencky elasticity)");
  section.required("type", &P::law, choice<unsigned int>(types), "Elastic law or yield surface");
  section.required("E", &P::young, number("Pa", positive()),
                   "Young's modulus; with \"E overburden\" its value at the reference stress");
  section.required("nu", &P::poisson, number("-", Bounds().above(-1.).below(0.5)), "Poisson's ratio");
  section.required("density", &P::density, number("kg/m3", positive()),
                   "Density; of submerged soil the buoyant density");
  add_keys_of_laws(section);
  section.optional("E overburden", &P::overburden, maybe(object_of(overburden_section())),
                   "Makes Young's modulus grow with depth");
  section.check(check_constants);
  return section;
}
} // namespace kedge
