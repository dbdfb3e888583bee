#include <Amesos2.hpp>
#include <BelosBlockGmresSolMgr.hpp>
#include <BelosTpetraAdapter.hpp>
#include <MueLu_CreateTpetraPreconditioner.hpp>
#include <kedge/solvers/linear_solver.h>

namespace kedge
{
namespace
{
using Operator = Tpetra::Operator<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using MultiVector = TpetraMultiVector;
using Hierarchy = MueLu::TpetraOperator<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using Factorisation = Amesos2::Solver<TpetraMatrix, MultiVector>;

constexpr std::size_t always_direct_below = 2000;     // dofs: a factorisation beats any set-up
constexpr std::size_t never_direct_above = 60000;     // dofs: fill-in of three-dimensional problems
constexpr unsigned int worn_out_factor = 3;           // iterations over those of the fresh hierarchy
constexpr unsigned int worn_out_minimum = 25;

Teuchos::ParameterList hierarchy_parameters(const unsigned int block_size, const bool strong)
{
  Teuchos::ParameterList list;
  list.set("verbosity", "none");
  list.set("number of equations", static_cast<int>(block_size));
  list.set("multigrid algorithm", "sa");
  list.set("sa: damping factor", 1.33);
  list.set("aggregation: type", "uncoupled");
  list.set("aggregation: drop tol", 0.0);
  list.set("coarse: max size", 1000);
  list.set("coarse: type", "KLU2");
  list.set("max levels", 6);
  list.set("reuse: type", "none");
  if (strong)
    {
      list.set("smoother: type", "SCHWARZ");
      Teuchos::ParameterList& smoother = list.sublist("smoother: params");
      smoother.set("schwarz: overlap level", 1);
      smoother.set("schwarz: combine mode", "Zero");
      smoother.set("subdomain solver name", "RILUK");
      smoother.sublist("subdomain solver parameters").set("fact: iluk level-of-fill", 0);
    }
  else
    {
      list.set("smoother: type", "RELAXATION");
      Teuchos::ParameterList& smoother = list.sublist("smoother: params");
      smoother.set("relaxation: type", "Symmetric Gauss-Seidel");
      smoother.set("relaxation: sweeps", 1);
      smoother.set("relaxation: damping factor", 1.0);
    }
  return list;
}
} // namespace

struct LinearSolver::Implementation
{
  SolverParameters parameters;
  unsigned int block_size;
  Teuchos::RCP<TpetraMatrix> matrix;
  Teuchos::RCP<MultiVector> near_null_space;
  Teuchos::RCP<Hierarchy> hierarchy;
  unsigned int fresh_iterations = 0;

  bool prefers_direct() const
  {
    return parameters.linear_solver == LinearSolverChoice::direct ||
           (parameters.linear_solver == LinearSolverChoice::automatic && matrix->getGlobalNumRows() < always_direct_below);
  }

  void build_hierarchy(const bool strong)
  {
    Teuchos::ParameterList list = hierarchy_parameters(block_size, strong);
    list.sublist("user data").set("Nullspace", near_null_space);
    const Teuchos::RCP<Operator> as_operator = matrix;
    hierarchy = MueLu::CreateTpetraPreconditioner<double, LocalOrdinal, GlobalOrdinal, TpetraNode>(as_operator, list);
    fresh_iterations = 0;
  }

  LinearReport solve_direct(const TpetraVector& b, TpetraVector& x) const
  {
    const auto solver = Amesos2::create<TpetraMatrix, MultiVector>(
      "KLU2", matrix, Teuchos::rcpFromRef<MultiVector>(x), Teuchos::rcpFromRef<const MultiVector>(b));
    LinearReport report;
    report.method = "KLU2";
    try
      {
        solver->symbolicFactorization().numericFactorization().solve();
      }
    catch (const std::runtime_error&) // KLU2's way of saying that the matrix is singular
      {
        return report;
      }
    report.iterations = 1;
    report.converged = std::isfinite(x.norm2());
    return report;
  }

  LinearReport solve_krylov(const TpetraVector& b, TpetraVector& x, const double tolerance) const
  {
    x.putScalar(0.);
    auto problem = Teuchos::rcp(new Belos::LinearProblem<double, MultiVector, Operator>(
      matrix, Teuchos::rcpFromRef<MultiVector>(x), Teuchos::rcpFromRef<const MultiVector>(b)));
    problem->setRightPrec(hierarchy);
    problem->setProblem();
    const auto list = Teuchos::parameterList();
    list->set("Maximum Iterations", static_cast<int>(parameters.max_linear_iterations));
    list->set("Num Blocks", static_cast<int>(std::min(parameters.max_linear_iterations, 100u)));
    list->set("Convergence Tolerance", tolerance);
    list->set("Verbosity", static_cast<int>(Belos::Errors));
    Belos::BlockGmresSolMgr<double, MultiVector, Operator> solver(problem, list);
    LinearReport report;
    report.method = "GMRES";
    report.converged = solver.solve() == Belos::Converged && std::isfinite(x.norm2());
    report.iterations = solver.getNumIters();
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
                                 const Teuchos::RCP<TpetraMultiVector>& near_null_space)
{
  implementation->matrix = matrix;
  implementation->near_null_space = near_null_space;
  implementation->hierarchy = Teuchos::null;
}

LinearReport LinearSolver::solve(const TpetraVector& right_side, TpetraVector& x, const double relative_tolerance)
{
  Implementation& solver = *implementation;
  if (solver.prefers_direct())
    return solver.solve_direct(right_side, x);

  bool fresh = false;
  const auto refresh = [&](const bool strong) {
    solver.build_hierarchy(strong);
    fresh = true;
  };
  if (solver.hierarchy.is_null() || !solver.parameters.reuse)
    refresh(false);
  LinearReport report = solver.solve_krylov(right_side, x, relative_tolerance);
  unsigned int escalations = 0, iterations = report.iterations;
  if (!report.converged && !fresh)
    {
      refresh(false);
      report = solver.solve_krylov(right_side, x, relative_tolerance);
      iterations += report.iterations;
      ++escalations;
    }
  if (!report.converged)
    {
      refresh(true);
      report = solver.solve_krylov(right_side, x, relative_tolerance);
      report.method = "GMRES with incomplete factors";
      iterations += report.iterations;
      ++escalations;
    }
  if (!report.converged && solver.matrix->getGlobalNumRows() < never_direct_above)
    {
      report = solver.solve_direct(right_side, x);
      ++escalations;
    }
  if (fresh)
    solver.fresh_iterations = report.iterations;
  else if (report.iterations > std::max(worn_out_minimum, worn_out_factor * solver.fresh_iterations))
    solver.hierarchy = Teuchos::null; // still converges, but a new one pays
  if (escalations > 0)
    solver.hierarchy = Teuchos::null;
  report.iterations = iterations;
  report.escalations = escalations;
  return report;
}

Teuchos::RCP<TpetraMultiVector> make_rigid_body_modes(const Teuchos::RCP<const TpetraMap>& map,
                                                      const unsigned int dim,
                                                      const std::vector<double>& position,
                                                      const std::vector<unsigned char>& constrained)
{
  const unsigned int n_rotations = dim == 3 ? 3 : 1;
  auto modes = Teuchos::rcp(new TpetraMultiVector(map, dim + n_rotations, true));
  auto view = modes->getLocalViewHost(Tpetra::Access::OverwriteAll);
  const std::size_t n_nodes = position.size() / dim;
  std::array<double, 3> centre{{0., 0., 0.}};
  for (std::size_t i = 0; i < position.size(); ++i)
    centre[i % dim] += position[i] / std::max<std::size_t>(1, n_nodes);

  for (std::size_t v = 0; v < n_nodes; ++v)
    {
      std::array<double, 3> x{{0., 0., 0.}};
      for (unsigned int d = 0; d < dim; ++d)
        x[d] = position[dim * v + d] - centre[d];
      const auto set = [&](const unsigned int d, const unsigned int mode, const double value) {
        view(dim * v + d, mode) = constrained[dim * v + d] ? 0. : value;
      };
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
