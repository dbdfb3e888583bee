// Where a rigid body is and what acts on it, as kernels and those who call them know it.
#pragma once

#include <Eigen/Core>
#include <kedge/base/kokkos.h>
#include <vector>

namespace kedge
{
/// Three translations (m) and the rotation vector (rad), both along world axes.
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Force (N) and moment (N m) on each rigid point, world axes; the moment is about its position at the end of the step.
using BodyLoads = std::vector<Vector6>;
/// Derivatives of each of them by velocity and spin of its rigid point.
using BodyTangents = std::vector<Eigen::Matrix<double, 6, 6>>;

/// Matrix of the cross product: skew(a) b = a x b.
KEDGE_FUNCTION Eigen::Matrix3d skew(const Eigen::Vector3d& a)
{
  Eigen::Matrix3d result;
  result << 0., -a[2], a[1], a[2], 0., -a[0], -a[1], a[0], 0.;
  return result;
}

/// The body-frame point X lies at x = position + R X. A Pose in numbers that host and device align alike.
struct Frame
{
  Eigen::Vector3d position; ///< m
  Eigen::Matrix3d rotation; ///< R

  KEDGE_FUNCTION Eigen::Vector3d to_world(const Eigen::Vector3d& X) const { return position + rotation * X; }
  KEDGE_FUNCTION Eigen::Vector3d to_body(const Eigen::Vector3d& x) const
  {
    return rotation.transpose() * (x - position);
  }
  /// Directions turn but do not move.
  KEDGE_FUNCTION Eigen::Vector3d direction_to_world(const Eigen::Vector3d& D) const { return rotation * D; }
  KEDGE_FUNCTION Eigen::Vector3d direction_to_body(const Eigen::Vector3d& d) const { return rotation.transpose() * d; }
};
} // namespace kedge
