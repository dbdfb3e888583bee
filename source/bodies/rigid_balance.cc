#include <Eigen/LU>
#include <algorithm>
#include <kedge/bodies/rigid_balance.h>
#include <limits>

namespace kedge
{
using Matrix6 = Eigen::Matrix<double, 6, 6>;

std::vector<FreeDof> free_dofs(const RigidSystems& systems)
{
  std::vector<FreeDof> dofs;
  for (unsigned int point = 0; point < systems.points.size(); ++point)
    for (unsigned int dof = 0; dof < 6; ++dof)
      if (systems.points[point].is_free(dof))
        dofs.push_back({point, dof});
  return dofs;
}

Matrix6 generalised_map(const Vector6& increment)
{
  Matrix6 map = Matrix6::Identity();
  map.bottomRightCorner<3, 3>() = rotation_tangent(increment.tail<3>());
  return map;
}

namespace
{
/// The balance over all dofs, six per point. rigid_balance() then picks the free ones.
struct FullBalance
{
  Eigen::VectorXd force, magnitude, round_off;
  Eigen::MatrixXd tangent;

  explicit FullBalance(const std::size_t n)
      : force(Eigen::VectorXd::Zero(n)), magnitude(force), round_off(force), tangent(Eigen::MatrixXd::Zero(n, n))
  {
  }
};

/// Inertia, weight and load of one point.
void add_point(const RigidPoint& point, const RigidStep& step, const Vector6& increment, const Vector6& load,
               const unsigned int number, FullBalance& balance)
{
  const EndOfStep end = end_of_step(point, step, increment);
  Vector6 weight = Vector6::Zero();
  weight.head<3>() = point.mass * step.gravity;
  const Vector6 force = end.momentum_rate - weight - load;
  const Matrix6 map = generalised_map(increment);
  const unsigned int first = 6 * number;
  balance.force.segment<6>(first) += map.transpose() * force;
  balance.tangent.block<6, 6>(first, first) += map.transpose() * end.rate_tangent;
  balance.tangent.block<3, 3>(first + 3, first + 3) += generalised_moment_tangent(increment.tail<3>(), force.tail<3>());

  const double per_second = step.dt > 0. ? 1. / (std::min(1., step.gamma) * step.dt) : 0.;
  const Vector6 before = momentum(point);
  for (unsigned int part = 0; part < 6; part += 3)
  {
    const auto norm = [&](const Vector6& vector) { return vector.segment<3>(part).norm(); };
    const double change = per_second * (norm(end.momentum) + norm(before));
    balance.magnitude.segment<3>(first + part).array() += norm(end.momentum_rate) + norm(weight) + norm(load);
    balance.round_off.segment<3>(first + part).array() += std::numeric_limits<double>::epsilon() * change;
  }
}

void add_joint(const Joint& joint, const RigidSystems& systems, const std::vector<Vector6>& increments,
               FullBalance& balance)
{
  const auto [a, b] = joint.points;
  const JointResponse response =
      evaluate_joint(joint, {systems.points[a].pose, systems.points[b].pose}, {increments[a], increments[b]});
  for (unsigned int i = 0; i < 2; ++i)
  {
    const unsigned int row = 6 * joint.points[i];
    balance.force.segment<6>(row) += response.force.segment<6>(6 * i);
    for (unsigned int j = 0; j < 2; ++j)
      balance.tangent.block<6, 6>(row, 6 * joint.points[j]) += response.tangent.block<6, 6>(6 * i, 6 * j);
    for (unsigned int part = 0; part < 2; ++part)
    {
      balance.magnitude.segment<3>(row + 3 * part).array() += response.magnitude[i][part];
      balance.round_off.segment<3>(row + 3 * part).array() += response.round_off[i][part];
    }
  }
}
} // namespace

RigidBalance rigid_balance(const RigidSystems& systems, const RigidStep& step, const std::vector<Vector6>& increments,
                           const BodyLoads& loads)
{
  FullBalance full(6 * systems.points.size());
  for (unsigned int i = 0; i < systems.points.size(); ++i)
    add_point(systems.points[i], step, increments[i], loads.empty() ? Vector6(Vector6::Zero()) : loads[i], i, full);
  for (const Joint& joint : systems.joints)
    add_joint(joint, systems, increments, full);
  Eigen::VectorXd moved(full.force.size());
  for (unsigned int i = 0; i < systems.points.size(); ++i)
    moved.segment<6>(6 * i) = increments[i].cwiseAbs();
  full.round_off += std::numeric_limits<double>::epsilon() * (full.tangent.cwiseAbs() * moved);

  RigidBalance balance;
  for (unsigned int i = 0; i < systems.points.size(); ++i)
    balance.force.push_back(full.force.segment<6>(6 * i));
  std::vector<int> rows;
  for (const FreeDof& free : free_dofs(systems))
    rows.push_back(6 * free.point + free.dof);
  balance.residual = full.force(rows);
  balance.tangent = full.tangent(rows, rows);
  balance.magnitude = full.magnitude(rows);
  balance.round_off = full.round_off(rows);
  return balance;
}

std::vector<Vector6> rigid_reactions(const RigidSystems& systems, const RigidBalance& balance,
                                     const std::vector<Vector6>& increments)
{
  std::vector<Vector6> reactions;
  for (std::size_t i = 0; i < systems.points.size(); ++i)
  {
    Vector6 reaction = generalised_map(increments[i]).transpose().inverse() * balance.force[i];
    for (unsigned int dof = 0; dof < 6; ++dof)
      if (systems.points[i].is_free(dof))
        reaction[dof] = 0.;
    reactions.push_back(reaction);
  }
  return reactions;
}
} // namespace kedge
