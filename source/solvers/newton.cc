#include <algorithm>
#include <cmath>
#include <kedge/solvers/newton.h>

namespace kedge
{
namespace
{
constexpr double loosest = 0.1, tightest = 1e-8; // of the linear tolerance
constexpr double armijo = 1e-4;
constexpr unsigned int max_trials = 6;
constexpr double slack = 0.8;        // share of the work along a step that may remain
constexpr double growth_limit = 10.; // of the residual in a step accepted for its work
constexpr double hopeless = 1e8;     // growth of the residual over its start that no further iteration repairs

/// Choice 2 of Eisenstat & Walker with gamma = 0.9 and exponent 2, and no tighter than what the target needs.
double choose_linear_tolerance(const std::vector<double>& residuals, const double previous, const double target)
{
  const double now = residuals.back();
  double tolerance = loosest;
  if (residuals.size() > 1)
  {
    const double ratio = now / residuals[residuals.size() - 2];
    tolerance = 0.9 * ratio * ratio;
    if (const double safeguard = 0.9 * previous * previous; safeguard > 0.1)
      tolerance = std::max(tolerance, safeguard);
  }
  // Overshooting the target is wasted work; a tenth of it leaves room for the nonlinear part.
  tolerance = std::max(tolerance, 0.1 * target / now);
  return std::clamp(tolerance, tightest, loosest);
}
} // namespace

NewtonReport solve_newton(const NewtonProblem& problem, TpetraVector& x, const SolverParameters& parameters)
{
  NewtonReport report;
  TpetraVector residual(x.getMap()), dx(x.getMap()), trial(x.getMap()), trial_residual(x.getMap());
  double measure = problem.residual(x, residual);
  report.residuals.push_back(measure);
  double linear_tolerance = loosest;
  while (!(measure < parameters.tolerance))
  {
    if (!std::isfinite(measure))
    {
      report.failure = "the residual is not finite";
      return report;
    }
    if (report.iterations == parameters.max_newton_iterations)
    {
      report.failure = "no convergence in " + std::to_string(report.iterations) + " iterations";
      return report;
    }
    if (measure > hopeless * std::max(1., report.residuals.front()))
    {
      report.failure = "the residual diverges";
      return report;
    }

    linear_tolerance = choose_linear_tolerance(report.residuals, linear_tolerance, parameters.tolerance);
    const LinearReport linear = problem.solve(x, residual, dx, linear_tolerance);
    ++report.iterations;
    report.krylov_iterations += linear.iterations;
    report.escalations += linear.escalations;
    if (!linear.converged)
    {
      report.failure = "the linear system could not be solved";
      return report;
    }

    // Two ways to accept a step: the residual falls (Armijo), or the work of the residual along the step has all but
    // vanished (Matthies & Strang 1979). The first alone would creep where stiff contacts switch, for the norm sees
    // little else; the second alone may leave the region where Newton converges.
    double step = 1., best_step = 1., best_work = INFINITY;
    const double start = measure, start_work = dx.dot(residual);
    for (unsigned int trial_number = 0;; ++trial_number)
    {
      trial.update(1., x, -step, dx, 0.);
      measure = problem.residual(trial, trial_residual);
      const double work = std::isfinite(measure) ? dx.dot(trial_residual) : INFINITY;
      if (std::abs(work) < best_work)
      {
        best_work = std::abs(work);
        best_step = step;
      }
      if (!parameters.line_search || measure <= (1. - armijo * step) * start ||
          (std::abs(work) <= slack * std::abs(start_work) && measure < growth_limit * start) ||
          trial_number == max_trials)
        break;
      const double secant = start_work / (start_work - work);
      step *= std::isfinite(secant) ? std::clamp(secant, 0.1, 0.5) : 0.25;
    }
    if (parameters.line_search && best_step != step && std::isfinite(best_work))
    {
      trial.update(1., x, -best_step, dx, 0.);
      measure = problem.residual(trial, trial_residual);
    }
    Tpetra::deep_copy(x, trial);
    Tpetra::deep_copy(residual, trial_residual);
    report.residuals.push_back(measure);
  }
  report.converged = true;
  return report;
}
} // namespace kedge
