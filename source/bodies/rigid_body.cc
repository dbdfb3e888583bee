#include <cmath>
#include <kedge/bodies/rigid_body.h>

namespace kedge
{
Eigen::Matrix3d skew(const Eigen::Vector3d& a)
{
  Eigen::Matrix3d matrix;
  matrix << 0., -a[2], a[1], a[2], 0., -a[0], -a[1], a[0], 0.;
  return matrix;
}

Eigen::Quaterniond rotation_from_vector(const Eigen::Vector3d& theta)
{
  const double half = theta.norm() / 2.;
  const double sinc = half < 1e-4 ? 1. - half * half / 6. : std::sin(half) / half;
  const Eigen::Vector3d imaginary = sinc / 2. * theta;
  return {std::cos(half), imaginary[0], imaginary[1], imaginary[2]};
}

Eigen::Vector3d vector_from_rotation(const Eigen::Quaterniond& rotation)
{
  // q and -q are the same rotation: take the shorter way.
  const double sign = rotation.w() < 0. ? -1. : 1.;
  const double sine = rotation.vec().norm();
  if (sine < 1e-10)
    return 2. * sign * rotation.vec();
  return 2. * sign * std::atan2(sine, sign * rotation.w()) / sine * rotation.vec();
}

Eigen::Matrix3d rotation_tangent(const Eigen::Vector3d& theta)
{
  const double angle = theta.norm(), square = angle * angle;
  // Below the switch the closed forms lose digits to cancellation and the next term of the series is below round-off.
  const bool small = angle < 1e-2;
  const double b = small ? 0.5 - square / 24. + square * square / 720. : (1. - std::cos(angle)) / square;
  const double c =
      small ? 1. / 6. - square / 120. + square * square / 5040. : (angle - std::sin(angle)) / (square * angle);
  const Eigen::Matrix3d turn = skew(theta);
  return Eigen::Matrix3d::Identity() + b * turn + c * turn * turn;
}

Pose Pose::moved(const Vector6& increment) const
{
  // Normalising here keeps R orthogonal over any number of steps.
  return {position + increment.head<3>(), (rotation_from_vector(increment.tail<3>()) * rotation).normalized()};
}

Eigen::Matrix<double, 3, 6> motion_tangent(const Pose& start, const Vector6& increment, const Eigen::Vector3d& X)
{
  const Eigen::Vector3d arm = start.moved(increment).direction_to_world(X);
  Eigen::Matrix<double, 3, 6> tangent;
  tangent.leftCols<3>().setIdentity();
  tangent.rightCols<3>() = -skew(arm) * rotation_tangent(increment.tail<3>());
  return tangent;
}

RigidPoint::RigidPoint(const PointParameters& parameters, const std::array<double, 3>& offset, unsigned int dim)
    : mass(parameters.mass)
{
  const auto& p = parameters.position;
  if (dim == 3)
  {
    pose.position = {p[0] + offset[0], p[1] + offset[1], p[2] + offset[2]};
    inertia = {parameters.inertia[0], parameters.inertia[1], parameters.inertia[2]};
    conditions = parameters.conditions;
    return;
  }
  pose.position = {p[0] + offset[0], 0., p[1] + offset[1]};
  inertia = Eigen::Vector3d::Constant(parameters.inertia[0]);
  conditions.fill({DofCondition::Kind::fixed, 0.});
  conditions[0] = parameters.conditions[0];
  conditions[2] = parameters.conditions[1];
  conditions[4] = parameters.conditions[2];
}

unsigned int RigidPoint::n_free_dofs() const
{
  unsigned int n = 0;
  for (unsigned int dof = 0; dof < 6; ++dof)
    n += is_free(dof);
  return n;
}

Eigen::Matrix3d RigidPoint::world_inertia() const
{
  const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
  return R * inertia.asDiagonal() * R.transpose();
}

Vector6 RigidPoint::prescribed_increment(double fraction) const
{
  Vector6 increment = Vector6::Zero();
  for (unsigned int dof = 0; dof < 6; ++dof)
    if (conditions[dof].kind == DofCondition::Kind::prescribed)
      increment[dof] = fraction * conditions[dof].increment;
  return increment;
}
} // namespace kedge
