// Friction and dilation that fall from their peak to the critical state as plastic shear accumulates.
#pragma once

#include <kedge/materials/friction.h>
#include <kedge/materials/response.h>

namespace kedge
{
namespace law_keys
{
inline constexpr LawKey critical_friction_angle =
    optional_key("critical friction angle", "degrees", ranges::angle, unset,
                 "Friction angle after much shear; not given: the friction angle stays");
inline constexpr LawKey critical_dilation_angle =
    optional_key("critical dilation angle", "degrees", ranges::angle, unset,
                 "Dilation angle after much shear; not given: the dilation angle stays");
inline constexpr LawKey softening_strain =
    optional_key("softening strain", "-", ranges::positive, unset,
                 "Plastic shear strain after which friction and dilation have come 95 % of the distance from their "
                 "peak to the critical state; with \"shear band width\" that inside the band");
inline constexpr LawKey shear_band_width =
    optional_key("shear band width", "m", ranges::positive, unset,
                 "Thickness of shear bands in the soil, some 10 to 20 grains: cells soften over the strain that the "
                 "same slip makes in them; not given: the softening strain holds for cells of every size");
} // namespace law_keys

/// sin(phi) and sin(psi) fall exponentially, by exp(-3 kappa / s), with the accumulated plastic shear strain kappa,
/// counted as the engineering shear strain of simple shear: sqrt(2) times the norm of the deviatoric plastic strain.
/// Slip along a band is spread over the width of one cell, so that the strain of a real band must be scaled by its
/// width over the cell's: s = softening strain * shear band width / cell size. Then the work that softening dissipates
/// per area of a band does not depend on the mesh (Pietruszczak & Mroz 1981, Int. J. Numer. Methods Eng. 17; for sand
/// with such a scaled strain Anastasopoulos et al. 2007, doi:10.1061/(ASCE)1090-0241(2007)133:8(943)).
struct FrictionSoftening
{
  double critical_sin_phi = unset, critical_sin_psi = unset;
  double sin_phi_loss = unset, sin_psi_loss = unset; ///< from peak to critical
  double strain = unset;                             ///< unset: no softening
  double band_width = unset;                         ///< m; unset: the strain is not scaled

  static FrictionSoftening make(const LawConstants& constants)
  {
    if (!constants.has(law_keys::softening_strain))
      return {};
    const double friction = constants[law_keys::friction_angle], dilation = constants[law_keys::dilation_angle];
    const double phi = sine_of_degrees(critical(constants, law_keys::critical_friction_angle, friction));
    const double psi = sine_of_degrees(critical(constants, law_keys::critical_dilation_angle, dilation));
    return {phi,
            psi,
            sine_of_degrees(friction) - phi,
            sine_of_degrees(dilation) - psi,
            constants[law_keys::softening_strain],
            constants[law_keys::shear_band_width]};
  }

  static void check(const LawConstants& constants, const Refuse& refuse)
  {
    const bool falls =
        constants.has(law_keys::critical_friction_angle) || constants.has(law_keys::critical_dilation_angle);
    if (falls && !constants.has(law_keys::softening_strain))
      refuse(law_keys::softening_strain, "this key is missing: a critical angle is given",
             "say after which plastic shear strain the soil is near its critical state, for sand some 0.1 to 1");
    for (const LawKey* key : {&law_keys::softening_strain, &law_keys::shear_band_width})
      if (!falls && constants.has(*key))
        refuse(*key, "the key has no effect without a critical angle",
               "give \"critical friction angle\" or \"critical dilation angle\", or remove the key");
    const double friction = constants[law_keys::friction_angle], dilation = constants[law_keys::dilation_angle];
    const double last_friction = critical(constants, law_keys::critical_friction_angle, friction);
    const double last_dilation = critical(constants, law_keys::critical_dilation_angle, dilation);
    const std::string remedy = "lower it: soil may lose friction and dilation by shear, not gain them";
    if (last_friction > friction)
      refuse(law_keys::critical_friction_angle, limit("friction angle", friction, last_friction), remedy);
    if (last_dilation > dilation)
      refuse(law_keys::critical_dilation_angle, limit("dilation angle", dilation, last_dilation), remedy);
    if (last_dilation > last_friction)
      refuse(law_keys::critical_dilation_angle, limit("critical friction angle", last_friction, last_dilation),
             "lower it: a soil that dilates by more than it rubs would create energy; 0 is usual");
    if (last_friction == 0. && constants[law_keys::cohesion] == 0.)
      refuse(law_keys::critical_friction_angle, "soil without cohesion loses all its strength",
             "give a number above 0");
  }

  KEDGE_FUNCTION bool active() const { return strain > 0.; }

  /// sin(phi), cos(phi), sin(psi) and their derivatives with respect to kappa.
  struct Angles
  {
    double sin_phi, cos_phi, sin_psi;
    double sin_phi_rate, cos_phi_rate, sin_psi_rate;
  };

  KEDGE_FUNCTION Angles at(const double kappa, const double cell_size) const
  {
    const double rate = -3. / (band_width > 0. ? strain * band_width / cell_size : strain);
    const double left = std::exp(rate * kappa);
    Angles angles;
    angles.sin_phi = critical_sin_phi + sin_phi_loss * left;
    angles.cos_phi = std::sqrt(1. - angles.sin_phi * angles.sin_phi);
    angles.sin_psi = critical_sin_psi + sin_psi_loss * left;
    angles.sin_phi_rate = rate * sin_phi_loss * left;
    angles.cos_phi_rate = -angles.sin_phi / angles.cos_phi * angles.sin_phi_rate;
    angles.sin_psi_rate = rate * sin_psi_loss * left;
    return angles;
  }

private:
  static double critical(const LawConstants& constants, const LawKey& key, const double peak)
  {
    return constants.has(key) ? constants[key] : peak;
  }
  static std::string limit(const std::string& of, const double largest, const double found)
  {
    return "expected at most the " + of + ", " + shown_number(largest) + " degrees, found " + shown_number(found);
  }
};

namespace internal
{
/// The deviatoric part of a response's plastic strain over its norm; 0 where there is none.
KEDGE_FUNCTION Eigen::Vector3d plastic_direction(const Response& response, const Eigen::Vector3d& trial_strain)
{
  const Eigen::Vector3d plastic = trial_strain - response.elastic_strain;
  const double mean = (plastic[0] + plastic[1] + plastic[2]) / 3.;
  const double norm = std::sqrt(1.5) * response.plastic_increment;
  if (!(norm > 0.))
    return Eigen::Vector3d::Zero();
  return Eigen::Vector3d((plastic[0] - mean) / norm, (plastic[1] - mean) / norm, (plastic[2] - mean) / norm);
}

/// The root kappa of kappa = before + sqrt(2) |plastic deviator(kappa)|, at least `before`, by Newton's method kept
/// within a bracket. Where softening is steeper than elasticity there may be several; the one found is stable, for the
/// difference of both sides rises through it.
template <typename Law>
KEDGE_FUNCTION double find_softening(const Law& law, const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                     const HenckyElasticity& elasticity, const double first_increment)
{
  constexpr double sqrt2 = 1.4142135623730951, sqrt3 = 1.7320508075688772;
  const double before = point.state[0];
  const double round_off =
      1e-15 * std::fmax(std::fabs(trial_strain[0]), std::fmax(std::fabs(trial_strain[1]), std::fabs(trial_strain[2])));
  double low = before, high = INFINITY;
  double kappa = before + sqrt3 * first_increment;
  for (int i = 0; i < 100 && high - low > round_off; ++i)
  {
    const auto angles = law.softening.at(kappa, point.cell_size);
    const auto surface = law.surface(angles, point.young);
    const Response response = surface.template respond<false>(trial_strain, elasticity);
    const Eigen::Vector3d rate =
        surface.stress_rate(law.surface_rate(angles, point.young), response, trial_strain, elasticity);
    const double difference = kappa - before - sqrt3 * response.plastic_increment;
    const double slope = 1. + sqrt2 / (2. * elasticity.shear) * plastic_direction(response, trial_strain).dot(rate);
    (difference < 0. ? low : high) = kappa;
    const double aim = kappa - difference / slope, step = std::fabs(aim - kappa);
    const bool is_last = step <= 1e-8 * (aim - before) + round_off; // the next step would be its square
    if (slope > 0. && aim >= low && aim <= high && (is_last || (aim > low && aim < high)))
      kappa = aim;
    else
      kappa = high < INFINITY ? 0.5 * (low + high) : before + 4. * (kappa - before);
    if (slope > 0. && is_last)
      break;
  }
  return kappa;
}
} // namespace internal

/// Backward Euler on a surface whose angles fall with kappa, state variable 0: the surface's own return at the kappa of
/// the increment's end, which follows from its plastic strain. The law has `softening`, `surface(angles, young)` and
/// its derivative `surface_rate(angles, young)`. The tangent is the surface's plus what d kappa adds by the chain rule.
///
/// Where the scaled softening is steeper than elasticity, so that the stress at a held strain cannot follow it, the
/// stress drops by a jump; the tangent there is bounded by taking 1 - d(plastic shear) / d(kappa) as at least 0.01.
/// Cells should then be smaller, or the shear band wider.
template <bool with_tangent, typename Law>
KEDGE_FUNCTION Response respond_softening(const Law& law, const Eigen::Vector3d& trial_strain,
                                          const MaterialPoint& point, const HenckyElasticity& elasticity,
                                          double* next_state)
{
  constexpr double sqrt2 = 1.4142135623730951;
  const double before = point.state[0];
  const auto first = law.surface(law.softening.at(before, point.cell_size), point.young)
                         .template respond<false>(trial_strain, elasticity);
  next_state[0] = before;
  if (first.status == Status::elastic)
    return elastic_response<with_tangent>(trial_strain, elasticity);

  const double kappa = internal::find_softening(law, trial_strain, point, elasticity, first.plastic_increment);
  next_state[0] = kappa;
  const auto angles = law.softening.at(kappa, point.cell_size);
  const auto surface = law.surface(angles, point.young);
  Response response = surface.template respond<with_tangent>(trial_strain, elasticity);
  if constexpr (with_tangent)
  {
    const Eigen::Vector3d rate =
        surface.stress_rate(law.surface_rate(angles, point.young), response, trial_strain, elasticity);
    const Eigen::Vector3d direction = internal::plastic_direction(response, trial_strain);
    const double half_compliance = 0.5 / elasticity.shear;
    const double slope = std::fmax(1. + sqrt2 * half_compliance * direction.dot(rate), 0.01);
    for (int j = 0; j < 3; ++j)
    {
      const double along = direction.dot(response.tangent.col(j));
      const double kappa_rate = sqrt2 * (direction[j] - half_compliance * along) / slope;
      for (int i = 0; i < 3; ++i)
        response.tangent(i, j) += rate[i] * kappa_rate;
    }
  }
  return response;
}
} // namespace kedge
