// Position and finite rotation of rigid points, and their prescribed motion. Rotations are increments about world axes:
// R_new = exp(theta) R_old.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <kedge/bodies/frame.h>
#include <kedge/bodies/parameters.h>
#include <vector>

namespace kedge
{
/// Turns a vector of the input into world axes. Plane strain lies in the plane y = 0, and its vectors are [x, z].
Eigen::Vector3d to_world_axes(const std::array<double, 3>& vector, unsigned int dim);

/// Rotation by |theta| about theta (exponential map), rad.
Eigen::Quaterniond rotation_from_vector(const Eigen::Vector3d& theta);

/// Inverse of rotation_from_vector; |theta| <= pi.
Eigen::Vector3d vector_from_rotation(const Eigen::Quaterniond& rotation);

/// T(theta) in d exp(theta) = skew(T d theta) exp(theta): turns a change of the rotation vector into a spin
/// (Simo & Vu-Quoc 1988, doi 10.1016/0045-7825(88)90073-4).
Eigen::Matrix3d rotation_tangent(const Eigen::Vector3d& theta);

/// d (T(theta)^T m) / d theta at constant m: how the generalised moment of a constant moment m (N m, world axes)
/// changes with the rotation vector. Derivative of T = I + b skew(theta) + c skew(theta)^2 term by term.
Eigen::Matrix3d generalised_moment_tangent(const Eigen::Vector3d& theta, const Eigen::Vector3d& m);

/// Where a rigid point is: a body-frame point X lies at x = position + R X.
struct Pose
{
  Eigen::Vector3d position = Eigen::Vector3d::Zero();           ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity(); ///< unit

  Eigen::Vector3d to_world(const Eigen::Vector3d& X) const { return position + rotation * X; }
  Eigen::Vector3d to_body(const Eigen::Vector3d& x) const { return rotation.conjugate() * (x - position); }
  /// Directions turn but do not move.
  Eigen::Vector3d direction_to_world(const Eigen::Vector3d& D) const { return rotation * D; }
  Eigen::Vector3d direction_to_body(const Eigen::Vector3d& d) const { return rotation.conjugate() * d; }

  Frame frame() const { return {position, rotation.toRotationMatrix()}; }

  /// The pose after an increment; this one stays as it is.
  Pose moved(const Vector6& increment) const;
};

/// The increment for which `start.moved()` gives `end`. It turns by at most half a turn.
Vector6 increment_between(const Pose& start, const Pose& end);

/// Change of the world position of a body-frame point with the increment, d moved(increment).to_world(X) / d increment.
Eigen::Matrix<double, 3, 6> motion_tangent(const Pose& start, const Vector6& increment, const Eigen::Vector3d& X);

/// A rigid point: where it is, how it moves, how heavy it is and what holds it.
struct RigidPoint
{
  RigidPoint() = default;
  /// From the input, moved by the offset of its system. In 2-D vectors are [x, z], the conditions are x, z and about y,
  /// and the first moment of inertia is the one about y; everything out of the plane is fixed.
  RigidPoint(const PointParameters& parameters, const std::array<double, 3>& offset, unsigned int dim);

  Pose pose;
  Vector6 last_increment = Vector6::Zero();          ///< last increment, scaled to a requested step, m, rad
  Vector6 velocity = Vector6::Zero();                ///< m/s, rad/s, world axes
  Vector6 acceleration = Vector6::Zero();            ///< m/s2, rad/s2, world axes
  Vector6 reported_acceleration = Vector6::Zero();   ///< the same for files: explicit steps split it and keep a part
  double mass = 0.;                                  ///< kg
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero(); ///< principal moments in the body frame, kg m2
  std::array<DofCondition, 6> conditions;            ///< x, y, z, about x, y, z

  bool is_free(unsigned int dof) const { return conditions[dof].kind == DofCondition::Kind::free; }
  unsigned int n_free_dofs() const;
  /// Inertia tensor in world axes, kg m2.
  Eigen::Matrix3d world_inertia() const;
  /// Prescribed part of the increment of a step that is `fraction` of an uncut one; zero for free and fixed dofs.
  Vector6 prescribed_increment(double fraction) const;
};
} // namespace kedge
