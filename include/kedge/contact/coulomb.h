// The law of one contact point: penalty in the normal direction, elastic stick and Coulomb slip across it, both from
// where multipliers have brought them.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <kedge/base/kokkos.h>

namespace kedge
{
struct ContactStiffness
{
  double normal, tangential; ///< N/m
  double friction;           ///< Coulomb coefficient
};

/// Where a soil point is relative to a body, and how it got there.
struct ContactGeometry
{
  double gap;                      ///< signed distance less the reference gap, m; negative: penetration
  double distance;                 ///< signed distance itself, m
  Eigen::Vector3d normal;          ///< unit, out of the body
  Eigen::Matrix3d normal_subspace; ///< 1 - the directions along which the closest point follows: n n^T on a face,
                                   ///< 1 - t t^T on an edge, 1 at a vertex
  Eigen::Vector3d slip;            ///< displacement of the soil point relative to the body in this step, m
};

/// Forces act on the soil, N.
struct ContactResponse
{
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d tangential = Eigen::Vector3d::Zero(); ///< tangential part, the history of the next step
  Eigen::Matrix3d tangent = Eigen::Matrix3d::Zero();    ///< d force / d soil point, N/m
  bool active = false, sliding = false;
};

/// Return mapping on the tangential force (Wriggers 2006, Computational Contact Mechanics, ch. 5; Bird et al. 2025,
/// arXiv:2412.01565). `previous` is the tangential force at the start of the step, already turned with the body, or its
/// multiplier; `multiplier` (N) is that of the normal force: the pressure of a corner that just touches.
KEDGE_FUNCTION ContactResponse respond_to_contact(const ContactGeometry& at, const ContactStiffness& stiffness,
                                                  const Eigen::Vector3d& previous, const double multiplier = 0.)
{
  ContactResponse response;
  const double pressure = multiplier - stiffness.normal * at.gap;
  if (!(pressure > 0.))
    return response;
  response.active = true;
  const Eigen::Vector3d& n = at.normal;
  const Eigen::Matrix3d across = n * n.transpose();
  const Eigen::Matrix3d along = Eigen::Matrix3d::Identity() - across;

  response.force = pressure * n;
  // the gap changes along n, and n turns where the closest point sits on an edge or vertex
  Eigen::Matrix3d turning = Eigen::Matrix3d::Zero(); // d n / d soil point
  if (std::fabs(at.distance) > 1e-14)
    turning = (at.normal_subspace - across) * (1. / at.distance);
  response.tangent = pressure * turning - stiffness.normal * across;

  if (stiffness.friction == 0.)
    return response;
  const Eigen::Vector3d elastic = previous - stiffness.tangential * at.slip, trial = along * elastic;
  const Eigen::Matrix3d trial_change =
      -(stiffness.tangential * along + n.dot(elastic) * turning + n * (turning * elastic).transpose());
  const double size = std::sqrt(trial.dot(trial)), limit = stiffness.friction * pressure;
  if (size <= limit)
  {
    response.tangential = trial;
    response.tangent += trial_change;
  }
  else
  {
    response.sliding = true;
    const Eigen::Vector3d direction = trial * (1. / size);
    response.tangential = limit * direction;
    response.tangent -= stiffness.friction * stiffness.normal * direction * n.transpose();
    response.tangent += (limit / size) * (trial_change - direction * (direction.transpose() * trial_change));
  }
  response.force += response.tangential;
  return response;
}
} // namespace kedge
