#include <kedge/bodies/explicit_motion.h>
#include <kedge/bodies/rigid_newton.h>

namespace kedge
{
ExplicitMotion::ExplicitMotion(const RigidSystems& committed, const bool begins_stage)
    : knows_accelerations(!begins_stage)
{
  moving.points = committed.points;
  moving.first_point = committed.first_point;
  moving.joints = committed.joints;
  for (const RigidPoint& point : moving.points)
  {
    start.push_back(point.pose);
    start_momentum.push_back(momentum(point));
  }
}

void ExplicitMotion::kick(const BodyLoads& loads, const Eigen::Vector3d& gravity, const double time)
{
  for (std::size_t i = 0; i < moving.points.size(); ++i)
  {
    RigidPoint& point = moving.points[i];
    if (point.n_free_dofs() == 0)
      continue;
    Vector6 load = loads.empty() ? Vector6::Zero() : loads[i];
    load.head<3>() += point.mass * gravity;
    apply_impulse(point, time * load);
  }
}

std::string ExplicitMotion::drift(const double fraction, const double time)
{
  RigidStep step;
  step.fraction = fraction;
  step.dt = time;
  if (!knows_accelerations) // RigidStep explains this pair
  {
    step.beta = 0.5;
    step.gamma = 1.;
  }
  knows_accelerations = true;
  passed += time;
  const RigidSolution solution = solve_rigid_motion(moving, step);
  if (solution.converged)
    commit_increments(moving, step, solution.increments);
  return solution.failure;
}

std::vector<Vector6> ExplicitMotion::increments() const
{
  std::vector<Vector6> result;
  for (std::size_t i = 0; i < start.size(); ++i)
    result.push_back(increment_between(start[i], moving.points[i].pose));
  return result;
}

std::vector<Vector6> ExplicitMotion::momentum_rates() const
{
  std::vector<Vector6> result;
  for (std::size_t i = 0; i < start.size(); ++i)
    result.push_back((momentum(moving.points[i]) - start_momentum[i]) / passed);
  return result;
}

void ExplicitMotion::commit(RigidSystems& committed, const double fraction) const
{
  const std::vector<Vector6> moved = increments();
  for (std::size_t i = 0; i < start.size(); ++i)
  {
    RigidPoint& point = committed.points[i];
    const Vector6 before = point.velocity;
    point = moving.points[i];
    point.last_increment = moved[i] / fraction;
    point.reported_acceleration = (point.velocity - before) / passed;
  }
}
} // namespace kedge
