#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/solvers/linear_solver.h>
#include <kedge/solvers/multigrid.h>

using namespace kedge;

namespace
{
/// Three coupled seven-point Laplacians on a cube of n^3 nodes, held at its boundary. Some convection makes the matrix
/// unsymmetric. The block size is 3, and the condition number grows with n^2.
struct Cube
{
  explicit Cube(const unsigned int n, const double stiffness_of_last_node = 1.,
                const bool holds_around_last_node = false)
  {
    const long long n_nodes = static_cast<long long>(n) * n * n;
    const auto is_held = [&](const long long node)
    {
      const long long offset = n_nodes - 1 - node;
      return holds_around_last_node && (offset == 1 || offset == n || offset == static_cast<long long>(n) * n);
    };
    const auto communicator = Tpetra::getDefaultComm();
    const long long first = n_nodes * communicator->getRank() / communicator->getSize();
    const long long last = n_nodes * (communicator->getRank() + 1) / communicator->getSize();
    map = Teuchos::rcp(new TpetraMap(3 * n_nodes, 3 * (last - first), 0, communicator));
    matrix = Teuchos::rcp(new TpetraMatrix(map, 24));
    for (long long node = first; node < last; ++node)
    {
      const std::array<long long, 3> x{{node % n, node / n % n, node / n / n}};
      const std::array<long long, 3> stride{{1, n, static_cast<long long>(n) * n}};
      const double scale = node == n_nodes - 1 ? stiffness_of_last_node : 1.;
      for (unsigned int d = 0; d < 3; ++d)
      {
        insert(3 * node + d, 3 * node + d, scale * (6. + d));
        insert(3 * node + d, 3 * node + (d + 1) % 3, is_held(node) ? 0. : scale * 0.3);
        for (unsigned int axis = 0; axis < 3; ++axis)
        {
          const auto couple = [&](const long long other, const double value)
          { insert(3 * node + d, 3 * other + d, is_held(node) || is_held(other) ? 0. : scale * value); };
          if (x[axis] > 0)
            couple(node - stride[axis], -1.1);
          if (x[axis] + 1 < n)
            couple(node + stride[axis], -0.9);
        }
      }
      for (unsigned int d = 0; d < 3; ++d)
        position.push_back(double(x[d]));
    }
    matrix->fillComplete();
    right_side = Teuchos::rcp(new TpetraVector(map));
    right_side->randomize();
    solution = Teuchos::rcp(new TpetraVector(map));
  }

  void insert(const GlobalOrdinal row, const GlobalOrdinal column, const double value)
  {
    matrix->insertGlobalValues(row, Teuchos::tuple<GlobalOrdinal>(column), Teuchos::tuple<double>(value));
  }

  LinearReport solve(const SolverParameters& parameters, const double tolerance) const
  {
    LinearSolver solver(parameters, 3);
    solver.set_structure(matrix, modes());
    return solver.solve(*right_side, *solution, tolerance);
  }

  Teuchos::RCP<TpetraMultiVector> modes() const
  {
    return make_rigid_body_modes(map, 3, position, std::vector<unsigned char>(position.size(), 0));
  }

  double relative_residual() const
  {
    TpetraVector r(map);
    matrix->apply(*solution, r);
    r.update(1., *right_side, -1.);
    return r.norm2() / right_side->norm2();
  }

  Teuchos::RCP<const TpetraMap> map;
  Teuchos::RCP<TpetraMatrix> matrix;
  Teuchos::RCP<TpetraVector> right_side, solution;
  std::vector<double> position;
};

SolverParameters choose(const LinearSolverChoice choice)
{
  SolverParameters parameters;
  parameters.linear_solver = choice;
  return parameters;
}
} // namespace

TEST(LinearSolver, FactorisesSmallSystems)
{
  const Cube cube(5);
  const LinearReport report = cube.solve(SolverParameters(), 1e-3);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.method, "UMFPACK");
  EXPECT_LT(cube.relative_residual(), 1e-12);
}

TEST(LinearSolver, IteratesOnLargeSystems)
{
  const Cube cube(14); // 15^3 nodes
  const LinearReport report = cube.solve(SolverParameters(), 1e-8);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.method, "GMRES");
  EXPECT_EQ(report.escalations, 0u);
  EXPECT_LT(cube.relative_residual(), 1e-8);
}

TEST(LinearSolver, MultigridKeepsTheIterationsAsTheGridGrows)
{
  const unsigned int few = Cube(10).solve(choose(LinearSolverChoice::iterative), 1e-8).iterations;
  const unsigned int many = Cube(20).solve(choose(LinearSolverChoice::iterative), 1e-8).iterations;
  EXPECT_LE(many, 2 * few);
}

TEST(LinearSolver, StopsAtTheRequestedTolerance)
{
  const Cube cube(10);
  const unsigned int loose = cube.solve(choose(LinearSolverChoice::iterative), 1e-2).iterations;
  const double residual = cube.relative_residual();
  EXPECT_LT(residual, 1e-2);
  EXPECT_LT(loose, cube.solve(choose(LinearSolverChoice::iterative), 1e-8).iterations);
}

TEST(LinearSolver, EscalatesToAFactorisationIfKrylovStalls)
{
  const Cube cube(10);
  SolverParameters parameters = choose(LinearSolverChoice::iterative);
  parameters.max_linear_iterations = 1;
  const LinearReport report = cube.solve(parameters, 1e-8);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.method, "UMFPACK");
  EXPECT_EQ(report.escalations, 2u);
  EXPECT_LT(cube.relative_residual(), 1e-12);
}

TEST(LinearSolver, ReusesTheHierarchyForChangedValues)
{
  const Cube cube(10);
  LinearSolver solver(choose(LinearSolverChoice::iterative), 3);
  solver.set_structure(cube.matrix, cube.modes());
  const unsigned int fresh = solver.solve(*cube.right_side, *cube.solution, 1e-8).iterations;
  cube.matrix->resumeFill();
  cube.matrix->scale(1.1);
  cube.matrix->fillComplete();
  const LinearReport again = solver.solve(*cube.right_side, *cube.solution, 1e-8);
  EXPECT_TRUE(again.converged);
  EXPECT_LE(again.iterations, fresh + 2);
  EXPECT_LT(cube.relative_residual(), 1e-8);
}

TEST(LinearSolver, RenewsAHierarchyThatHasWornOut)
{
  const Cube cube(12);
  const SolverParameters parameters = choose(LinearSolverChoice::iterative);
  LinearSolver solver(parameters, 3);
  solver.set_structure(cube.matrix, cube.modes());
  solver.solve(*cube.right_side, *cube.solution, 1e-6);
  TpetraVector scale(cube.map); // the nodes are ten times as stiff or as soft as their neighbours, in turns
  for (std::size_t dof = 0; dof < scale.getLocalLength(); ++dof)
    scale.replaceLocalValue(dof, cube.map->getGlobalElement(dof) / 3 % 2 == 0 ? 3. : 0.3);
  cube.matrix->leftScale(scale);
  cube.matrix->rightScale(scale);
  const unsigned int worn = solver.solve(*cube.right_side, *cube.solution, 1e-6).iterations;
  const unsigned int renewed = solver.solve(*cube.right_side, *cube.solution, 1e-6).iterations;
  EXPECT_EQ(renewed, cube.solve(parameters, 1e-6).iterations);
  EXPECT_GT(worn, renewed + 9);
}

TEST(Multigrid, IsRenewedWhereEntriesWereZero)
{
  const Cube cube(16);
  const auto values = cube.matrix->getLocalMatrixDevice().values;
  std::vector<double> kept(values.extent(0));
  for (std::size_t k = 0; k < kept.size(); ++k)
  {
    kept[k] = values(k);
    if (k % 5 == 0 && std::fabs(kept[k]) < 2.) // not of the diagonal
      values(k) = 0.;
  }
  std::string trouble;
  const auto multigrid = Multigrid::build(cube.matrix, cube.modes(), 3, false, trouble);
  EXPECT_EQ(trouble, "");
  ASSERT_FALSE(multigrid.is_null());
  for (std::size_t k = 0; k < kept.size(); ++k)
    values(k) = kept[k];
  EXPECT_TRUE(multigrid->renew());
}

TEST(LinearSolver, ReportsASingularMatrixToTheDirectSolver)
{
  EXPECT_FALSE(Cube(4, 0.).solve(choose(LinearSolverChoice::direct), 1e-8).converged);
}

TEST(LinearSolver, ReportsASingularMatrixAfterAllEscalations)
{
  const LinearReport report = Cube(4, 0.).solve(choose(LinearSolverChoice::iterative), 1e-8);
  EXPECT_FALSE(report.converged);
}

TEST(RigidBodyModes, AreTranslationsAndRotationsOfTheWholeBody)
{
  // Every mode must be a + w x X with the same a and w on all ranks. Then differences of displacements are skew in
  // position.
  const Cube cube(4);
  const auto modes = cube.modes();
  ASSERT_EQ(modes->getNumVectors(), 6u);
  TpetraVector rigid(cube.map);
  {
    const std::array<double, 3> a{{0.3, -0.2, 0.7}}, w{{1., -2., 0.5}};
    auto view = rigid.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (std::size_t v = 0; v < cube.position.size() / 3; ++v)
      for (unsigned int d = 0; d < 3; ++d)
      {
        const unsigned int i = (d + 1) % 3, j = (d + 2) % 3;
        view(3 * v + d, 0) = a[d] + w[i] * cube.position[3 * v + j] - w[j] * cube.position[3 * v + i];
      }
  }
  // Modes about the common centre are orthogonal on a cube, so projections remove the motion entirely.
  for (std::size_t mode = 0; mode < 6; ++mode)
  {
    const auto column = modes->getVector(mode);
    const double factor = column->dot(rigid) / column->dot(*column);
    rigid.update(-factor, *column, 1.);
  }
  EXPECT_LT(rigid.normInf(), 1e-12);
}

TEST(RigidBodyModes, HardlyMoveConstrainedDofs)
{
  const Cube cube(5); // three nodes and more on each rank
  std::vector<unsigned char> constrained(cube.position.size(), 0);
  constrained[4] = 1;
  const auto modes = make_rigid_body_modes(cube.map, 3, cube.position, constrained);
  const auto view = modes->getLocalViewHost(Tpetra::Access::ReadOnly);
  for (std::size_t mode = 0; mode < 6; ++mode)
    EXPECT_LT(std::abs(view(4, mode)), 1e-9); // of 1
  EXPECT_EQ(view(7, 1), 1.);
}

TEST(LinearSolver, AcceptsNodesThatAreAllHeldAlongAnAxis)
{
  const Cube cube(12);
  std::vector<unsigned char> constrained(cube.position.size(), 0);
  for (std::size_t dof = 1; dof < constrained.size(); dof += 3)
    constrained[dof] = 1;
  SolverParameters parameters;
  parameters.linear_solver = LinearSolverChoice::iterative;
  LinearSolver solver(parameters, 3);
  solver.set_structure(cube.matrix, make_rigid_body_modes(cube.map, 3, cube.position, constrained));
  const LinearReport report = solver.solve(*cube.right_side, *cube.solution, 1e-8);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.method, "GMRES");
}

TEST(LinearSolver, AcceptsANodeThatHasOnlyHeldNeighbours)
{
  // A node that is its own aggregate has three unknowns for six modes, so the coarse matrix has empty rows.
  const Cube cube(12, 1., true);
  const LinearReport report = cube.solve(choose(LinearSolverChoice::iterative), 1e-8);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.method, "GMRES");
  EXPECT_LT(cube.relative_residual(), 1e-8);
}

TEST(RigidBodyModes, OfThePlaneAreThree)
{
  const Teuchos::RCP<const TpetraMap> map = Teuchos::rcp(
      new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(), 8, 0, Tpetra::getDefaultComm()));
  const auto modes = make_rigid_body_modes(map, 2, {0., 0., 2., 0., 0., 2., 2., 2.}, std::vector<unsigned char>(8, 0));
  ASSERT_EQ(modes->getNumVectors(), 3u);
  const auto view = modes->getLocalViewHost(Tpetra::Access::ReadOnly);
  const double rotation[8] = {1., -1., 1., 1., -1., -1., -1., 1.};
  for (unsigned int dof = 0; dof < 8; ++dof)
    EXPECT_NEAR(view(dof, 2), rotation[dof], 1e-14);
}

/// Three unknowns beside those of the cube, which couple with all of them; the whole system is tested by its residual.
static void expect_bordered_solution(const unsigned int n, const LinearSolverChoice choice)
{
  const Cube cube(n);
  SolverParameters parameters;
  parameters.linear_solver = choice;
  LinearSolver solver(parameters, 3);
  solver.set_structure(cube.matrix, cube.modes());
  Border border{Teuchos::rcp(new TpetraMultiVector(cube.map, 3)), Teuchos::rcp(new TpetraMultiVector(cube.map, 3)), {}};
  border.columns->randomize();
  border.rows->randomize();
  border.corner.resize(3, 3);
  border.corner << 900., 20., -30., 10., 800., 0., 5., -40., 700.;
  const Eigen::Vector3d c(1., -2., 3.);
  Eigen::VectorXd y;
  TpetraVector residual(*cube.right_side, Teuchos::Copy);
  const LinearReport report = solver.solve(*cube.right_side, c, border, *cube.solution, y, 1e-9);
  ASSERT_TRUE(report.converged);
  cube.matrix->apply(*cube.solution, residual, Teuchos::NO_TRANS, -1., 1.);
  Eigen::Vector3d rest = c - border.corner * y;
  for (unsigned int i = 0; i < 3; ++i)
  {
    residual.update(-y[i], *border.columns->getVector(i), 1.);
    rest[i] -= border.rows->getVector(i)->dot(*cube.solution);
  }
  EXPECT_LT(residual.norm2(), 1e-7 * cube.right_side->norm2());
  EXPECT_LT(rest.norm(), 1e-9 * (c.norm() + border.corner.norm() * y.norm()));
}

TEST(LinearSolver, EliminatesABorderIteratively) { expect_bordered_solution(12, LinearSolverChoice::iterative); }
TEST(LinearSolver, EliminatesABorderDirectly) { expect_bordered_solution(6, LinearSolverChoice::direct); }

/// Two unknowns in the border of which only the difference is determined, as for a hinged body that touches no soil.
TEST(LinearSolver, ReportsABorderThatNothingHolds)
{
  for (const LinearSolverChoice choice : {LinearSolverChoice::iterative, LinearSolverChoice::direct})
  {
    const Cube cube(4);
    SolverParameters parameters;
    parameters.linear_solver = choice;
    LinearSolver solver(parameters, 3);
    solver.set_structure(cube.matrix, cube.modes());
    const auto uncoupled = [&] { return Teuchos::rcp(new TpetraMultiVector(cube.map, 2)); };
    Border border{uncoupled(), uncoupled(), Eigen::Matrix2d()};
    border.corner << 1e9, -1e9, -1e9, 1e9;
    Eigen::VectorXd y;
    EXPECT_FALSE(solver.solve(*cube.right_side, Eigen::Vector2d(1., 2.), border, *cube.solution, y, 1e-8).converged);
    border.corner(0, 0) += 1.; // a spring of a billionth
    EXPECT_TRUE(solver.solve(*cube.right_side, Eigen::Vector2d(1., 2.), border, *cube.solution, y, 1e-8).converged);
    EXPECT_NEAR(y[0], 3., 1e-5);
  }
}
