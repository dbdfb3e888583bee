// Mohr-Coulomb's planes, with friction and dilation that may fall from their peak to the critical state.
#pragma once

#include <kedge/materials/mohr_planes.h>
#include <kedge/materials/softening.h>

namespace kedge
{
/// f = (1 + sin(phi)) tau_1 - (1 - sin(phi)) tau_3 - 2 c cos(phi) with tau_1 >= tau_2 >= tau_3, tension positive; flow
/// from the same function with psi in place of phi. phi = psi = 0 is Tresca's law.
struct MohrCoulomb
{
  static constexpr const char* name = "mohr coulomb";
  static constexpr std::array keys = {
      &law_keys::friction_angle,          &law_keys::dilation_angle,          &law_keys::cohesion,
      &law_keys::critical_friction_angle, &law_keys::critical_dilation_angle, &law_keys::softening_strain,
      &law_keys::shear_band_width};
  static constexpr std::array state_variables = {
      StateVariable{"plastic shear strain", "-", "Accumulated plastic shear strain"}};

  double sin_phi = unset;
  double cos_phi = unset;
  double sin_psi = unset;
  double cohesion = unset; ///< Pa
  FrictionSoftening softening = {};

  static MohrCoulomb make(const LawConstants& constants)
  {
    const double friction = constants[law_keys::friction_angle];
    return {sine_of_degrees(friction), cosine_of_degrees(friction),
            sine_of_degrees(constants[law_keys::dilation_angle]), constants[law_keys::cohesion],
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

  KEDGE_FUNCTION MohrPlanes surface(const FrictionSoftening::Angles& at, const double young) const
  {
    return {at.sin_phi, at.cos_phi, at.sin_psi, effective_cohesion(cohesion, young)};
  }

  KEDGE_FUNCTION MohrPlanes surface_rate(const FrictionSoftening::Angles& at, const double) const
  {
    return {at.sin_phi_rate, at.cos_phi_rate, at.sin_psi_rate, 0.};
  }

  /// Whether planes() are the law, at every strain.
  KEDGE_FUNCTION bool is_fixed() const { return !softening.active(); }

  KEDGE_FUNCTION MohrPlanes planes(const double young) const
  {
    return {sin_phi, cos_phi, sin_psi, effective_cohesion(cohesion, young)};
  }

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                  const HenckyElasticity& elasticity, double* next_state) const
  {
    return is_fixed() ? planes(point.young).respond<with_tangent>(trial_strain, elasticity)
                      : respond_softening<with_tangent>(*this, trial_strain, point, elasticity, next_state);
  }
};
} // namespace kedge
