#include <cmath>
#include <kedge/bodies/rigid_body.h>

namespace kedge
{
namespace
{
/// Coefficients of T = I + b S + c S^2, S = skew(theta), and their changes with the angle over the angle.
struct TangentCoefficients
{
  double b = 0., c = 0., b_change = 0., c_change = 0.;
};

TangentCoefficients tangent_coefficients(const double angle)
{
  const double square = angle * angle;
  TangentCoefficients sum;
  // Small angles: the closed forms lose digits to cancellation, and nine terms of the series are exact to round-off.
  if (angle < 0.5)
  {
    double b = 1. / 2., c = 1. / 6., power = 1., previous = 0.; // coefficients, angle^(2k), angle^(2k-2)
    for (int k = 0; k < 9; ++k)
    {
      sum.b += b * power;
      sum.c += c * power;
      sum.b_change += 2 * k * b * previous;
      sum.c_change += 2 * k * c * previous;
      previous = power;
      power *= square;
      b /= -(2 * k + 3) * (2 * k + 4);
      c /= -(2 * k + 4) * (2 * k + 5);
    }
    return sum;
  }
  const double sine = std::sin(angle), cosine = std::cos(angle), fourth = square * square;
  sum.b = (1. - cosine) / square;
  sum.c = (angle - sine) / (square * angle);
  sum.b_change = (angle * sine - 2. * (1. - cosine)) / fourth;
  sum.c_change = (3. * sine - 2. * angle - angle * cosine) / (fourth * angle);
  return sum;
}
} // namespace

Eigen::Vector3d to_world_axes(const std::array<double, 3>& vector, const unsigned int dim)
{
  return dim == 3 ? Eigen::Vector3d(vector[0], vector[1], vector[2]) : Eigen::Vector3d(vector[0], 0., vector[1]);
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
  // q and -q are the same rotation: take the smaller angle.
  const double sign = rotation.w() < 0. ? -1. : 1.;
  const double sine = rotation.vec().norm();
  if (sine < 1e-10)
    return 2. * sign * rotation.vec();
  return 2. * sign * std::atan2(sine, sign * rotation.w()) / sine * rotation.vec();
}

Eigen::Matrix3d rotation_tangent(const Eigen::Vector3d& theta)
{
  const TangentCoefficients t = tangent_coefficients(theta.norm());
  const Eigen::Matrix3d turn = skew(theta);
  return Eigen::Matrix3d::Identity() + t.b * turn + t.c * turn * turn;
}

Eigen::Matrix3d generalised_moment_tangent(const Eigen::Vector3d& theta, const Eigen::Vector3d& m)
{
  const TangentCoefficients t = tangent_coefficients(theta.norm());
  const Eigen::Vector3d once = theta.cross(m), twice = theta.cross(once);
  return t.b * skew(m) - t.c * (skew(once) + skew(theta) * skew(m)) +
         (t.c_change * twice - t.b_change * once) * theta.transpose();
}

Pose Pose::moved(const Vector6& increment) const
{
  // Normalising here keeps R orthogonal over any number of steps.
  return {position + increment.head<3>(), (rotation_from_vector(increment.tail<3>()) * rotation).normalized()};
}

Vector6 increment_between(const Pose& start, const Pose& end)
{
  Vector6 increment;
  increment << end.position - start.position, vector_from_rotation(end.rotation * start.rotation.conjugate());
  return increment;
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
  pose.position = to_world_axes(parameters.position, dim) + to_world_axes(offset, dim);
  if (dim == 3)
  {
    inertia = {parameters.inertia[0], parameters.inertia[1], parameters.inertia[2]};
    conditions = parameters.conditions;
    return;
  }
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
