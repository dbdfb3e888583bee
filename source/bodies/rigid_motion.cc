#include <Eigen/LU>
#include <kedge/bodies/rigid_motion.h>

namespace kedge
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Rate of change of the momentum of a point as it stands, N and N m (Euler's equation in world axes).
Vector6 momentum_rate(const RigidPoint& point)
{
  const Vector3d spin = point.velocity.tail<3>();
  Vector6 rate;
  rate << point.mass * point.acceleration.head<3>(),
      point.world_inertia() * point.acceleration.tail<3>() + spin.cross(momentum(point).tail<3>());
  return rate;
}

/// Angular acceleration of a body at the pose `end`, world axes, rad/s2.
Vector3d angular_acceleration(const RigidPoint& point, const Pose& end, const Vector3d& spin, const Vector3d& momentum,
                              const Vector3d& rate)
{
  Vector3d moment = end.direction_to_body(rate - spin.cross(momentum));
  for (unsigned int axis = 0; axis < 3; ++axis)
    moment[axis] = point.inertia[axis] > 0. ? moment[axis] / point.inertia[axis] : 0.;
  return end.direction_to_world(moment);
}
} // namespace

Vector6 momentum(const RigidPoint& point)
{
  Vector6 p;
  p << point.mass * point.velocity.head<3>(), point.world_inertia() * point.velocity.tail<3>();
  return p;
}

void apply_impulse(RigidPoint& point, const Vector6& impulse)
{
  const Vector6 rate = momentum_rate(point);
  // Rotations that are not free drop out of the system: their rows and columns become those of the identity.
  Matrix3d inertia = point.world_inertia();
  Vector3d moment = impulse.tail<3>();
  for (unsigned int axis = 0; axis < 3; ++axis)
  {
    if (point.is_free(axis))
      point.velocity[axis] += impulse[axis] / point.mass;
    if (point.is_free(3 + axis))
      continue;
    moment[axis] = 0.;
    inertia.row(axis).setZero();
    inertia.col(axis).setZero();
    inertia(axis, axis) = 1.;
  }
  point.velocity.tail<3>() += inertia.partialPivLu().solve(moment);
  point.acceleration.tail<3>() =
      angular_acceleration(point, point.pose, point.velocity.tail<3>(), momentum(point).tail<3>(), rate.tail<3>());
}

std::vector<Vector6> start_increments(const RigidSystems& systems, const RigidStep& step)
{
  std::vector<Vector6> increments;
  for (const RigidPoint& point : systems.points)
    increments.push_back(point.prescribed_increment(step.fraction));
  return increments;
}

std::vector<Vector6> predicted_increments(const RigidSystems& systems, const RigidStep& step)
{
  std::vector<Vector6> increments = start_increments(systems, step);
  for (std::size_t i = 0; i < systems.points.size(); ++i)
    for (unsigned int dof = 0; dof < 6; ++dof)
      if (systems.points[i].is_free(dof))
        increments[i][dof] = step.fraction * systems.points[i].last_increment[dof];
  return increments;
}

EndOfStep end_of_step(const RigidPoint& point, const RigidStep& step, const Vector6& increment)
{
  EndOfStep end{Vector6::Zero(), Vector6::Zero(), Vector6::Zero(), Vector6::Zero(), Matrix6::Zero()};
  if (step.dt <= 0.)
    return end;
  const double dt = step.dt, ratio = step.gamma / step.beta;
  // In the axes of the start, the velocity is by_increment * increment + known. Rates are
  // (change - (1 - gamma) dt rate before) / (gamma dt).
  Vector6 by_increment = Vector6::Constant(1. / dt), known = Vector6::Zero(), gamma = Vector6::Ones();
  for (unsigned int dof = 0; dof < 6; ++dof)
    if (point.is_free(dof))
    {
      by_increment[dof] = ratio / dt;
      known[dof] = (1. - ratio) * point.velocity[dof] + dt * (1. - ratio / 2.) * point.acceleration[dof];
      gamma[dof] = step.gamma;
    }
  const Vector6 convected = by_increment.cwiseProduct(increment) + known;
  const Vector6 by_change = (gamma * dt).cwiseInverse(), by_rate = gamma.cwiseInverse() - Vector6::Ones();

  // Velocity and momentum in world axes, and their rates.
  const Vector3d theta = increment.tail<3>();
  const Matrix3d turn = rotation_from_vector(theta).toRotationMatrix(), inertia = point.world_inertia();
  end.velocity << convected.head<3>(), turn * convected.tail<3>();
  end.momentum << point.mass * convected.head<3>(), turn * inertia * convected.tail<3>();
  end.momentum_rate =
      by_change.cwiseProduct(end.momentum - momentum(point)) - by_rate.cwiseProduct(momentum_rate(point));
  end.acceleration.head<3>() = by_change.head<3>().cwiseProduct(end.velocity.head<3>() - point.velocity.head<3>()) -
                               by_rate.head<3>().cwiseProduct(point.acceleration.head<3>());
  end.acceleration.tail<3>() = angular_acceleration(point, point.pose.moved(increment), end.velocity.tail<3>(),
                                                    end.momentum.tail<3>(), end.momentum_rate.tail<3>());

  // d momentum_rate / d increment: the inertia turns with the body, hence the term with the angular momentum.
  end.rate_tangent.topLeftCorner<3, 3>() = (point.mass * by_increment.head<3>()).asDiagonal();
  end.rate_tangent.bottomRightCorner<3, 3>() =
      turn * inertia * by_increment.tail<3>().asDiagonal() - skew(end.momentum.tail<3>()) * rotation_tangent(theta);
  end.rate_tangent = by_change.asDiagonal() * end.rate_tangent;
  return end;
}

void commit_increments(RigidSystems& systems, const RigidStep& step, const std::vector<Vector6>& increments)
{
  for (std::size_t i = 0; i < systems.points.size(); ++i)
  {
    RigidPoint& point = systems.points[i];
    const EndOfStep end = end_of_step(point, step, increments[i]);
    point.velocity = end.velocity;
    point.acceleration = point.reported_acceleration = end.acceleration;
    point.pose = point.pose.moved(increments[i]);
    point.last_increment = increments[i] / step.fraction;
  }
}
} // namespace kedge
