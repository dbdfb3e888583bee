#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <kedge/solvers/block_gauss_seidel.h>

using namespace kedge;

namespace
{
constexpr unsigned int n_nodes = 5, block_size = 3, n = n_nodes * block_size;

/// An unsymmetric matrix with a strong diagonal, all on this rank.
Eigen::MatrixXd dense_matrix()
{
  Eigen::MatrixXd a(n, n);
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < n; ++j)
      a(i, j) = i == j ? 9. + i : 1. / (1. + 2. * i + j);
  return a;
}

/// Forward, then backward over the nodes, in double precision.
Eigen::VectorXd sweep_by_hand(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd x)
{
  for (unsigned int step = 0; step < 2 * n_nodes; ++step)
  {
    const unsigned int v = block_size * (step < n_nodes ? step : 2 * n_nodes - 1 - step);
    const Eigen::MatrixXd diagonal = a.block(v, v, block_size, block_size);
    const Eigen::VectorXd rest = b.segment(v, block_size) - a.middleRows(v, block_size) * x;
    x.segment(v, block_size) += diagonal.lu().solve(rest);
  }
  return x;
}

struct Equations
{
  Eigen::MatrixXd a;
  Teuchos::RCP<TpetraMatrix> matrix;
  Teuchos::RCP<TpetraVector> b, x;
  Eigen::VectorXd side = Eigen::VectorXd(n), start = Eigen::VectorXd(n);
};

/// Entries between nodes that `coupled` denies are left out.
template <typename Coupled> Equations make_equations(const Coupled& coupled)
{
  Equations made;
  made.a = dense_matrix();
  const auto map = Teuchos::rcp(new TpetraMap(n, 0, Teuchos::rcp(new Teuchos::SerialComm<int>())));
  made.matrix = Teuchos::rcp(new TpetraMatrix(map, n));
  made.b = Teuchos::rcp(new TpetraVector(map));
  made.x = Teuchos::rcp(new TpetraVector(map));
  for (unsigned int i = 0; i < n; ++i)
  {
    for (unsigned int j = 0; j < n; ++j)
      if (coupled(i / block_size, j / block_size))
        made.matrix->insertGlobalValues(i, Teuchos::tuple<GlobalOrdinal>(j), Teuchos::tuple<double>(made.a(i, j)));
      else
        made.a(i, j) = 0.;
    made.side[i] = 1. + i % 4;
    made.start[i] = 0.3 * (i % 3);
    made.b->replaceLocalValue(i, made.side[i]);
    made.x->replaceLocalValue(i, made.start[i]);
  }
  made.matrix->fillComplete();
  return made;
}

NodeBlocks blocks_of(const Equations& at) { return make_node_blocks(*at.matrix, block_size); }

bool all_coupled(unsigned int, unsigned int) { return true; }
bool in_a_chain(const unsigned int v, const unsigned int w) { return v <= w + 1 && w <= v + 1; }

void expect_values(const TpetraVector& x, const Eigen::VectorXd& expected)
{
  const auto result = x.getLocalViewHost(Tpetra::Access::ReadOnly);
  for (unsigned int i = 0; i < n; ++i)
    EXPECT_NEAR(result(i, 0), expected[i], 1e-6); // the matrix is held in single precision
}
} // namespace

TEST(BlockGaussSeidel, SweepsOverTheNodesToAndFro)
{
  const Equations at = make_equations(all_coupled);
  const BlockGaussSeidel smoother(*at.matrix, blocks_of(at), SweepOrder::by_number);
  EXPECT_EQ(smoother.n_colours(), 1u);
  smoother.sweep(*at.b, *at.x);
  expect_values(*at.x, sweep_by_hand(at.a, at.side, at.start));
}

TEST(BlockGaussSeidel, TakesTheMatrixAsItIsNow)
{
  const Equations at = make_equations(all_coupled);
  const NodeBlocks blocks = blocks_of(at);
  const BlockGaussSeidel smoother(*at.matrix, blocks, SweepOrder::by_number);
  at.matrix->resumeFill();
  at.matrix->scale(2.);
  at.matrix->fillComplete();
  renew_node_blocks(*at.matrix, blocks);
  smoother.sweep(*at.b, *at.x);
  expect_values(*at.x, sweep_by_hand(2. * at.a, at.side, at.start));
}

TEST(BlockGaussSeidel, NodesOfOneColourAreNotCoupled)
{
  const Equations dense = make_equations(all_coupled);
  EXPECT_EQ(BlockGaussSeidel(*dense.matrix, blocks_of(dense), SweepOrder::by_colour).n_colours(), n_nodes);
  const Equations chain = make_equations(in_a_chain);
  const auto n_colours = BlockGaussSeidel(*chain.matrix, blocks_of(chain), SweepOrder::by_colour).n_colours();
  EXPECT_GE(n_colours, 2u);
  EXPECT_LE(n_colours, 3u);
}

TEST(BlockGaussSeidel, SweepsByColourFindTheSolution)
{
  const Equations at = make_equations(in_a_chain);
  const BlockGaussSeidel smoother(*at.matrix, blocks_of(at), SweepOrder::by_colour);
  for (unsigned int i = 0; i < 8; ++i)
    smoother.sweep(*at.b, *at.x);
  expect_values(*at.x, at.a.lu().solve(at.side));
}
