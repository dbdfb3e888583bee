// Balance of rigid points at the end of a step: inertia, weight, joints and given loads. The unknowns are the
// increments of the free dofs, and forces are conjugate to them.
#pragma once

#include <Eigen/Core>
#include <kedge/bodies/rigid_motion.h>
#include <vector>

namespace kedge
{
/// A dof that is an unknown: its point, from 0 over all systems, and which of x, y, z, about x, y, z.
struct FreeDof
{
  unsigned int point, dof;
};

/// The unknowns in the order of residual and tangent.
std::vector<FreeDof> free_dofs(const RigidSystems& systems);

/// Balance at given increments; no loads count as zero. Loads count as constant in world axes: a caller whose loads
/// depend on the increments subtracts generalised_map()^T d load / d increments from the tangent.
struct RigidBalance
{
  std::vector<Vector6>
      force;                ///< inertia - weight - loads + joints, all dofs of each point, conjugate to its increments
  Eigen::VectorXd residual; ///< its free dofs, N and N m: zero when balanced
  Eigen::MatrixXd tangent;  ///< d residual / d increments of the free dofs
  /// Of each free dof: magnitude of the terms that cancel in the residual, and how much of it may be round-off.
  Eigen::VectorXd magnitude, round_off;
};

RigidBalance rigid_balance(const RigidSystems& systems, const RigidStep& step, const std::vector<Vector6>& increments,
                           const BodyLoads& loads = {});

/// Turns increment rates into velocity and spin at the end of the step: diag(1, T(theta)). Its transpose takes force
/// and moment in world axes to the forces conjugate to the increments.
Eigen::Matrix<double, 6, 6> generalised_map(const Vector6& increment);

/// What the conditions exert on each point: force and moment (about the point where it stands at the end of the step)
/// in world axes; zero on free dofs.
std::vector<Vector6> rigid_reactions(const RigidSystems& systems, const RigidBalance& balance,
                                     const std::vector<Vector6>& increments);
} // namespace kedge
