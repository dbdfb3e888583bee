// Newton's method for rigid points without soil.
#pragma once

#include <kedge/bodies/rigid_balance.h>
#include <string>
#include <vector>

namespace kedge
{
struct RigidSolution
{
  bool converged = false;
  unsigned int iterations = 0;     ///< linear systems solved
  std::vector<Vector6> increments; ///< of all points
  RigidBalance balance;            ///< at these increments
  std::string failure;             ///< why it did not converge; empty if it did
};

/// Finds the increments of a step; starts from start_increments() and commits nothing. It has converged when each
/// residual is below `tolerance` times the terms that it sums. It fails, and names the dof, if a load acts on a dof
/// that has neither stiffness nor inertia.
RigidSolution solve_rigid_motion(const RigidSystems& systems, const RigidStep& step, const BodyLoads& loads = {},
                                 double tolerance = 1e-8, unsigned int max_iterations = 20);

/// Name of a dof that can move without resistance, such as "point 2 of system 1, about y". Empty if the tangent is
/// regular.
std::string unsupported_dof(const RigidSystems& systems, const RigidBalance& balance);
} // namespace kedge
