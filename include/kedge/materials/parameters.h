// What the input says of a material.
#pragma once

#include <kedge/materials/law.h>
#include <optional>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
/// Stiffness that grows with the initial vertical stress: E = E_ref (sigma_v / reference_stress)^exponent.
struct Overburden
{
  double reference_stress; ///< Pa
  double exponent;         ///< -
};

struct MaterialParameters
{
  unsigned int law = 0;   ///< position in the list of laws (materials/laws.h): law_index<MohrCoulomb>
  double young = unset;   ///< Young's modulus, Pa
  double poisson = unset; ///< Poisson's ratio
  double density = unset; ///< kg/m3
  LawConstants constants; ///< of the law, by the names of its keys
  std::optional<Overburden> overburden;
};

/// Keys of "material".
schema::Section<MaterialParameters> material_section();
} // namespace kedge
