#include <algorithm>
#include <cmath>
#include <kedge/bodies/explicit_motion.h>
#include <kedge/bodies/rigid_newton.h>

namespace kedge
{
namespace
{
/// What joints would have of energy, beyond a quadratic function of the motion, if their points went on without them
/// for a part of a drift: over the energy of motion and joints of their system.
constexpr double most_bent = 1e-6;
constexpr double most_parts = 256.;
} // namespace

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

void ExplicitMotion::kick(const BodyLoads& loads, const double time)
{
  for (std::size_t i = 0; i < loads.size(); ++i)
    if (RigidPoint& point = moving.points[i]; point.n_free_dofs() > 0)
      apply_impulse(point, time * loads[i]);
}

unsigned int ExplicitMotion::count_parts(const Eigen::Vector3d& gravity, const double fraction, const double time) const
{
  if (moving.joints.empty())
    return 1;
  const std::size_t n_systems = std::max<std::size_t>(1, moving.first_point.size());
  std::vector<double> energy(n_systems, 0.), bent(n_systems, 0.);
  std::vector<Vector6> alone;
  for (std::size_t i = 0; i < moving.points.size(); ++i)
  {
    const RigidPoint& point = moving.points[i];
    alone.push_back(point.prescribed_increment(fraction));
    for (unsigned int d = 0; d < 6; ++d)
      if (point.is_free(d))
        alone[i][d] = time * (point.velocity[d] + (d < 3 ? 0.5 * time * gravity[d] : 0.));
    if (point.n_free_dofs() > 0)
      energy[system_of(moving, i)] += 0.5 * momentum(point).dot(point.velocity);
  }
  for (const Joint& joint : moving.joints)
  {
    const auto [a, b] = joint.points;
    const std::array<Pose, 2> poses{moving.points[a].pose, moving.points[b].pose};
    const JointResponse now = evaluate_joint(joint, poses, {Vector6::Zero(), Vector6::Zero()});
    Vector12 both;
    both << alone[a], alone[b];
    const double quadratic = now.energy + both.dot(now.force + 0.5 * now.tangent * both);
    energy[system_of(moving, a)] += now.energy;
    bent[system_of(moving, a)] += std::abs(evaluate_joint(joint, poses, {alone[a], alone[b]}).energy - quadratic);
  }
  double parts = 1.;
  for (std::size_t s = 0; s < n_systems; ++s)
    if (bent[s] > most_bent * energy[s])
      parts = std::max(parts, std::pow(bent[s] / (most_bent * energy[s]), 0.25));
  return std::ceil(std::min(parts, most_parts));
}

std::string ExplicitMotion::drift(const Eigen::Vector3d& gravity, const double fraction, const double time)
{
  const unsigned int n_parts = count_parts(gravity, fraction, time);
  RigidStep step;
  step.gravity = gravity;
  step.fraction = fraction / n_parts;
  step.dt = time / n_parts;
  passed += time;
  for (unsigned int i = 0; i < n_parts; ++i)
  {
    RigidStep part = step;
    if (!knows_accelerations) // RigidStep explains this pair
    {
      part.beta = 0.5;
      part.gamma = 1.;
    }
    knows_accelerations = true;
    const RigidSolution solution = solve_rigid_motion(moving, part);
    if (!solution.converged)
      return solution.failure;
    commit_increments(moving, part, solution.increments);
  }
  return "";
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
