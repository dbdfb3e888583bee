// Newton's method with line search, on callbacks. It knows vectors and numbers, no soil.
#pragma once

#include <functional>
#include <kedge/base/tpetra.h>
#include <kedge/solvers/linear_solver.h>
#include <kedge/solvers/parameters.h>
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
  std::vector<double> residuals; ///< measure at the start and after every iteration
  std::string failure;           ///< why it did not converge; empty if it did
};

/// How to solve one linear system of Newton's method.
struct NewtonSystem
{
  double tolerance; ///< of the residual, relative
  double damping;   ///< share of the stiffness without yielding that yielding parts get on top of their own
};

struct NewtonProblem
{
  /// Fills r(x); returns the convergence measure (infinite or NaN where x is not admissible).
  std::function<double(const TpetraVector& x, TpetraVector& residual)> residual;
  /// Solves J(x) dx = r, J damped as asked.
  std::function<LinearReport(const TpetraVector& x, const TpetraVector& residual, TpetraVector& dx,
                             const NewtonSystem& system)>
      solve;
};

/// Finds r(x) = 0 from the given x by x <- x - alpha dx. The linear tolerance follows Eisenstat & Walker 1996
/// (SIAM J. Sci. Comput. 17(1), choice 2). A full step that lowers the residual norm is taken; otherwise alpha is
/// sought where the work of the residual along the step has all but vanished (Matthies & Strang 1979), and the next
/// tangents are damped in the manner of Levenberg (1944, Quart. Appl. Math. 2) and Marquardt (1963, J. SIAM 11), ever
/// less while full steps succeed. A system that the linear solver cannot solve is damped too. A problem that Newton's
/// method converges on in full steps never sees damping.
NewtonReport solve_newton(const NewtonProblem& problem, TpetraVector& x, const SolverParameters& parameters);
} // namespace kedge
