// Undrained clay: a strength that grows with depth and falls as the clay is remoulded.
#pragma once

#include <kedge/materials/cone.h>
#include <kedge/materials/law.h>

namespace kedge
{
namespace law_keys
{
inline constexpr LawKey undrained_strength =
    required_key("undrained strength", "Pa", ranges::not_negative,
                 "Undrained shear strength at the soil's surface, of plane strain and simple shear");
inline constexpr LawKey strength_gradient =
    optional_key("strength gradient", "Pa/m", ranges::not_negative, 0.,
                 "Growth of the undrained shear strength with the initial depth below the soil's surface");
inline constexpr LawKey remoulded_ratio =
    optional_key("remoulded ratio", "-", {0., 1., true, false}, 1.,
                 "Strength of remoulded over that of intact clay, 1 / sensitivity; 1: the strength stays");
inline constexpr LawKey remoulding_strain =
    optional_key("remoulding strain", "-", ranges::positive, unset,
                 "Accumulated plastic shear strain after which 95 % of the loss of strength is reached");
} // namespace law_keys

/// Von Mises' circle rho = sqrt(2 J2) = sqrt(2) s_u, which simple shear and isochoric plane strain reach at the shear
/// stress s_u, with
///   s_u = (s_u0 + k depth) (delta + (1 - delta) exp(-3 xi / xi_95)),
/// xi the accumulated plastic shear strain (Einav & Randolph 2005, Int. J. Numer. Methods Eng. 63), counted as the
/// engineering shear strain of simple shear, sqrt(2) times the norm of the plastic strain.
///
/// Backward Euler: 2 G gamma + sqrt(2) s_u(xi + sqrt(2) gamma) = rho_trial. s_u is convex in xi, so the difference of
/// both sides has exactly one root gamma > 0 however steep the softening, and Newton's method comes down to it from
/// above without a safeguard. Where the clay softens by more than G per plastic shear strain, 3 (1 - delta) s_u / xi_95
/// > G, it cannot follow its own decay at a held strain: the stress drops by a jump as soon as the point yields, onto
/// the elastic line's other intersection with the curve, whatever the size of the increment.
struct Clay
{
  static constexpr const char* name = "clay";
  static constexpr std::array keys = {&law_keys::undrained_strength, &law_keys::strength_gradient,
                                      &law_keys::remoulded_ratio, &law_keys::remoulding_strain};
  static constexpr std::array state_variables = {
      StateVariable{"intact strength", "Pa", "Undrained shear strength before remoulding"},
      StateVariable{"plastic shear strain", "-", "Accumulated plastic shear strain"}};

  double surface_strength = unset;  ///< s_u0, Pa
  double gradient = unset;          ///< k, Pa/m
  double remoulded_ratio = unset;   ///< delta
  double remoulding_strain = unset; ///< xi_95; unset where delta = 1

  static Clay make(const LawConstants& constants)
  {
    return {constants[law_keys::undrained_strength], constants[law_keys::strength_gradient],
            constants[law_keys::remoulded_ratio], constants[law_keys::remoulding_strain]};
  }

  static void check(const LawConstants& constants, const Refuse& refuse)
  {
    if (constants[law_keys::undrained_strength] == 0. && constants[law_keys::strength_gradient] == 0.)
      refuse(law_keys::undrained_strength, "the undrained strength and its gradient are both 0: clay without strength",
             "give at least one of them above 0");
    const bool remoulds = constants[law_keys::remoulded_ratio] < 1.;
    if (remoulds && !constants.has(law_keys::remoulding_strain))
      refuse(law_keys::remoulding_strain, "this key is missing: the remoulded ratio is below 1",
             "say after which plastic shear strain the clay is remoulded, 10 to 50 for many clays");
    if (!remoulds && constants.has(law_keys::remoulding_strain))
      refuse(law_keys::remoulding_strain, "the key has no effect, for the remoulded ratio is 1",
             "give \"remoulded ratio\" below 1 or remove the key");
  }

  bool remembers() const { return true; }
  void initialise(const Generation& at, double* state) const
  {
    state[0] = surface_strength + gradient * at.depth;
    state[1] = 0.;
  }

  /// s_u over its intact value.
  KEDGE_FUNCTION double kept(const double xi) const
  {
    return remoulded_ratio + (1. - remoulded_ratio) * std::exp(-3. * xi / remoulding_strain);
  }

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                  const HenckyElasticity& elasticity, double* next_state) const
  {
    constexpr double sqrt2 = 1.4142135623730951, sqrt3 = 1.7320508075688772;
    const double before = point.state[1];
    const double intact = sqrt2 * effective_cohesion(point.state[0], point.young);
    Cone circle = {0., intact, 0., 1., 0., 0.};
    if (remoulded_ratio < 1.)
      circle = soften(trial_strain, elasticity, intact, before);
    const Response response = circle.respond<with_tangent>(trial_strain, elasticity);
    next_state[0] = point.state[0];
    next_state[1] = before + sqrt3 * response.plastic_increment;
    return response;
  }

private:
  /// The circle that hardens linearly and touches the softening one at the increment's end: the return to it ends there
  /// and has its tangent.
  KEDGE_FUNCTION Cone soften(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity,
                             const double intact, const double before) const
  {
    constexpr double sqrt2 = 1.4142135623730951;
    const double two_g = 2. * elasticity.shear;
    const double mean = (trial_strain[0] + trial_strain[1] + trial_strain[2]) / 3.;
    const double x = trial_strain[0] - mean, y = trial_strain[1] - mean, z = trial_strain[2] - mean;
    const double norm = std::sqrt(x * x + y * y + z * z);
    const double strength = intact * kept(before);
    if (two_g * norm - strength <= two_g * yield_tolerance)
      return {0., strength, 0., 1., 0., 0.};

    double multiplier = norm, radius = strength, slope = 0.;
    for (int i = 0; i < 50; ++i)
    {
      const double lost = (1. - remoulded_ratio) * std::exp(-3. * (before + sqrt2 * multiplier) / remoulding_strain);
      radius = intact * (remoulded_ratio + lost);
      slope = -3. * sqrt2 / remoulding_strain * intact * lost;
      const double step = (two_g * (norm - multiplier) - radius) / (two_g + slope);
      // The linear return makes this step too, and it squares the error; 1e-15 is round-off.
      if (std::fabs(step) <= 1e-8 * multiplier + 1e-15 * norm)
        break;
      multiplier += step;
    }
    return {0., radius - slope * multiplier, 0., 1., 0., slope};
  }
};
} // namespace kedge
