// Drucker-Prager's circular cone.
#pragma once

#include <kedge/materials/cone.h>
#include <kedge/materials/softening.h>

namespace kedge
{
/// Circular cone through the compression meridian of Mohr-Coulomb (Drucker & Prager 1952):
///   f = rho + slope xi - k,  slope = 2 sqrt(2) sin(phi) / (3 - sin(phi)),  k = 2 sqrt(6) c cos(phi) / (3 - sin(phi)),
/// flow from g = rho + dilatancy xi with psi in place of phi. Its apex is Mohr-Coulomb's, tr(tau)/3 = c cot(phi).
/// In extension and in plane strain it is stronger than Mohr-Coulomb.
struct DruckerPrager
{
  static constexpr const char* name = "drucker prager";
  static constexpr std::array keys = {
      &law_keys::friction_angle,          &law_keys::dilation_angle,          &law_keys::cohesion,
      &law_keys::critical_friction_angle, &law_keys::critical_dilation_angle, &law_keys::softening_strain,
      &law_keys::shear_band_width};
  static constexpr std::array state_variables = {
      StateVariable{"plastic shear strain", "-", "Accumulated plastic shear strain"}};

  double slope = unset;
  double intercept_per_cohesion = unset;
  double dilatancy = unset;
  double cohesion = unset; ///< Pa
  FrictionSoftening softening = {};

  static DruckerPrager make(const LawConstants& constants)
  {
    const double friction = constants[law_keys::friction_angle];
    const double sine = sine_of_degrees(friction), dilatant_sine = sine_of_degrees(constants[law_keys::dilation_angle]);
    return {2. * std::sqrt(2.) * sine / (3. - sine), 2. * std::sqrt(6.) * cosine_of_degrees(friction) / (3. - sine),
            2. * std::sqrt(2.) * dilatant_sine / (3. - dilatant_sine), constants[law_keys::cohesion],
            FrictionSoftening::make(constants)};
  }

  static void check(const LawConstants& constants, const Refuse& refuse)
  {
    check_dilation(constants, refuse);
    check_strength(constants, refuse);
    FrictionSoftening::check(constants, refuse);
  }

  bool remembers() const { return softening.active(); }
  void initialise(const Generation&, double* state) const { state[0] = 0.; }

  KEDGE_FUNCTION Cone surface(const FrictionSoftening::Angles& at, const double young) const
  {
    const double root2 = 1.4142135623730951, root6 = 2.449489742783178;
    return {2. * root2 * at.sin_phi / (3. - at.sin_phi),
            2. * root6 * effective_cohesion(cohesion, young) * at.cos_phi / (3. - at.sin_phi),
            2. * root2 * at.sin_psi / (3. - at.sin_psi),
            1.,
            0.,
            0.};
  }

  KEDGE_FUNCTION Cone surface_rate(const FrictionSoftening::Angles& at, const double young) const
  {
    const double root2 = 1.4142135623730951, root6 = 2.449489742783178;
    const double below = 3. - at.sin_phi, below_psi = 3. - at.sin_psi;
    return {6. * root2 * at.sin_phi_rate / (below * below),
            2. * root6 * effective_cohesion(cohesion, young) *
                (at.cos_phi_rate + at.cos_phi * at.sin_phi_rate / below) / below,
            6. * root2 * at.sin_psi_rate / (below_psi * below_psi),
            0.,
            0.,
            0.};
  }

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                  const HenckyElasticity& elasticity, double* next_state) const
  {
    if (softening.active())
      return respond_softening<with_tangent>(*this, trial_strain, point, elasticity, next_state);
    const double intercept = intercept_per_cohesion * effective_cohesion(cohesion, point.young);
    return Cone{slope, intercept, dilatancy, 1., 0., 0.}.respond<with_tangent>(trial_strain, elasticity);
  }
};
} // namespace kedge
