// Return to a cone whose flow is radial in the deviatoric plane.
#pragma once

#include <kedge/materials/response.h>

namespace kedge
{
/// Yield function f = rho - r (intercept + hardening gamma - slope xi) and potential g = rho + dilatancy xi, with rho =
/// sqrt(2 J2), xi = tr(tau) / sqrt(3) (tension positive), r the relative radius of the deviatoric section and gamma the
/// plastic multiplier of the increment, the norm of the deviatoric plastic strain.
struct Cone
{
  double slope;      ///< >= 0
  double intercept;  ///< rho at xi = 0 where r = 1, Pa; > 0
  double dilatancy;  ///< >= 0
  double radius;     ///< r at the trial strain's Lode angle
  double derivative; ///< d r / d angle, the angle counted about (1, 1, 1) as a right-handed screw turns
  double hardening;  ///< d intercept / d gamma, Pa; 0 where the slope is not 0

  /// Backward Euler. The potential's section is a circle, so the return keeps the deviator's direction, and
  /// with it r; f is then linear in the plastic multiplier:
  ///   gamma = f_trial / (2 G + r hardening + 3 K slope r dilatancy), rho = rho_trial - 2 G gamma,
  ///   xi = xi_trial - 3 K dilatancy gamma,
  /// and the apex takes what would need rho < 0.
  /// The tangent is written in the orthonormal axes (1, 1, 1)/sqrt(3), s = deviator's direction, t = across both, in
  /// which d s = t (t . d eps) / |deviatoric trial strain|.
  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity) const;

  /// d stress / d q at a fixed trial strain, where slope, intercept and dilatancy change by `change` with a parameter
  /// q, and `response` is what this cone without hardening answers to the trial strain.
  KEDGE_FUNCTION Eigen::Vector3d stress_rate(const Cone& change, const Response& response,
                                             const Eigen::Vector3d& trial_strain,
                                             const HenckyElasticity& elasticity) const;
};

template <bool with_tangent>
KEDGE_FUNCTION Response Cone::respond(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity) const
{
  constexpr double sqrt3 = 1.7320508075688772;
  const double two_g = 2. * elasticity.shear, three_k = 3. * elasticity.bulk();
  const double mean = (trial_strain[0] + trial_strain[1] + trial_strain[2]) / 3.;
  const Eigen::Vector3d deviator(trial_strain[0] - mean, trial_strain[1] - mean, trial_strain[2] - mean);
  const double norm = std::sqrt(deviator[0] * deviator[0] + deviator[1] * deviator[1] + deviator[2] * deviator[2]);
  const double trial_rho = two_g * norm, trial_xi = sqrt3 * three_k * mean;

  const double yield = trial_rho - radius * (intercept - slope * trial_xi);
  if (yield <= two_g * yield_tolerance)
    return elastic_response<with_tangent>(trial_strain, elasticity);

  const double compliance = 1. / (two_g + radius * hardening + three_k * slope * radius * dilatancy);
  const double multiplier = yield * compliance;
  if (slope > 0. && two_g * multiplier >= trial_rho)
    return apex_response<with_tangent>(trial_strain, elasticity, intercept / (slope * sqrt3));

  const double xi = trial_xi - three_k * dilatancy * multiplier;
  const double strength = intercept + hardening * multiplier - slope * xi; // rho / r
  const double rho = radius * strength;
  const double direction_scale = 1. / norm;
  const double shrink = rho / trial_rho;
  const Eigen::Vector3d s = direction_scale * deviator;

  Response response;
  const double mean_stress = xi / sqrt3, mean_strain = mean_stress / three_k;
  for (int i = 0; i < 3; ++i)
  {
    response.stress[i] = mean_stress + rho * s[i];
    response.elastic_strain[i] = mean_strain + shrink * deviator[i];
  }
  response.plastic_increment = std::sqrt(2. / 3.) * multiplier;
  // Fades in towards the apex, where shear stiffness vanishes with rho.
  response.residual_stiffness = std::fmax(0., apex_stiffness - shrink);
  response.status = Status::plastic;

  if constexpr (with_tangent)
  {
    response.shear_stiffness = Eigen::Vector3d::Constant(shrink * two_g); // the deviator keeps its direction
    const Eigen::Vector3d t(direction_scale * (deviator[2] - deviator[1]) / sqrt3,
                            direction_scale * (deviator[0] - deviator[2]) / sqrt3,
                            direction_scale * (deviator[1] - deviator[0]) / sqrt3);
    // d multiplier / d strain = along_mean (1, 1, 1) + along_s s + along_t t
    const double along_mean = compliance * slope * radius * three_k / sqrt3;
    const double along_s = compliance * two_g;
    const double along_t = -compliance * strength * derivative * direction_scale;
    const double flow_mean = three_k * dilatancy / sqrt3;
    for (int j = 0; j < 3; ++j)
    {
      const double d_multiplier = along_mean + along_s * s[j] + along_t * t[j];
      const double d_mean = elasticity.bulk() - flow_mean * d_multiplier;
      const double d_rho = two_g * (s[j] - d_multiplier);
      const double turn = shrink * two_g * t[j];
      for (int i = 0; i < 3; ++i)
        response.tangent(i, j) = d_mean + d_rho * s[i] + turn * t[i];
    }
  }
  return response;
}

KEDGE_FUNCTION Eigen::Vector3d Cone::stress_rate(const Cone& change, const Response& response,
                                                 const Eigen::Vector3d& trial_strain,
                                                 const HenckyElasticity& elasticity) const
{
  constexpr double sqrt3 = 1.7320508075688772;
  if (response.status == Status::elastic)
    return Eigen::Vector3d::Zero();
  if (response.status == Status::apex)
    return Eigen::Vector3d::Constant((change.intercept - intercept / slope * change.slope) / (slope * sqrt3));
  const double two_g = 2. * elasticity.shear, three_k = 3. * elasticity.bulk();
  const double mean = (trial_strain[0] + trial_strain[1] + trial_strain[2]) / 3.;
  const Eigen::Vector3d deviator(trial_strain[0] - mean, trial_strain[1] - mean, trial_strain[2] - mean);
  const double norm = std::sqrt(deviator[0] * deviator[0] + deviator[1] * deviator[1] + deviator[2] * deviator[2]);
  const double multiplier = std::sqrt(1.5) * response.plastic_increment;

  const double yield_rate = radius * (change.slope * sqrt3 * three_k * mean - change.intercept);
  const double stiffness_rate = three_k * radius * (change.slope * dilatancy + slope * change.dilatancy);
  const double rate =
      (yield_rate - stiffness_rate * multiplier) / (two_g + three_k * slope * radius * dilatancy); // of the multiplier
  const double mean_rate = -three_k / sqrt3 * (change.dilatancy * multiplier + dilatancy * rate);
  return Eigen::Vector3d::Constant(mean_rate) - (two_g * rate / norm) * deviator;
}
} // namespace kedge
