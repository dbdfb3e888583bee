// Newton's method with line search. It works with callbacks, vectors and numbers, and knows nothing about soil.
#pragma once

#include <cmath>
#include <functional>
#include <kedge/base/tpetra.h>
#include <kedge/solvers/linear_solver.h>
#include <kedge/solvers/newton_history.h>
#include <kedge/solvers/parameters.h>
#include <optional>
#include <string>
#include <vector>

namespace kedge
{
struct NewtonReport
{
  bool converged = false;
  unsigned int iterations = 0; ///< linear systems solved
  unsigned int krylov_iterations = 0;
  unsigned int escalations = 0;
  std::vector<double> residuals; ///< convergence measure at the start and after every iteration
  std::string failure;           ///< why it did not converge; empty if it did
  NewtonHistory history;         ///< for the next problem
};

/// How to solve one linear system of Newton's method.
struct NewtonSystem
{
  double tolerance; ///< of the residual, relative
  double damping;   ///< share of the elastic stiffness that yielding parts get in addition to their own stiffness
};

struct NewtonProblem
{
  /// Fills r(x) and returns the convergence measure, which is infinite or NaN if x is not admissible.
  std::function<double(const TpetraVector& x, TpetraVector& residual)> residual;
  /// Compares residuals with the forces at the point of the last residual() from now on, and returns the measure of the
  /// residual there. Optional: without it the measure is the same throughout.
  std::function<double(const TpetraVector& residual)> renew_measure;
  /// A start below the target is corrected once all the same, unless its measure is below this, too.
  double solved_at_start = INFINITY;
  /// Whether the residual of the last evaluation will do once its measure is below the target. If not, a few more
  /// corrections follow; where they fail, the last iterate below the target is the solution. Optional.
  std::function<bool(const TpetraVector& residual)> suffices;
  /// Solves J(x) dx = r, with the tolerance and the damping of `system`.
  std::function<LinearReport(const TpetraVector& x, const TpetraVector& residual, TpetraVector& dx,
                             const NewtonSystem& system)>
      solve;
};

/// r(x) where it is known already, its evaluation having been the last one.
struct NewtonStart
{
  TpetraVector residual;
  double measure;
};

/// Finds r(x) = 0 from the given x, where r is `start` if that is given, by x <- x - alpha dx. The linear tolerance
/// follows Eisenstat & Walker 1996 (SIAM J. Sci. Comput. 17(1), choice 2). A full step (alpha = 1) that lowers the
/// residual norm is taken. Otherwise a line search finds the alpha at which the work of the residual along the step has
/// almost vanished (Matthies & Strang 1979), and the next tangents are damped in the manner of Levenberg (1944, Quart.
/// Appl. Math. 2) and Marquardt (1963, J. SIAM 11). The damping decreases while full steps succeed. A system that the
/// linear solver cannot solve is damped too. So is the first correction where most of those in `history`, which the
/// reports of a series of problems pass on, were too long. If full steps converge, there is no damping.
NewtonReport solve_newton(const NewtonProblem& problem, TpetraVector& x, const SolverParameters& parameters,
                          const std::optional<NewtonStart>& start = {}, const NewtonHistory& history = {});
} // namespace kedge
