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

/// Finds the increments of a step from start_increments(). Converged when each residual is below `tolerance` times the
/// terms it is made of. A load on a dof that has neither stiffness nor inertia is a failure that names the dof. Commits
/// nothing.
RigidSolution solve_rigid_motion(const RigidSystems& systems, const RigidStep& step, const BodyLoads& loads = {},
                                 double tolerance = 1e-8, unsigned int max_iterations = 20);

/// Name of a dof that can move without resistance because the tangent is singular, such as "point 2 of system 1, about
/// y"; else empty.
std::string unsupported_dof(const RigidSystems& systems, const RigidBalance& balance);
} // namespace kedge
