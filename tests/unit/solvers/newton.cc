#include <cmath>
#include <gtest/gtest.h>
#include <kedge/solvers/newton.h>

using namespace kedge;

namespace
{
/// One equation f(x) = 0 per unknown, three unknowns per rank, all with the same start.
struct Scalar
{
  Scalar(std::function<double(double)> f_, std::function<double(double)> derivative_)
      : f(std::move(f_)), derivative(std::move(derivative_))
  {
  }

  std::function<double(double)> f, derivative;
  double admissible_below = INFINITY;
  double least_solvable_damping = 0.;
  double solved_at_start = INFINITY;
  std::function<bool(const TpetraVector&)> suffices;
  NewtonHistory history;                    ///< of the problems so far
  std::vector<double> tolerances, dampings; ///< asked of the linear solver

  static Teuchos::RCP<const TpetraMap> map()
  {
    return Teuchos::rcp(
        new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(), 3, 0, Tpetra::getDefaultComm()));
  }

  static double first(const TpetraVector& x) { return x.getLocalViewHost(Tpetra::Access::ReadOnly)(0, 0); }

  NewtonReport solve(TpetraVector& x, const SolverParameters& parameters)
  {
    NewtonProblem problem;
    problem.residual = [this](const TpetraVector& x, TpetraVector& r)
    {
      r.putScalar(f(first(x)));
      return first(x) < admissible_below ? r.norm2() / std::sqrt(r.getGlobalLength()) : INFINITY;
    };
    problem.solved_at_start = solved_at_start;
    problem.suffices = suffices;
    problem.solve = [this](const TpetraVector& x, const TpetraVector& r, TpetraVector& dx, const NewtonSystem& how)
    {
      dx.putScalar(first(r) / (derivative(first(x)) + how.damping));
      tolerances.push_back(how.tolerance);
      dampings.push_back(how.damping);
      LinearReport report;
      report.converged = how.damping >= least_solvable_damping;
      report.iterations = 2;
      report.escalations = 1;
      return report;
    };
    const NewtonReport report = solve_newton(problem, x, parameters, {}, history);
    history = report.history;
    return report;
  }

  NewtonReport solve_from(const double start, const SolverParameters& parameters, double* end = nullptr)
  {
    TpetraVector x(map());
    x.putScalar(start);
    const NewtonReport report = solve(x, parameters);
    if (end)
      *end = first(x);
    return report;
  }
};

Scalar cubic()
{
  return {[](const double x) { return x * x * x - 8.; }, [](const double x) { return 3. * x * x; }};
}

/// Newton's method alone diverges from |x| > 1.39.
Scalar arc_tangent()
{
  return {[](const double x) { return std::atan(x); }, [](const double x) { return 1. / (1. + x * x); }};
}

SolverParameters tight()
{
  SolverParameters parameters;
  parameters.tolerance = 1e-12;
  return parameters;
}
} // namespace

TEST(Newton, ConvergesQuadratically)
{
  double root = 0.;
  const NewtonReport report = cubic().solve_from(3., tight(), &root);
  ASSERT_TRUE(report.converged);
  EXPECT_NEAR(root, 2., 1e-13);
  // f'' / (2 f'^2) = 1/24 at the root
  for (std::size_t k = 1; k + 1 < report.residuals.size() && report.residuals[k + 1] > 1e-12; ++k)
    EXPECT_LT(report.residuals[k + 1], 0.05 * std::pow(report.residuals[k], 2)) << "iteration " << k;
}

TEST(Newton, DoesNothingAtTheRoot)
{
  const NewtonReport report = cubic().solve_from(2., tight());
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 0u);
  EXPECT_EQ(report.residuals.size(), 1u);
  EXPECT_EQ(report.failure, "");
}

TEST(Newton, AddsUpTheWorkOfTheLinearSolver)
{
  const NewtonReport report = cubic().solve_from(3., tight());
  EXPECT_EQ(report.residuals.size(), report.iterations + 1u);
  EXPECT_EQ(report.krylov_iterations, 2u * report.iterations);
  EXPECT_EQ(report.escalations, report.iterations);
}

TEST(Newton, DivergesFromABadStartWithoutLineSearch)
{
  SolverParameters parameters = tight();
  parameters.line_search = false;
  const NewtonReport report = arc_tangent().solve_from(3., parameters);
  EXPECT_FALSE(report.converged);
}

TEST(Newton, LineSearchRescuesABadStart)
{
  double root = 1.;
  const NewtonReport report = arc_tangent().solve_from(3., tight(), &root);
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(root, 0., 1e-12);
  for (std::size_t k = 0; k + 1 < report.residuals.size(); ++k)
    EXPECT_LT(report.residuals[k + 1], report.residuals[k]);
}

TEST(Newton, DampsOnlyAfterAFailedStep)
{
  Scalar easy = cubic();
  EXPECT_TRUE(easy.solve_from(3., tight()).converged);
  for (const double damping : easy.dampings)
    EXPECT_EQ(damping, 0.);

  Scalar hard = arc_tangent();
  EXPECT_TRUE(hard.solve_from(3., tight()).converged);
  EXPECT_EQ(hard.dampings[0], 0.);
  EXPECT_GT(hard.dampings[1], 0.);
  for (std::size_t k = 1; k + 1 < hard.dampings.size(); ++k) // full steps from there on
    EXPECT_LE(hard.dampings[k + 1], hard.dampings[k]);
}

TEST(Newton, BeginsDampedWhereFirstCorrectionsAreTooLong)
{
  Scalar hard = arc_tangent();
  unsigned int damped = 0;
  std::vector<bool> begins_damped;
  for (unsigned int step = 0; step < 12; ++step)
  {
    const std::size_t first = hard.dampings.size();
    EXPECT_TRUE(hard.solve_from(3., tight()).converged);
    begins_damped.push_back(hard.dampings[first] > 0.);
    damped += begins_damped.back();
  }
  EXPECT_EQ(std::vector<bool>(begins_damped.begin(), begins_damped.begin() + 3),
            std::vector<bool>({false, false, true}));
  EXPECT_GE(damped, 8u);

  Scalar easy = cubic();
  easy.history = hard.history;
  for (unsigned int step = 0; step < 40; ++step)
    easy.solve_from(3., tight());
  EXPECT_EQ(easy.dampings.back(), 0.);
  EXPECT_LT(easy.history.overshoots, 0.01);
}

TEST(Newton, LineSearchAvoidsPointsThatAreNotAdmissible)
{
  Scalar problem = cubic();
  problem.admissible_below = 2.5; // the first full step from 1 would go to 3.33
  EXPECT_TRUE(problem.solve_from(1., tight()).converged);
}

TEST(Newton, ReportsTooManyIterations)
{
  SolverParameters parameters = tight();
  parameters.max_newton_iterations = 3;
  const NewtonReport report = cubic().solve_from(100., parameters);
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.iterations, 3u);
  EXPECT_EQ(report.failure, "no convergence in 3 iterations");
}

TEST(Newton, ReportsAResidualThatIsNotANumber)
{
  Scalar problem = cubic();
  problem.f = [](double) { return NAN; };
  const NewtonReport report = problem.solve_from(1., tight());
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.iterations, 0u);
  EXPECT_EQ(report.failure, "the residual is not finite");
}

TEST(Newton, ReportsThatNoPartOfTheStepIsAdmissible)
{
  Scalar problem = cubic();
  problem.admissible_below = 1.01;
  const NewtonReport report = problem.solve_from(1., tight());
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.failure, "the residual is not finite");
}

TEST(Newton, ReportsAnUnsolvableLinearSystem)
{
  Scalar problem = cubic();
  problem.least_solvable_damping = INFINITY;
  const NewtonReport report = problem.solve_from(1., tight());
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.iterations, problem.dampings.size());
  EXPECT_GT(problem.dampings.back(), 0.); // tried too
  EXPECT_EQ(report.failure, "the linear system could not be solved");
}

TEST(Newton, DampsASystemThatIsTooSoftForTheLinearSolver)
{
  Scalar problem = cubic();
  problem.least_solvable_damping = 1e-9;
  double root = 0.;
  SolverParameters parameters = tight();
  parameters.max_newton_iterations = 100; // every other one has to be damped anew
  EXPECT_TRUE(problem.solve_from(1., parameters, &root).converged);
  EXPECT_EQ(problem.dampings[0], 0.);
  EXPECT_GT(problem.dampings[1], 0.);
}

TEST(Newton, GivesUpAfterHalfOfTheIterationsWithoutProgress)
{
  Scalar problem = cubic();
  problem.f = [](double x) { return x * x + 1.; }; // no root
  problem.derivative = [](double x) { return 2. * x; };
  SolverParameters parameters = tight();
  parameters.max_newton_iterations = 30;
  EXPECT_EQ(problem.solve_from(0.5, parameters).failure, "no progress in 24 iterations");
  parameters.max_newton_iterations = 80;
  const NewtonReport report = problem.solve_from(0.5, parameters);
  EXPECT_FALSE(report.converged);
  EXPECT_LT(report.iterations, 56u);
  EXPECT_EQ(report.failure, "no progress in 40 iterations");
}

TEST(Newton, ReportsDivergence)
{
  SolverParameters parameters = tight();
  parameters.line_search = false;
  Scalar problem{[](const double x) { return x; }, [](double) { return -1e-5; }};
  const NewtonReport report = problem.solve_from(1., parameters);
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.failure, "the residual diverges");
}

TEST(Newton, AsksForTighterLinearSolutionsAsItConverges)
{
  Scalar problem = cubic();
  problem.solve_from(3., tight());
  ASSERT_GT(problem.tolerances.size(), 2u);
  EXPECT_LE(problem.tolerances.front(), 0.1);
  for (std::size_t k = 0; k + 2 < problem.tolerances.size(); ++k) // the last one only has to reach the target
    EXPECT_LE(problem.tolerances[k + 1], problem.tolerances[k]);
}

TEST(Newton, AsksForNoMoreThanTheTargetNeeds)
{
  Scalar problem = cubic();
  SolverParameters parameters;
  parameters.tolerance = 0.1;
  const NewtonReport report = problem.solve_from(3., parameters);
  const double before_last = report.residuals[report.residuals.size() - 2];
  EXPECT_GE(problem.tolerances.back(), std::min(0.1, 0.1 * parameters.tolerance / before_last));
}

TEST(Newton, AStartBelowTheTargetIsCorrectedWhereThatIsAskedFor)
{
  Scalar near = cubic();
  SolverParameters loose;
  loose.tolerance = 1e-2;
  EXPECT_EQ(near.solve_from(2.0001, loose).iterations, 0u);
  near.solved_at_start = 1e-10;
  double root = 0.;
  const NewtonReport report = near.solve_from(2.0001, loose, &root);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 1u);
  EXPECT_NEAR(root, 2., 1e-8);
  EXPECT_EQ(near.solve_from(2., loose).iterations, 0u);
}

TEST(Newton, AResidualThatDoesNotSufficeIsReducedFurther)
{
  SolverParameters loose;
  loose.tolerance = 1.;
  Scalar strict = cubic();
  strict.suffices = [](const TpetraVector& r) { return r.normInf() < 1e-6; };
  double root = 0.;
  EXPECT_TRUE(strict.solve_from(2.5, loose, &root).converged);
  EXPECT_NEAR(root, 2., 1e-7);
  EXPECT_GT(std::abs(cubic().solve_from(2.5, loose).residuals.back()), 1e-3);
}

/// Where further corrections do not help, the target is enough.
TEST(Newton, AResidualThatNeverSufficesIsTakenAfterAWhile)
{
  SolverParameters loose;
  loose.tolerance = 1.;
  Scalar never = cubic();
  never.suffices = [](const TpetraVector&) { return false; };
  const NewtonReport report = never.solve_from(2.5, loose);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.iterations, 12u);
}

/// A start below the target that shall be corrected stays a solution where no correction can be found.
TEST(Newton, ASolutionThatCannotBeRefinedStaysOne)
{
  SolverParameters loose;
  loose.tolerance = 1e-2;
  Scalar stuck = cubic();
  stuck.solved_at_start = 1e-10;
  stuck.least_solvable_damping = 1e9; // no linear system is solved
  double root = 0.;
  const NewtonReport report = stuck.solve_from(2.0001, loose, &root);
  EXPECT_TRUE(report.converged) << report.failure;
  EXPECT_EQ(root, 2.0001);
  EXPECT_FALSE(stuck.solve_from(3., loose).converged);
}

/// The same where each correction leads away from the target.
TEST(Newton, ARefinementThatGoesAstrayIsForgotten)
{
  SolverParameters loose;
  loose.tolerance = 1e-2;
  loose.line_search = false;
  Scalar astray = {[](const double x) { return std::cbrt(x); }, // Newton's method doubles |x|
                   [](const double x) { return std::pow(std::abs(x), -2. / 3.) / 3.; }};
  astray.suffices = [](const TpetraVector&) { return false; };
  double root = 0.;
  const NewtonReport report = astray.solve_from(5e-7, loose, &root);
  EXPECT_TRUE(report.converged) << report.failure;
  EXPECT_LT(std::abs(std::cbrt(root)), 1e-2);
}
