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
} // namespace

TEST(BlockGaussSeidel, SweepsOverTheNodesToAndFro)
{
  const Eigen::MatrixXd a = dense_matrix();
  const auto communicator = Teuchos::rcp(new Teuchos::SerialComm<int>());
  const auto map = Teuchos::rcp(new TpetraMap(n, 0, communicator));
  TpetraMatrix matrix(map, n);
  TpetraVector b(map), x(map);
  Eigen::VectorXd side(n), start(n);
  for (unsigned int i = 0; i < n; ++i)
  {
    for (unsigned int j = 0; j < n; ++j)
      matrix.insertGlobalValues(i, Teuchos::tuple<GlobalOrdinal>(j), Teuchos::tuple<double>(a(i, j)));
    side[i] = 1. + i % 4;
    start[i] = 0.3 * (i % 3);
    b.replaceLocalValue(i, side[i]);
    x.replaceLocalValue(i, start[i]);
  }
  matrix.fillComplete();
  BlockGaussSeidel(matrix, block_size).sweep(b, x);
  const Eigen::VectorXd expected = sweep_by_hand(a, side, start);
  const auto result = x.getLocalViewHost(Tpetra::Access::ReadOnly);
  for (unsigned int i = 0; i < n; ++i)
    EXPECT_NEAR(result(i, 0), expected[i], 1e-6); // the matrix is held in single precision
}
