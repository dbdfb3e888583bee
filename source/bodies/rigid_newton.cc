#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/bodies/rigid_newton.h>
#include <kedge/solvers/scaled_factors.h>

namespace kedge
{
namespace
{
/// Bound on each residual at convergence.
Eigen::VectorXd allowed_residual(const RigidBalance& balance, const double tolerance)
{
  Eigen::VectorXd allowed = tolerance * balance.magnitude;
  for (Eigen::Index i = 0; i < allowed.size(); ++i)
    allowed[i] += balance.likely_round_off(i);
  return allowed;
}

bool is_within(const Eigen::VectorXd& residual, const Eigen::VectorXd& allowed)
{
  return (residual.array().abs() <= allowed.array()).all();
}

/// tangent^-1 residual, and the part of the residual that no change of the increments can balance.
struct Correction
{
  Eigen::VectorXd change, unresisted;
};

Correction correction(const RigidBalance& balance)
{
  const ScaledFactors scaled(balance.tangent);
  // Bodies that do not touch must not affect each other by round-off. Elimination keeps them apart, orthogonal factors
  // do not, so these serve singular tangents only.
  if (scaled.is_regular())
    return {scaled.solve(balance.residual), Eigen::VectorXd::Zero(balance.residual.size())};
  const Eigen::VectorXd residual = scaled.scaling.cwiseProduct(balance.residual);
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors;
  factors.setThreshold(ScaledFactors::singular_pivot);
  factors.compute(scaled.matrix);
  const Eigen::VectorXd shortest = factors.solve(residual);
  return {scaled.scaling.cwiseProduct(shortest), (residual - scaled.matrix * shortest).cwiseQuotient(scaled.scaling)};
}

/// Name of a dof, with point and system numbered as in the input.
std::string name_of(const RigidSystems& systems, const FreeDof& free)
{
  const unsigned int system = system_of(systems, free.point);
  const char* const names[] = {"along x", "along y", "along z", "about x", "about y", "about z"};
  return fmt::format("point {} of system {}, {}", free.point - systems.first_point[system] + 1, system + 1,
                     names[free.dof]);
}
} // namespace

std::string unsupported_dof(const RigidSystems& systems, const RigidBalance& balance)
{
  if (balance.tangent.size() == 0)
    return "";
  const ScaledFactors scaled(balance.tangent);
  if (scaled.is_regular())
    return "";
  Eigen::Index largest;
  scaled.scaling.cwiseProduct(scaled.factors.kernel().col(0)).cwiseAbs().maxCoeff(&largest);
  return name_of(systems, free_dofs(systems)[largest]);
}

RigidSolution solve_rigid_motion(const RigidSystems& systems, const RigidStep& step, const BodyLoads& loads,
                                 const double tolerance, const unsigned int max_iterations)
{
  const std::vector<FreeDof> dofs = free_dofs(systems);
  RigidSolution solution;
  solution.increments = start_increments(systems, step);
  for (;; ++solution.iterations)
  {
    solution.balance = rigid_balance(systems, step, solution.increments, loads);
    const Eigen::VectorXd allowed = allowed_residual(solution.balance, tolerance);
    solution.converged = is_within(solution.balance.residual, allowed);
    if (solution.converged)
      return solution;
    if (solution.iterations == max_iterations)
    {
      solution.failure = fmt::format("the rigid bodies are not balanced after {} iterations", max_iterations);
      return solution;
    }
    const auto [change, unresisted] = correction(solution.balance);
    // A joint without tension does not hold a hanging body upright, so the first tangent may be singular. The first
    // correction, the shortest one, puts the joints under tension. If stiffness is still missing then, there is none.
    if (solution.iterations > 0 && !is_within(unresisted, allowed))
    {
      Eigen::Index largest;
      unresisted.cwiseAbs().maxCoeff(&largest);
      solution.failure = "a load acts on a rigid dof without stiffness or inertia: " + name_of(systems, dofs[largest]);
      return solution;
    }
    for (std::size_t i = 0; i < dofs.size(); ++i)
      solution.increments[dofs[i].point][dofs[i].dof] -= change[i];
  }
}
} // namespace kedge
