#include <BelosBlockGmresSolMgr.hpp>
#include <BelosPseudoBlockCGSolMgr.hpp>
#include <BelosTpetraAdapter.hpp>
#include <MueLu_CreateTpetraPreconditioner.hpp>
#include <Teuchos_CommHelpers.hpp>
#include <cmath>
#include <kedge/base/failure.h>
#include <kedge/solvers/direct.h>
#include <kedge/solvers/linear_solver.h>
#include <kedge/solvers/near_matrix.h>
#include <kedge/solvers/scaled_factors.h>

namespace kedge
{
namespace
{
using Operator = Tpetra::Operator<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using MultiVector = TpetraMultiVector;
using Hierarchy = MueLu::TpetraOperator<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;

/// Below this number of dofs a factorisation is faster than setting up a hierarchy.
constexpr std::size_t always_direct_below = 2000;
/// Above this number of dofs a factorisation takes minutes and gigabytes, because of fill-in.
constexpr std::size_t never_direct_above_2d = 60000, never_direct_above_3d = 20000;
/// MueLu refuses modes that vanish on an aggregate. On an aggregate of constrained nodes they would.
constexpr double almost_zero = 1e-10;
constexpr unsigned int worth_a_rebuild = 9; // iterations that cost about as much as a new hierarchy
constexpr double forgetting = 0.9;          // factor on the expected waste per solve with a new hierarchy

Teuchos::ParameterList hierarchy_parameters(const unsigned int block_size, const bool strong, const bool parallel)
{
  Teuchos::ParameterList list;
  list.set("verbosity", "none");
  list.set("number of equations", static_cast<int>(block_size));
  // Measured on yielding sand and on an elastic cube of 100 000 dofs: smoothing the prolongators saves hardly an
  // iteration but makes set-up 2.5 times dearer. Smoother sweeps before the coarse correction save an eighth of the
  // iterations but make each 1.5 times dearer.
  list.set("multigrid algorithm", strong ? "sa" : "unsmoothed");
  list.set("smoother: pre or post", strong ? "both" : "post");
  list.set("aggregation: type", "uncoupled");
  list.set("aggregation: drop tol", 0.0);
  list.set("coarse: max size", parallel ? 300 : 1000);
  if (parallel) // KLU2 of Trilinos 13 gives wrong results for matrices on several ranks, also for symmetric ones
  {
    list.set("coarse: type", "RELAXATION");
    Teuchos::ParameterList& coarse = list.sublist("coarse: params");
    coarse.set("relaxation: type", "Symmetric Gauss-Seidel");
    coarse.set("relaxation: sweeps", 8);
  }
  else
    list.set("coarse: type", "KLU2");
  // A node outside all aggregates has fewer unknowns than modes, which leaves empty rows in the coarse matrix.
  list.set("rap: fix zero diagonals", true);
  list.set("max levels", 6);
  list.set("reuse: type", "none"); // other types of Trilinos 13 fail if the pattern of a coarse matrix changes
  list.set("smoother: type", "RELAXATION");
  Teuchos::ParameterList& smoother = list.sublist("smoother: params");
  smoother.set("relaxation: type", "Symmetric Gauss-Seidel");
  smoother.set("relaxation: sweeps",
               strong ? 4 : 1); // two save an eighth of the iterations, but each is a third dearer
  return list;
}

/// Division by the diagonal of a matrix.
class Jacobi : public Operator
{
public:
  explicit Jacobi(const TpetraMatrix& matrix) : inverse(matrix.getRowMap())
  {
    TpetraVector diagonal(matrix.getRowMap());
    matrix.getLocalDiagCopy(diagonal);
    inverse.reciprocal(diagonal);
  }
  Teuchos::RCP<const TpetraMap> getDomainMap() const override { return inverse.getMap(); }
  Teuchos::RCP<const TpetraMap> getRangeMap() const override { return inverse.getMap(); }
  void apply(const MultiVector& x, MultiVector& y, Teuchos::ETransp, double alpha, double beta) const override
  {
    y.elementWiseMultiply(alpha, inverse, x, beta);
  }

private:
  TpetraVector inverse;
};

/// B^T x, the same on all ranks.
Eigen::VectorXd multiply_rows(const Border& border, const MultiVector& x)
{
  Eigen::VectorXd result(border.corner.rows());
  for (Eigen::Index i = 0; i < result.size(); ++i)
    result[i] = border.rows->getVector(i)->dot(*x.getVector(0));
  return result;
}

/// x += factor * C y
void add_columns(const Border& border, const double factor, const Eigen::VectorXd& y, MultiVector& x)
{
  for (Eigen::Index i = 0; i < y.size(); ++i)
    x.update(factor * y[i], *border.columns->getVector(i), 1.);
}

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
  Teuchos::RCP<TpetraMatrix> matrix;
  Teuchos::RCP<MultiVector> near_null_space;
  std::unique_ptr<NearMatrix> near; ///< the hierarchy is built from it if the places of the nodes are known
  Teuchos::RCP<Hierarchy> hierarchy;
  Teuchos::RCP<const Operator> eliminated; ///< replaces the matrix in GMRES while there is a border
  bool strong_hierarchy = false;
  double fresh_rate = 0.;     ///< iterations per e-fold of the residual when the present hierarchy was new
  double expected_waste = 0.; ///< iterations that the next solve takes more with this hierarchy than with a new one

  bool affords_direct() const
  {
    return matrix->getGlobalNumRows() < (block_size == 2 ? never_direct_above_2d : never_direct_above_3d);
  }

  bool prefers_direct() const
  {
    return parameters.linear_solver == LinearSolverChoice::direct ||
           (parameters.linear_solver == LinearSolverChoice::automatic &&
            matrix->getGlobalNumRows() < always_direct_below);
  }

  /// False if a new hierarchy is cheaper: where soil yields, a hierarchy is outdated after one Newton iteration.
  bool keeps_hierarchy() const
  {
    return !hierarchy.is_null() && parameters.reuse && !strong_hierarchy && expected_waste < worth_a_rebuild;
  }

  /// Returns false if MueLu finds no hierarchy.
  bool build_hierarchy(const bool strong)
  {
    if (near)
      near->update();
    const Teuchos::RCP<TpetraMatrix> from = near ? near->matrix() : matrix;
    Teuchos::ParameterList list = hierarchy_parameters(block_size, strong, matrix->getComm()->getSize() > 1);
    list.sublist("user data").set("Nullspace", near_null_space);
    const Teuchos::RCP<Operator> as_operator = from;
    hierarchy = Teuchos::null;
    try
    {
      hierarchy = MueLu::CreateTpetraPreconditioner<double, LocalOrdinal, GlobalOrdinal, TpetraNode>(as_operator, list);
    }
    catch (const std::exception&) // MueLu throws if it finds none
    {
      rethrow_if_alone("multigrid");
    }
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
    report.converged = solve_directly(*matrix, right_sides, solutions);
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

  LinearReport solve_krylov(const TpetraVector& b, TpetraVector& x, const double tolerance,
                            const unsigned int max_iterations) const
  {
    x.putScalar(0.);
    const Teuchos::RCP<const Operator> system =
        eliminated.is_null() ? Teuchos::rcp_implicit_cast<const Operator>(matrix) : eliminated;
    auto problem = Teuchos::rcp(new Belos::LinearProblem<double, MultiVector, Operator>(
        system, Teuchos::rcpFromRef<MultiVector>(x), Teuchos::rcpFromRef<const MultiVector>(b)));
    problem->setRightPrec(hierarchy);
    problem->setProblem();
    const auto list = Teuchos::parameterList();
    list->set("Maximum Iterations", static_cast<int>(max_iterations));
    list->set("Num Blocks", static_cast<int>(std::min(max_iterations, 100u)));
    list->set("Convergence Tolerance", tolerance);
    list->set("Verbosity", static_cast<int>(Belos::Errors));
    Belos::BlockGmresSolMgr<double, MultiVector, Operator> solver(problem, list);
    LinearReport report;
    report.method = "GMRES";
    try
    {
      report.converged = solver.solve() == Belos::Converged && std::isfinite(x.norm2());
    }
    catch (const Belos::BelosError&) // the preconditioner has returned NaN
    {
      rethrow_if_alone("Krylov solver");
    }
    catch (const std::runtime_error&) // from KLU2: the matrix of the coarsest level is singular
    {
      rethrow_if_alone("Krylov solver");
    }
    report.iterations = solver.getNumIters();
    return report;
  }

  /// Tries the present hierarchy, then a new one, then one with a stronger smoother.
  LinearReport solve_iteratively(const TpetraVector& b, TpetraVector& x, const double tolerance)
  {
    const unsigned int limit = parameters.max_linear_iterations;
    LinearReport report;
    unsigned int iterations = 0;
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
        if (!build_hierarchy(strong))
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

void LinearSolver::set_structure(const Teuchos::RCP<TpetraMatrix>& matrix,
                                 const Teuchos::RCP<TpetraMultiVector>& near_null_space, const NodePlaces& places)
{
  implementation->matrix = matrix;
  implementation->near_null_space = near_null_space;
  implementation->hierarchy = Teuchos::null;
  implementation->near.reset();
  const int here = !places.position.empty(); // a rank may own no nodes
  int anywhere = 0;
  Teuchos::reduceAll(*matrix->getComm(), Teuchos::REDUCE_MAX, 1, &here, &anywhere);
  if (anywhere && !implementation->prefers_direct())
    implementation->near = std::make_unique<NearMatrix>(matrix, implementation->block_size, places);
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
  if (solver.prefers_direct())
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
    solver.eliminated = Teuchos::rcp(new Eliminated(solver.matrix, border, corner));
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
    return direct;
  }
  return report;
}

bool solve_positive_definite(const Teuchos::RCP<const TpetraMatrix>& matrix, const TpetraVector& right_side,
                             TpetraVector& x, const double relative_tolerance)
{
  x.putScalar(0.);
  if (right_side.normInf() == 0.)
    return true;
  auto problem = Teuchos::rcp(new Belos::LinearProblem<double, MultiVector, Operator>(
      matrix, Teuchos::rcpFromRef<MultiVector>(x), Teuchos::rcpFromRef<const MultiVector>(right_side)));
  problem->setLeftPrec(Teuchos::rcp(new Jacobi(*matrix)));
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
