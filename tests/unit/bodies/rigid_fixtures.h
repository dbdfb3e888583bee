// Points and joints for small mechanisms.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <kedge/bodies/rigid_newton.h>

namespace kedge::test
{
inline constexpr double gravity = 9.81; ///< m/s2

inline Vector6 increment(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation)
{
  Vector6 both;
  both << translation, rotation;
  return both;
}

/// A point, free or held in all dofs.
inline PointParameters point_at(const std::array<double, 3>& position, bool free, double mass = 1.,
                                const std::array<double, 3>& inertia = {1., 1., 1.})
{
  PointParameters point;
  point.position = position;
  point.mass = mass;
  point.inertia = inertia;
  point.conditions.fill({free ? DofCondition::Kind::free : DofCondition::Kind::fixed, 0.});
  return point;
}

inline JointParameters ball(const std::array<double, 3>& at, double stiffness)
{
  JointParameters joint;
  joint.type = JointType::ball;
  joint.position_1 = joint.position_2 = at;
  joint.stiffness = stiffness;
  return joint;
}

/// A hinge about y.
inline JointParameters hinge(const std::array<double, 3>& at, double stiffness, double rotational_stiffness)
{
  JointParameters joint;
  joint.type = JointType::hinge;
  joint.rotation_centre = at;
  joint.direction_1 = joint.direction_2 = {0., 1., 0.};
  joint.stiffness = stiffness;
  joint.rotational_stiffness = rotational_stiffness;
  return joint;
}

inline JointParameters rod(const std::array<double, 3>& from, const std::array<double, 3>& to, double length,
                           double stiffness)
{
  JointParameters joint;
  joint.type = JointType::rod;
  joint.position_1 = from;
  joint.position_2 = to;
  joint.distance = length;
  joint.stiffness = stiffness;
  return joint;
}

/// A stop whose anchors start at one place.
inline JointParameters stop(const std::array<double, 3>& centre, const std::array<double, 3>& anchor, double limit,
                            double stiffness)
{
  JointParameters joint = ball(anchor, stiffness);
  joint.type = JointType::stop;
  joint.rotation_centre = centre;
  joint.angle_limit = limit;
  return joint;
}

/// One system of points, with joints between points 1 and 2, 2 and 3 and so on in the order given.
inline RigidSystems chain(const std::vector<PointParameters>& points, std::vector<JointParameters> joints,
                          unsigned int dim = 3)
{
  SystemParameters system;
  system.points = points;
  for (unsigned int i = 0; i < joints.size(); ++i)
    joints[i].points = {i + 1, i + 2};
  system.joints = joints;
  return make_rigid_systems({system}, dim);
}

/// A dynamic step with gravity along -z.
inline RigidStep dynamic_step(double dt, double beta, double gamma, double g = gravity)
{
  RigidStep step;
  step.gravity = {0., 0., -g};
  step.dt = dt;
  step.beta = beta;
  step.gamma = gamma;
  return step;
}

/// Takes a step, which must converge; returns the solution that was committed.
inline RigidSolution advance(RigidSystems& systems, const RigidStep& step, const BodyLoads& loads = {})
{
  RigidSolution solution = solve_rigid_motion(systems, step, loads);
  EXPECT_TRUE(solution.converged) << solution.failure;
  commit_increments(systems, step, solution.increments);
  return solution;
}

/// Takes many steps, from rest at t = 0 with unknown accelerations. The first step is Euler's, which does not need them
/// and keeps the order of convergence. Returns the most iterations of a step.
inline unsigned int advance(RigidSystems& systems, const RigidStep& step, unsigned int n_steps,
                            const std::function<void(double time)>& after = {})
{
  unsigned int most = 0;
  for (unsigned int i = 0; i < n_steps; ++i)
  {
    RigidStep this_step = step;
    if (i == 0)
      this_step.beta = 0.5, this_step.gamma = 1.;
    most = std::max(most, advance(systems, this_step).iterations);
    if (after)
      after((i + 1) * step.dt);
  }
  return most;
}

/// J
inline double kinetic_energy(const RigidPoint& point) { return point.velocity.dot(momentum(point)) / 2.; }

/// Kinetic energy, energy of the joints and of the weight (zero at z = 0), J.
inline double energy(const RigidSystems& systems, const Eigen::Vector3d& g)
{
  double sum = 0.;
  for (const RigidPoint& point : systems.points)
    sum += kinetic_energy(point) - point.mass * g.dot(point.pose.position);
  for (const Joint& joint : systems.joints)
    sum += evaluate_joint(joint, {systems.points[joint.points[0]].pose, systems.points[joint.points[1]].pose},
                          {Vector6::Zero(), Vector6::Zero()})
               .energy;
  return sum;
}

/// Momentum, and angular momentum about the origin, of all points.
inline Vector6 total_momentum(const RigidSystems& systems)
{
  Vector6 sum = Vector6::Zero();
  for (const RigidPoint& point : systems.points)
  {
    const Vector6 own = momentum(point);
    sum += own;
    sum.tail<3>() += point.pose.position.cross(own.head<3>());
  }
  return sum;
}

/// Angle (rad) by which a point has turned about +y since it was made.
inline double turned_about_y(const RigidPoint& point)
{
  return 2. * std::atan2(point.pose.rotation.y(), point.pose.rotation.w());
}
} // namespace kedge::test
