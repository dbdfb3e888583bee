#include <BelosBlockGmresSolMgr.hpp>
#include <BelosPseudoBlockCGSolMgr.hpp>
#include <BelosTpetraAdapter.hpp>
#include <Teuchos_CommHelpers.hpp>
#include <cmath>
#include <kedge/base/failure.h>
#include <kedge/solvers/direct.h>
#include <kedge/solvers/linear_solver.h>
#include <kedge/solvers/multigrid.h>
#include <kedge/solvers/scaled_factors.h>

namespace kedge
{
namespace
{
using Operator = TpetraOperator;
using MultiVector = TpetraMultiVector;

/// Below this number of dofs a factorisation is faster than a hierarchy and its iterations.
constexpr std::size_t always_direct_below_2d = 2000, always_direct_below_3d = 700;
/// Above this number of dofs a factorisation takes minutes and gigabytes, because of fill-in.
constexpr std::size_t never_direct_above_2d = 60000, never_direct_above_3d = 20000;
/// Share of a mode that constrained unknowns have. What is that small counts as none (coarse_nodes.cc).
constexpr double almost_zero = 1e-10;
/// Shares of the other entries of a row: what its diagonal has at least, and what it gets in addition. On a plate
/// pulled through sand, shares of 0.01 to 0.05 save a sixth of GMRES's iterations.
constexpr double least_diagonal = 0.1, reinforcement = 0.02;
constexpr unsigned int worth_a_rebuild = 10;               // iterations that cost about as much as a renewed hierarchy
constexpr unsigned int short_basis = 30, long_basis = 100; // vectors of GMRES before it starts again
constexpr double forgetting = 0.9; // factor on the expected waste per solve with a new hierarchy

/// Division by a diagonal.
class Jacobi : public Operator
{
public:
  explicit Jacobi(const TpetraVector& diagonal) : inverse(diagonal.getMap()) { inverse.reciprocal(diagonal); }
  Teuchos::RCP<const TpetraMap> getDomainMap() const override { return inverse.getMap(); }
  Teuchos::RCP<const TpetraMap> getRangeMap() const override { return inverse.getMap(); }
  void apply(const MultiVector& x, MultiVector& y, Teuchos::ETransp, double alpha, double beta) const override
  {
    y.elementWiseMultiply(alpha, inverse, x, beta);
  }

private:
  TpetraVector inverse;
};

/// A - C R^-1 B^T: a bordered matrix after its border's unknowns were eliminated.
class Eliminated : public Operator
{
public:
  Eliminated(const Teuchos::RCP<const Operator>& matrix_, const Border& border_, const ScaledFactors& corner_)
      : matrix(matrix_), border(border_), corner(corner_)
  {
  }
  Teuchos::RCP<const TpetraMap> getDomainMap() const override { return matrix->getDomainMap(); }
  Teuchos::RCP<const TpetraMap> getRangeMap() const override { return matrix->getRangeMap(); }
  void apply(const MultiVector& x, MultiVector& y, Teuchos::ETransp, double alpha, double beta) const override
  {
    matrix->apply(x, y, Teuchos::NO_TRANS, alpha, beta);
    add_columns(border, -alpha, corner.solve(multiply_rows(border, x)), y);
  }

private:
  Teuchos::RCP<const Operator> matrix;
  const Border& border;
  const ScaledFactors& corner;
};
} // namespace

struct LinearSolver::Implementation
{
  SolverParameters parameters;
  unsigned int block_size;
  LinearSystem system;
  Teuchos::RCP<Multigrid> hierarchy;
  Teuchos::RCP<const Operator> eliminated; ///< replaces the product in GMRES while there is a border
  bool strong_hierarchy = false;
  double fresh_rate = 0.;     ///< iterations per e-fold of the residual when the present hierarchy was new
  double expected_waste = 0.; ///< iterations that the next solve takes more with this hierarchy than with a new one

  std::size_t n_equations() const { return system.product->getRangeMap()->getGlobalNumElements(); }

  bool affords_direct() const
  {
    return n_equations() < (block_size == 2 ? never_direct_above_2d : never_direct_above_3d);
  }

  /// False if a new hierarchy is cheaper: where soil yields, a hierarchy is outdated after one Newton iteration.
  bool keeps_hierarchy() const
  {
    return !hierarchy.is_null() && parameters.reuse && !strong_hierarchy && expected_waste < worth_a_rebuild;
  }

  /// Returns false if there is none; then `trouble` says why.
  bool build_hierarchy(const bool strong, std::string& trouble)
  {
    const auto matrix = system.near();
    if (!hierarchy.is_null() && !strong && !strong_hierarchy && hierarchy->renew())
      return true;
    hierarchy = Teuchos::null; // its memory first
    hierarchy = Multigrid::build(matrix, system.near_null_space, block_size, strong, trouble);
    strong_hierarchy = strong;
    return !hierarchy.is_null();
  }

  /// With a border: x = A^-1 b - Z y with Z = A^-1 C, (R - B^T Z) y = c - B^T A^-1 b.
  LinearReport solve_direct(const TpetraVector& b, const Eigen::VectorXd& c, const Border& border, TpetraVector& x,
                            Eigen::VectorXd& y) const
  {
    LinearReport report;
    report.method = "UMFPACK";
    report.iterations = 1;
    const std::size_t n = c.size();
    MultiVector right_sides(b.getMap(), n + 1), solutions(b.getMap(), n + 1);
    Tpetra::deep_copy(*right_sides.getVectorNonConst(0), b);
    for (std::size_t i = 0; i < n; ++i)
      Tpetra::deep_copy(*right_sides.getVectorNonConst(i + 1), *border.columns->getVector(i));
    report.converged = solve_directly(*system.whole(), right_sides, solutions);
    Tpetra::deep_copy(x, *solutions.getVector(0));
    if (n == 0 || !report.converged)
      return report;
    // The border's unknowns follow from a small dense system.
    Eigen::MatrixXd reduced = border.corner;
    for (std::size_t i = 0; i < n; ++i)
      reduced.col(i) -= multiply_rows(border, *solutions.getVector(i + 1));
    const ScaledFactors factors(reduced);
    report.converged = factors.is_regular();
    y = Eigen::VectorXd::Zero(n);
    if (!report.converged)
      return report;
    y = factors.solve(c - multiply_rows(border, x));
    for (std::size_t i = 0; i < n; ++i)
      x.update(-y[i], *solutions.getVector(i + 1), 1.);
    return report;
  }

  /// GMRES, which holds all vectors of its basis from its start. A short basis nearly always suffices; it also holds
  /// what the preconditioner makes of each vector (flexible GMRES), so that the solution needs no more of either.
  LinearReport solve_krylov(const TpetraVector& b, TpetraVector& x, const double tolerance,
                            const unsigned int max_iterations) const
  {
    x.putScalar(0.);
    LinearReport report;
    report.method = "GMRES";
    const unsigned int few = std::min(max_iterations, short_basis), others = max_iterations - few;
    if (iterate(b, x, tolerance, few, few, report) && !report.converged && others > 0)
      iterate(b, x, tolerance, std::min(others, long_basis), others, report);
    return report;
  }

  /// Goes on from x, which is zero in a report of no iterations, and adds to the report. Returns false if that makes no
  /// sense again.
  bool iterate(const TpetraVector& b, TpetraVector& x, const double tolerance, const unsigned int basis,
               const unsigned int max_iterations, LinearReport& report) const
  {
    auto problem = Teuchos::rcp(new Belos::LinearProblem<double, MultiVector, Operator>(
        eliminated.is_null() ? system.product : eliminated, Teuchos::rcpFromRef<MultiVector>(x),
        Teuchos::rcpFromRef<const MultiVector>(b)));
    problem->setRightPrec(hierarchy);
    if (report.iterations == 0)
      problem->setInitResVec(Teuchos::rcpFromRef<const MultiVector>(b));
    problem->setProblem();
    const auto list = Teuchos::parameterList();
    list->set("Flexible Gmres", basis <= short_basis);
    list->set("Maximum Iterations", static_cast<int>(max_iterations));
    list->set("Num Blocks", static_cast<int>(basis));
    list->set("Maximum Restarts", static_cast<int>(max_iterations / basis + 1)); // the iterations are the limit
    list->set("Convergence Tolerance", tolerance);
    list->set("Implicit Residual Scaling", "Norm of RHS"); // also where x is not 0
    list->set("Explicit Residual Scaling", "Norm of RHS");
    list->set("Orthogonalization", "DGKS"); // a second pass only where the first one loses digits
    list->set("Verbosity", static_cast<int>(Belos::Errors));
    Belos::BlockGmresSolMgr<double, MultiVector, Operator> solver(problem, list);
    bool goes_on = true;
    try
    {
      report.converged = solver.solve() == Belos::Converged;
      goes_on = std::isfinite(x.norm2());
      report.converged = report.converged && goes_on;
    }
    catch (const Belos::BelosError&) // the preconditioner has returned NaN
    {
      rethrow_if_alone("Krylov solver");
      goes_on = false;
    }
    catch (const std::runtime_error&) // from KLU2: the matrix of the coarsest level is singular
    {
      rethrow_if_alone("Krylov solver");
      goes_on = false;
    }
    report.iterations += solver.getNumIters();
    return goes_on;
  }

  /// Tries the present hierarchy, then a new one, then one with a stronger smoother.
  LinearReport solve_iteratively(const TpetraVector& b, TpetraVector& x, const double tolerance)
  {
    const unsigned int limit = parameters.max_linear_iterations;
    LinearReport report;
    unsigned int iterations = 0;
    std::string trouble;
    const double e_folds = -std::log(tolerance);
    // The present hierarchy gets only as many iterations as are cheaper than a new one.
    if (keeps_hierarchy())
    {
      const double when_new = fresh_rate * e_folds;
      report = solve_krylov(b, x, tolerance, std::min<double>(limit, std::ceil(when_new) + 3 * worth_a_rebuild));
      iterations += report.iterations;
      expected_waste = report.iterations - when_new;
    }
    for (const bool strong : {false, true})
      if (!report.converged)
      {
        if (!build_hierarchy(strong, trouble))
          continue;
        report = solve_krylov(b, x, tolerance, limit);
        iterations += report.iterations;
        report.escalations = strong;
        fresh_rate = report.iterations / e_folds;
        expected_waste *= forgetting;
      }
    if (report.escalations > 0)
      report.method = "GMRES with a stronger smoother";
    report.iterations = iterations;
    report.trouble = trouble;
    return report;
  }
};

LinearSolver::LinearSolver(const SolverParameters& parameters, const unsigned int block_size)
    : implementation(std::make_unique<Implementation>())
{
  implementation->parameters = parameters;
  implementation->block_size = block_size;
}

LinearSolver::~LinearSolver() = default;

void LinearSolver::set_structure(const LinearSystem& system)
{
  implementation->system = system;
  implementation->hierarchy = Teuchos::null;
}

void LinearSolver::set_structure(const Teuchos::RCP<TpetraMatrix>& matrix,
                                 const Teuchos::RCP<TpetraMultiVector>& near_null_space)
{
  const auto itself = [matrix] { return matrix; };
  set_structure({matrix, near_null_space, itself, itself});
}

bool LinearSolver::prefers_direct(const std::size_t n_equations) const
{
  const LinearSolverChoice choice = implementation->parameters.linear_solver;
  return choice == LinearSolverChoice::direct || n_equations == 0 || // of bodies without soil
         (choice == LinearSolverChoice::automatic &&
          n_equations < (implementation->block_size == 2 ? always_direct_below_2d : always_direct_below_3d));
}

LinearReport LinearSolver::solve(const TpetraVector& right_side, TpetraVector& x, const double relative_tolerance)
{
  Eigen::VectorXd none;
  return solve(right_side, none, {}, x, none, relative_tolerance);
}

LinearReport LinearSolver::solve(const TpetraVector& right_side, const Eigen::VectorXd& border_right_side,
                                 const Border& border, TpetraVector& x, Eigen::VectorXd& y,
                                 const double relative_tolerance)
{
  Implementation& solver = *implementation;
  if (prefers_direct(solver.n_equations()))
    return solver.solve_direct(right_side, border_right_side, border, x, y);

  LinearReport report;
  if (border.empty())
    report = solver.solve_iteratively(right_side, x, relative_tolerance);
  else
  {
    const ScaledFactors corner(border.corner);
    y = Eigen::VectorXd::Zero(border_right_side.size());
    if (!corner.is_regular()) // nothing holds a body
      return report;
    TpetraVector reduced(right_side, Teuchos::Copy);
    add_columns(border, -1., corner.solve(border_right_side), reduced);
    solver.eliminated = Teuchos::rcp(new Eliminated(solver.system.product, border, corner));
    report = solver.solve_iteratively(reduced, x, relative_tolerance);
    solver.eliminated = Teuchos::null;
    y = corner.solve(border_right_side - multiply_rows(border, x));
    report.converged = report.converged && y.allFinite();
  }
  if (!report.converged && solver.affords_direct())
  {
    LinearReport direct = solver.solve_direct(right_side, border_right_side, border, x, y);
    direct.iterations = report.iterations;
    direct.escalations = report.escalations + 1;
    direct.trouble = report.trouble;
    return direct;
  }
  return report;
}

bool solve_positive_definite(const Teuchos::RCP<const TpetraOperator>& product, const TpetraVector& diagonal,
                             const TpetraVector& right_side, TpetraVector& x, const double relative_tolerance)
{
  x.putScalar(0.);
  if (right_side.normInf() == 0.)
    return true;
  auto problem = Teuchos::rcp(new Belos::LinearProblem<double, MultiVector, Operator>(
      product, Teuchos::rcpFromRef<MultiVector>(x), Teuchos::rcpFromRef<const MultiVector>(right_side)));
  problem->setLeftPrec(Teuchos::rcp(new Jacobi(diagonal)));
  problem->setProblem();
  const auto list = Teuchos::parameterList();
  list->set("Maximum Iterations", 2000);
  list->set("Convergence Tolerance", relative_tolerance);
  list->set("Verbosity", static_cast<int>(Belos::Errors));
  Belos::PseudoBlockCGSolMgr<double, MultiVector, Operator> solver(problem, list);
  try
  {
    return solver.solve() == Belos::Converged && std::isfinite(x.norm2());
  }
  catch (const Belos::BelosError&) // because of round-off the matrix is not positive definite
  {
    rethrow_if_alone("projection");
    return false;
  }
}

void reinforce_diagonal(TpetraMatrix& matrix)
{
  const auto local = matrix.getLocalMatrixDevice();
  Kokkos::parallel_for(
      "reinforce diagonal", Kokkos::RangePolicy<ExecutionSpace>(0, local.numRows()),
      KOKKOS_LAMBDA(const std::size_t row) {
        std::size_t at_diagonal = local.graph.row_map(row);
        double others = 0.;
        for (std::size_t k = local.graph.row_map(row); k < local.graph.row_map(row + 1); ++k)
          if (static_cast<std::size_t>(local.graph.entries(k)) == row)
            at_diagonal = k;
          else
            others += std::fabs(local.values(k));
        const double bounded = std::fmax(local.values(at_diagonal), least_diagonal * others);
        local.values(at_diagonal) = bounded + reinforcement * others;
      });
}

Teuchos::RCP<TpetraMultiVector> make_rigid_body_modes(const Teuchos::RCP<const TpetraMap>& map, const unsigned int dim,
                                                      const std::vector<double>& position,
                                                      const std::vector<unsigned char>& constrained)
{
  const unsigned int n_rotations = dim == 3 ? 3 : 1;
  auto modes = Teuchos::rcp(new TpetraMultiVector(map, dim + n_rotations, true));
  auto view = modes->getLocalViewHost(Tpetra::Access::OverwriteAll);
  const std::size_t n_nodes = position.size() / dim;
  std::array<double, 4> mine{{0., 0., 0., double(n_nodes)}}, sums; // all ranks must rotate about one centre
  for (std::size_t i = 0; i < position.size(); ++i)
    mine[i % dim] += position[i];
  Teuchos::reduceAll(*map->getComm(), Teuchos::REDUCE_SUM, 4, mine.data(), sums.data());
  std::array<double, 3> centre;
  for (unsigned int d = 0; d < 3; ++d)
    centre[d] = sums[d] / std::max(1., sums[3]);

  for (std::size_t v = 0; v < n_nodes; ++v)
  {
    std::array<double, 3> x{{0., 0., 0.}};
    for (unsigned int d = 0; d < dim; ++d)
      x[d] = position[dim * v + d] - centre[d];
    const auto set = [&](const unsigned int d, const unsigned int mode, const double value)
    { view(dim * v + d, mode) = constrained[dim * v + d] ? almost_zero * value : value; };
    for (unsigned int mode = 0; mode < dim + n_rotations; ++mode)
      for (unsigned int d = 0; d < dim; ++d)
        set(d, mode, d == mode ? 1. : 0.);
    for (unsigned int r = 0; r < n_rotations; ++r)
    {
      const unsigned int i = r, j = (r + 1) % dim; // rotation in the plane of axes i and j
      set(i, dim + r, -x[j]);
      set(j, dim + r, x[i]);
    }
  }
  return modes;
}
} // namespace kedge
