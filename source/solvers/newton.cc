#include <algorithm>
#include <cmath>
#include <kedge/solvers/newton.h>

namespace kedge
{
namespace
{
constexpr double loosest = 0.1, tightest = 1e-8; // of the linear tolerance
constexpr double armijo = 1e-4;
constexpr unsigned int max_trials = 8;
constexpr unsigned int max_halvings = 3;    // to break a cycle; less than an eighth of a step gains nothing
constexpr double slack = 0.7;               // share of the work along a step that may remain
constexpr double growth_limit = 10.;        // of the residual in a step that is accepted for its work
constexpr unsigned int patience = 3;        // iterations without progress that count as a cycle
constexpr unsigned int stagnation = 24;     // least number of iterations without progress before the load step is cut
constexpr unsigned int max_refinements = 6; // of a residual below the target that does not suffice
constexpr double progress = 0.9; // an iteration makes progress if it lowers the lowest residual by this factor
constexpr double hopeless = 1e8; // growth of the residual since the start after which iterating is useless

/// Limits and factors of the damping. It is raised after a failed full step and lowered after full steps, faster if
/// most of the work remains. A damped direction that allows only steps below `least_damped_step` is given up.
constexpr double most_damping = 0.1, first_damping = 0.03, least_damping = 1e-5, least_damped_step = 0.05;
constexpr double damping_raise = 10., damping_ease = 0.6, damping_drop = 0.3;
/// Share of the last steps whose first correction was too long from which on the next one is damped at once, and what a
/// step that was damped leaves of that share: after eight of them one shows whether it still needs to be.
constexpr double many_overshoots = 0.6, overshoots_kept = 0.972;

/// Choice 2 of Eisenstat & Walker with gamma = 0.9 and exponent 2, but no tighter than the target requires.
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
  // A residual far below the target is wasted work. A tenth of the target leaves room for the nonlinear part.
  tolerance = std::max(tolerance, 0.1 * target / now);
  return std::clamp(tolerance, tightest, loosest);
}

/// Share of too long first corrections, when that of a step with `damping` went `step` of its length.
double overshoots_after(const double overshoots, const double damping, const double step)
{
  if (step < 1.)
    return 0.5 * (overshoots + 1.);
  return damping > 0. ? overshoots_kept * overshoots : 0.5 * overshoots;
}

/// A point x - step dx of a line search: the measure of its residual, and the work of the residual along dx.
struct SearchPoint
{
  double step, measure, work;
};

double raise_damping(const double damping)
{
  return std::min(most_damping, std::max(first_damping, damping_raise * damping));
}

/// Damping for the next iteration. Where many points yield, full steps overshoot. Some elastic stiffness shortens the
/// step there; a line search would shorten it everywhere. Only the undamped direction is guaranteed to reduce the
/// residual.
double adapt_damping(const double damping, const SearchPoint& start, const SearchPoint& taken)
{
  if (damping > 0. && taken.step < least_damped_step)
    return 0.;
  if (taken.step < 1.)
    return raise_damping(damping);
  const double work = taken.work / start.work;
  const double factor = work > 0.5 ? damping_drop : work > 0. ? damping_ease : 1.;
  const double eased = damping * std::min(factor, taken.measure / start.measure); // keeps the last steps quadratic
  return eased < least_damping ? 0. : eased;
}

/// Shortens a full step that overshoots: finds by regula falsi, between `start` and `full`, a step at which only a
/// share of the work of the residual remains (Matthies & Strang 1979, Int. J. Numer. Meth. Eng. 14). The residual norm
/// is no good measure here: where contacts close or soil yields within the step, it falls for tiny steps only. The step
/// that is found goes far enough for these contacts and points to take up load, so the next tangent contains them.
template <typename Evaluate>
SearchPoint search_line(const Evaluate& at, const SearchPoint& full, const SearchPoint& start)
{
  const auto accepted = [&](const SearchPoint& trial)
  { return std::abs(trial.work) <= slack * std::abs(start.work) && trial.measure < growth_limit * start.measure; };
  SearchPoint now = full, low = start, high = full, best = full;
  for (unsigned int trial = 0; trial < max_trials && !accepted(now); ++trial)
  {
    const double share = low.work / (low.work - high.work);
    const double inside = std::isfinite(share) && high.work < 0. ? std::clamp(share, 0.1, 0.9) : 0.25;
    now = at(low.step + inside * (high.step - low.step));
    if (std::abs(now.work) < std::abs(best.work) || !std::isfinite(best.measure))
      best = now;
    if (now.work > 0. && high.work < 0.)
      low = now;
    else
      high = now;
  }
  return accepted(now) || now.step == best.step ? now : at(best.step);
}

/// Breaks a cycle of iterates, which a few points cause that stick and slip, or yield, in turns. Takes the best of ever
/// shorter steps: the residual norm falls for short ones, which pass the kinks one by one.
template <typename Evaluate> SearchPoint shorten_step(const Evaluate& at, const SearchPoint& full, const double measure)
{
  SearchPoint now = full, best = full;
  const auto limit = [&] { return std::isfinite(best.measure) ? max_halvings : max_trials; };
  for (unsigned int trial = 0; trial < limit() && !(best.measure < measure && now.measure >= best.measure); ++trial)
  {
    now = at(0.5 * now.step);
    if (now.measure < best.measure || !std::isfinite(best.measure))
      best = now;
  }
  return now.step == best.step ? now : at(best.step);
}

/// Serves when the tangent is so unsymmetric that the work says nothing: takes the longest step without a new highest
/// residual.
template <typename Evaluate> SearchPoint halve_step(const Evaluate& at, const SearchPoint& full, const double highest)
{
  SearchPoint now = full;
  for (unsigned int trial = 0; trial < max_trials && !(now.measure <= highest); ++trial)
    now = at(0.5 * now.step);
  return now;
}

/// Why further iterations cannot help, or cost more than two load steps of half the size; empty if they are worthwhile.
std::string reason_to_give_up(const NewtonReport& report, const double measure, const unsigned int without_progress,
                              const SolverParameters& parameters)
{
  const unsigned int limit = std::max(stagnation, parameters.max_newton_iterations / 2);
  if (!std::isfinite(measure))
    return "the residual is not finite";
  if (report.iterations == parameters.max_newton_iterations)
    return "no convergence in " + std::to_string(report.iterations) + " iterations";
  if (without_progress == limit)
    return "no progress in " + std::to_string(limit) + " iterations";
  if (measure > hopeless * std::max(1., report.residuals.front()))
    return "the residual diverges";
  return "";
}

/// The state of one solution.
class NewtonMethod
{
public:
  NewtonMethod(const NewtonProblem& problem, TpetraVector& x, const SolverParameters& parameters,
               const NewtonHistory& history)
      : problem(problem),
        parameters(parameters),
        target(parameters.target()),
        damping(history.overshoots > many_overshoots ? most_damping : 0.),
        x(x),
        residual(x.getMap()),
        dx(x.getMap()),
        trial(x.getMap()),
        trial_residual(x.getMap())
  {
    report.history = history;
  }

  NewtonReport solve(const std::optional<NewtonStart>& start);

private:
  void begin(const std::optional<NewtonStart>& start);
  /// Whether x will do. If it is below the target and will not, it is remembered while corrections refine it.
  bool is_solved();
  /// Why no further correction is made, if so; empty where what is remembered shall do.
  std::optional<std::string> reason_to_stop();
  LinearReport find_direction();
  /// Goes along the direction: a full step, or the result of the search that fits the situation.
  void take_step();
  SearchPoint evaluate(double step);
  SearchPoint choose_step(double work);
  /// What residuals are compared with may follow the solution, but never within a line search.
  double renewed(const double measured) const
  {
    return problem.renew_measure && std::isfinite(measured) ? problem.renew_measure(residual) : measured;
  }
  /// The end without a solution, or with the one that is remembered: it stays one, whatever becomes of its refinement.
  NewtonReport give_up(const std::string& reason);

  const NewtonProblem& problem;
  const SolverParameters& parameters;
  NewtonReport report;
  const double target;
  double measure = 0., lowest = 0., linear_tolerance = loosest, damping;
  unsigned int without_progress = 0, refinements = 0;
  TpetraVector &x, residual, dx, trial, trial_residual;
  std::optional<TpetraVector> solution; ///< below the target, while it is refined
};

NewtonReport NewtonMethod::solve(const std::optional<NewtonStart>& start)
{
  begin(start);
  while (!is_solved())
  {
    if (const auto reason = reason_to_stop())
      return give_up(*reason);
    const LinearReport linear = find_direction();
    if (linear.converged)
      take_step();
    else if (damping < most_damping)
      damping = raise_damping(damping); // a system that is too soft for the linear solver is damped and solved again
    else
      return give_up("the linear system could not be solved" +
                     (linear.trouble.empty() ? "" : ", for there was no multigrid hierarchy: " + linear.trouble));
  }
  report.converged = true;
  return report;
}

void NewtonMethod::begin(const std::optional<NewtonStart>& start)
{
  if (start)
    Tpetra::deep_copy(residual, start->residual);
  measure = lowest = renewed(start ? start->measure : problem.residual(x, residual));
  report.residuals.push_back(measure);
}

bool NewtonMethod::is_solved()
{
  if (!(measure < target))
    return false;
  const bool is_start = report.residuals.size() == 1;
  const auto needs_more = [&]
  { return (is_start && !(measure < problem.solved_at_start)) || (problem.suffices && !problem.suffices(residual)); };
  if (refinements == max_refinements || !needs_more())
    return true;
  solution.emplace(x, Teuchos::Copy);
  return false;
}

std::optional<std::string> NewtonMethod::reason_to_stop()
{
  if (solution && refinements++ == max_refinements)
    return "";
  const std::string reason = reason_to_give_up(report, measure, without_progress, parameters);
  return reason.empty() ? std::optional<std::string>() : reason;
}

LinearReport NewtonMethod::find_direction()
{
  linear_tolerance = choose_linear_tolerance(report.residuals, linear_tolerance, target);
  const LinearReport linear = problem.solve(x, residual, dx, {linear_tolerance, damping});
  ++report.iterations;
  report.krylov_iterations += linear.iterations;
  report.escalations += linear.escalations;
  return linear;
}

void NewtonMethod::take_step()
{
  const double work = dx.dot(residual);
  const SearchPoint step = choose_step(work);
  if (report.iterations == 1 && !solution)
    report.history.overshoots = overshoots_after(report.history.overshoots, damping, step.step);
  damping = adapt_damping(damping, {0., measure, work}, step);
  // The last point at which the search evaluated the residual is the one that it returns.
  Tpetra::deep_copy(x, trial);
  Tpetra::deep_copy(residual, trial_residual);
  measure = renewed(step.measure);
  report.residuals.push_back(measure);
  const bool gained = measure < progress * lowest;
  without_progress = gained ? 0 : without_progress + 1;
  lowest = gained ? measure : lowest;
}

SearchPoint NewtonMethod::evaluate(const double step)
{
  trial.update(1., x, -step, dx, 0.);
  const double trial_measure = problem.residual(trial, trial_residual);
  return {step, trial_measure, std::isfinite(trial_measure) ? dx.dot(trial_residual) : -INFINITY};
}

SearchPoint NewtonMethod::choose_step(const double work)
{
  const auto at = [&](const double step) { return evaluate(step); };
  const SearchPoint full = at(1.);
  const bool is_fine = solution && full.measure < target; // near round-off a measure need not fall
  if (!parameters.line_search || is_fine || full.measure <= (1. - armijo) * measure)
    return full;
  // Shortened steps come a few at a time; many in a row crawl from kink to kink.
  if (without_progress / patience % 2 == 1)
    return shorten_step(at, full, measure);
  if (work > 0.)
    return search_line(at, full, {0., measure, work});
  return halve_step(at, full, *std::max_element(report.residuals.begin(), report.residuals.end()));
}

NewtonReport NewtonMethod::give_up(const std::string& reason)
{
  report.converged = solution.has_value();
  if (!solution)
    report.failure = reason;
  else
  {
    Tpetra::deep_copy(x, *solution);
    report.residuals.push_back(problem.residual(x, residual));
  }
  return report;
}
} // namespace

NewtonReport solve_newton(const NewtonProblem& problem, TpetraVector& x, const SolverParameters& parameters,
                          const std::optional<NewtonStart>& start, const NewtonHistory& history)
{
  return NewtonMethod(problem, x, parameters, history).solve(start);
}
} // namespace kedge
