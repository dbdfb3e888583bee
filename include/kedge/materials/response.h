// What a law answers to a trial strain in the principal frame.
#pragma once

#include <kedge/materials/hencky.h>

namespace kedge
{
/// Where the stress ended. `inverted`: the deformation increment had det <= 0 (or was not a number) and no law was
/// asked; the increment must be refused.
enum class Status : unsigned char
{
  elastic,
  plastic, ///< on a smooth part of the yield surface
  edge,
  apex,
  inverted
};

/// All in the principal frame of the trial elastic strain and in its order.
struct Response
{
  Eigen::Vector3d stress;         ///< Kirchhoff stress, Pa
  Eigen::Vector3d elastic_strain; ///< elastic logarithmic strain
  /// d stress_i / d trial strain_j, exact; not a number where no tangent was asked for.
  Eigen::Matrix3d tangent = Eigen::Matrix3d::Constant(NAN);
  /// (stress_i - stress_j) / (trial strain_i - trial strain_j) of the pairs 01, 12, 20, also in the limit of equal
  /// strains: each law knows it without the quotient of two small differences. Set where the tangent is.
  Eigen::Vector3d shear_stiffness = Eigen::Vector3d::Constant(NAN);
  double plastic_increment;  ///< sqrt(2/3) |deviator of the plastic strain increment|
  double residual_stiffness; ///< fraction of the elastic tangent that the solver's tangent should add
  Status status;
};

/// Trial stresses outside the yield surface by no more than this strain times 2 shear are elastic: round-off in
/// exp(2 eps) and its logarithm must not decide whether a point at rest on the surface yields.
constexpr double yield_tolerance = 1e-14;

/// Apparent cohesion over Young's modulus: the least cohesion of the frictional laws. It moves the apex of a
/// cohesionless soil off zero stress (1 Pa at 10 MPa), so that a free-falling or unstressed point is elastic.
constexpr double apparent_cohesion = 1e-7;

/// At the apex the stress does not depend on the strain; a solver's tangent keeps this fraction of the elastic one, so
/// that rows of nodes which see only such points are not singular. The stress is unaffected.
constexpr double apex_stiffness = 1e-3;

KEDGE_FUNCTION double effective_cohesion(const double cohesion, const double young)
{
  return std::fmax(cohesion, apparent_cohesion * young);
}

template <bool with_tangent>
KEDGE_FUNCTION Response elastic_response(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity)
{
  Response response;
  response.stress = elasticity.stress(trial_strain);
  response.elastic_strain = trial_strain;
  if constexpr (with_tangent)
  {
    response.tangent = elasticity.tangent();
    response.shear_stiffness = Eigen::Vector3d::Constant(2. * elasticity.shear);
  }
  response.plastic_increment = 0.;
  response.residual_stiffness = 0.;
  response.status = Status::elastic;
  return response;
}

/// The isotropic stress `mean_stress` (Pa), whatever the trial strain.
template <bool with_tangent>
KEDGE_FUNCTION Response apex_response(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity,
                                      const double mean_stress)
{
  const double mean_strain = (trial_strain[0] + trial_strain[1] + trial_strain[2]) / 3.;
  const double x = trial_strain[0] - mean_strain, y = trial_strain[1] - mean_strain, z = trial_strain[2] - mean_strain;
  Response response;
  response.stress = Eigen::Vector3d::Constant(mean_stress);
  response.elastic_strain = Eigen::Vector3d::Constant(mean_stress / (3. * elasticity.bulk()));
  if constexpr (with_tangent)
  {
    response.tangent = Eigen::Matrix3d::Zero();
    response.shear_stiffness = Eigen::Vector3d::Zero();
  }
  response.plastic_increment = std::sqrt(2. / 3. * (x * x + y * y + z * z));
  response.residual_stiffness = apex_stiffness;
  response.status = Status::apex;
  return response;
}
} // namespace kedge
