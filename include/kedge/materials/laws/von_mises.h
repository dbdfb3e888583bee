// Von Mises' circle with linear isotropic hardening.
#pragma once

#include <kedge/materials/cone.h>
#include <kedge/materials/law.h>

namespace kedge
{
namespace law_keys
{
inline constexpr LawKey yield_stress =
    required_key("yield stress", "Pa", ranges::positive, "Yield stress in uniaxial tension");
inline constexpr LawKey hardening_modulus =
    optional_key("hardening modulus", "Pa", ranges::not_negative, 0.,
                 "Growth of the yield stress with the equivalent plastic strain; 0: perfect plasticity");
} // namespace law_keys

/// sqrt(3 J2) = yield stress + H e_p with the equivalent plastic strain e_p. The return is radial and linear in the
/// multiplier, hence closed form (Simo & Hughes 1998, Computational Inelasticity, box 3.2).
struct VonMises
{
  static constexpr const char* name = "von mises";
  static constexpr std::array keys = {&law_keys::yield_stress, &law_keys::hardening_modulus};
  static constexpr std::array state_variables = {
      StateVariable{"hardening strain", "-", "Equivalent plastic strain that hardens the soil"}};

  double yield_stress = unset; ///< uniaxial, of virgin material, Pa
  double hardening = unset;    ///< Pa

  static VonMises make(const LawConstants& constants)
  {
    return {constants[law_keys::yield_stress], constants[law_keys::hardening_modulus]};
  }
  static void check(const LawConstants&, const Refuse&) {}

  bool remembers() const { return hardening > 0.; }
  void initialise(const Generation&, double* state) const { state[0] = 0.; }

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                  const HenckyElasticity& elasticity, double* next_state) const
  {
    constexpr double root = 0.816496580927726; // sqrt(2/3)
    if (!(hardening > 0.))
      return Cone{0., root * yield_stress, 0., 1., 0., 0.}.respond<with_tangent>(trial_strain, elasticity);
    const double before = point.state[0];
    const Cone circle = {0., root * (yield_stress + hardening * before), 0., 1., 0., 2. / 3. * hardening};
    const Response response = circle.respond<with_tangent>(trial_strain, elasticity);
    next_state[0] = before + response.plastic_increment;
    return response;
  }
};
} // namespace kedge
