// Drucker-Prager's circular cone; von Mises is the one of zero slope.
#pragma once

#include <kedge/materials/cone.h>

namespace kedge
{
/// Circular cone through the compression meridian of Mohr-Coulomb (Drucker & Prager 1952):
///   f = rho + slope xi - k,  slope = 2 sqrt(2) sin(phi) / (3 - sin(phi)),  k = 2 sqrt(6) c cos(phi) / (3 - sin(phi)),
/// flow from g = rho + dilatancy xi with psi in place of phi. Its apex is Mohr-Coulomb's, tr(tau)/3 = c cot(phi).
/// In extension and in plane strain it is stronger than Mohr-Coulomb.
struct DruckerPrager
{
  double slope;
  double intercept_per_cohesion;
  double dilatancy;
  double cohesion; ///< Pa

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const double young,
                                  const HenckyElasticity& elasticity) const
  {
    const double intercept = intercept_per_cohesion * effective_cohesion(cohesion, young);
    return return_to_cone<with_tangent>(trial_strain, elasticity, Cone{slope, intercept, dilatancy, 1., 0.});
  }
};

/// Perfect plasticity with the yield condition sqrt(3 J2) = yield stress.
struct VonMises
{
  double yield_stress; ///< uniaxial, Pa

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity) const
  {
    const double radius = 0.816496580927726 * yield_stress; // sqrt(2/3)
    return return_to_cone<with_tangent>(trial_strain, elasticity, Cone{0., radius, 0., 1., 0.});
  }
};
} // namespace kedge
