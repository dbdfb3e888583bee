// Balance of rigid points at the end of a step: inertia, weight, joints and given loads. The unknowns are the
// increments of the free dofs, and forces are conjugate to them.
#pragma once

#include <Eigen/Core>
#include <kedge/bodies/rigid_motion.h>
#include <vector>

namespace kedge
{
/// A dof that is an unknown: its point (from 0 over all systems) and its place in x, y, z, about x, y, z.
struct FreeDof
{
  unsigned int point, dof;
};

/// The unknowns, in the order of residual and tangent.
std::vector<FreeDof> free_dofs(const RigidSystems& systems);

/// Balance of all points at given increments.
struct RigidBalance
{
  std::vector<Vector6>
      force;                ///< inertia - weight - loads + joints, all dofs of each point, conjugate to its increments
  Eigen::VectorXd residual; ///< its free dofs, N and N m: zero when balanced
  Eigen::MatrixXd tangent;  ///< d residual / d increments of the free dofs
  /// For each free dof: magnitude of the terms that cancel in the residual, and the part that may be round-off.
  Eigen::VectorXd magnitude, round_off;

  /// What of a residual is likely round-off. The factor 8 stands for the few operations that each term goes through.
  double likely_round_off(const Eigen::Index free_dof) const { return 8. * round_off[free_dof]; }
};

/// Computes the balance. Empty `loads` stand for zero. The tangent takes loads as constant in world axes: if they
/// depend on the increments, the caller subtracts generalised_map()^T d load / d increments from it.
RigidBalance rigid_balance(const RigidSystems& systems, const RigidStep& step, const std::vector<Vector6>& increments,
                           const BodyLoads& loads = {});

/// diag(1, T(theta)): turns rates of the increment into velocity and spin at the end of the step. Its transpose turns
/// force and moment in world axes into the forces conjugate to the increments.
Eigen::Matrix<double, 6, 6> generalised_map(const Vector6& increment);

/// Force and moment that the conditions exert on each point, in world axes; zero on free dofs. The moment is about the
/// position of the point at the end of the step.
std::vector<Vector6> rigid_reactions(const RigidSystems& systems, const RigidBalance& balance,
                                     const std::vector<Vector6>& increments);
} // namespace kedge
