// What the input says of a material.
#pragma once

#include <limits>
#include <optional>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
enum class MaterialType
{
  elastic,
  von_mises,
  drucker_prager,
  willam_warnke,
  mohr_coulomb
};

/// Stiffness that grows with the initial vertical stress: E = E_ref (sigma_v / reference_stress)^exponent.
struct Overburden
{
  double reference_stress; ///< Pa
  double exponent;         ///< -
};

/// Keys that a type does not use stay NaN, so that an accidental use shows.
struct MaterialParameters
{
  MaterialType type = MaterialType::elastic;
  double young = std::numeric_limits<double>::quiet_NaN();          ///< Young's modulus, Pa
  double poisson = std::numeric_limits<double>::quiet_NaN();        ///< Poisson's ratio
  double density = std::numeric_limits<double>::quiet_NaN();        ///< kg/m3
  double yield_stress = std::numeric_limits<double>::quiet_NaN();   ///< von Mises: uniaxial yield stress, Pa
  double friction_angle = std::numeric_limits<double>::quiet_NaN(); ///< degrees
  double dilation_angle = std::numeric_limits<double>::quiet_NaN(); ///< degrees
  double cohesion = std::numeric_limits<double>::quiet_NaN();       ///< Pa
  std::optional<Overburden> overburden;
};

/// Keys of "material".
schema::Section<MaterialParameters> material_section();
} // namespace kedge
