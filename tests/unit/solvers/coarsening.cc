#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/solvers/aggregation.h>
#include <kedge/solvers/coarsening.h>
#include <kedge/solvers/linear_solver.h>

using namespace kedge;

namespace
{
/// A chain of nodes, each coupled with its two neighbours on either side, spread over the ranks.
struct Chain
{
  unsigned int dim, n_nodes;
  Teuchos::RCP<const TpetraMap> map;
  Teuchos::RCP<TpetraMatrix> matrix;
  Teuchos::RCP<TpetraMultiVector> modes;

  /// Every aggregate has at least three nodes, so that it has all modes.
  explicit Chain(const unsigned int dim_) : dim(dim_), n_nodes(15 * Tpetra::getDefaultComm()->getSize())
  {
    const auto communicator = Tpetra::getDefaultComm();
    const unsigned int first = n_nodes * communicator->getRank() / communicator->getSize(),
                       last = n_nodes * (communicator->getRank() + 1) / communicator->getSize();
    map = Teuchos::rcp(new TpetraMap(dim * n_nodes, dim * (last - first), 0, communicator));
    matrix = Teuchos::rcp(new TpetraMatrix(map, 5 * dim));
    std::vector<double> position;
    for (unsigned int v = first; v < last; ++v)
    {
      for (unsigned int w = v < 2 ? 0 : v - 2; w <= v + 2 && w < n_nodes; ++w)
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            matrix->insertGlobalValues(dim * v + i, Teuchos::tuple<GlobalOrdinal>(dim * w + j),
                                       Teuchos::tuple<double>(v == w && i == j ? 20. + v : 1. / (1. + v + 2. * w + i)));
      for (unsigned int d = 0; d < dim; ++d)
        position.push_back(d == 0 ? v : 0.1 * d + 0.3 * (v * (d + 3) % 5));
    }
    matrix->fillComplete();
    modes = make_rigid_body_modes(map, dim, position, std::vector<unsigned char>(position.size(), 0));
  }

  Coarsening coarsening() const { return Coarsening(*matrix, make_node_blocks(*matrix, dim), *modes); }
};

double largest_difference(const TpetraVector& a, const TpetraVector& b)
{
  TpetraVector difference(a, Teuchos::Copy);
  difference.update(-1., b, 1.);
  return difference.normInf();
}

/// Rows of a line of n nodes with its neighbours.
void line(const int n, std::vector<int>& row_begin, std::vector<int>& column)
{
  row_begin.assign(1, 0);
  column.clear();
  for (int v = 0; v < n; ++v)
  {
    if (v > 0)
      column.push_back(v - 1);
    column.push_back(v + 1); // the last one is another rank's
    row_begin.push_back(static_cast<int>(column.size()));
  }
}

class InBothDimensions : public testing::TestWithParam<unsigned int>
{
};
} // namespace

TEST(Aggregates, AreStarsAndWhatTouchesThem)
{
  std::vector<int> row_begin, column;
  line(8, row_begin, column);
  const Aggregates found = aggregate(row_begin, column, std::vector<unsigned char>(8, 1));
  EXPECT_EQ(found.n, 3);
  EXPECT_EQ(found.of_node, (std::vector<int>{0, 0, 1, 1, 1, 2, 2, 2}));
}

TEST(Aggregates, LeaveOutWhatIsNotTaken)
{
  std::vector<int> row_begin, column;
  line(6, row_begin, column);
  const Aggregates found = aggregate(row_begin, column, {1, 1, 0, 1, 0, 0});
  EXPECT_EQ(found.n, 2);
  EXPECT_EQ(found.of_node, (std::vector<int>{0, 0, -1, 1, -1, -1})); // a lone node is one of its own
}

TEST_P(InBothDimensions, CoarseMatrixIsTheProduct)
{
  const Chain chain(GetParam());
  const Coarsening coarsening = chain.coarsening();
  const auto coarse_map = coarsening.matrix()->getRowMap();
  EXPECT_LT(coarse_map->getGlobalNumElements(), chain.map->getGlobalNumElements());
  EXPECT_GT(coarse_map->getGlobalNumElements(), 0u);
  TpetraVector x(coarse_map), product(coarse_map), expected(coarse_map), fine(chain.map), of_fine(chain.map);
  x.randomize();
  fine.putScalar(0.);
  coarsening.add_prolonged(x, fine);
  chain.matrix->apply(fine, of_fine);
  coarsening.restrict(of_fine, expected);
  coarsening.matrix()->apply(x, product);
  EXPECT_LT(largest_difference(product, expected), 1e-5 * expected.normInf()); // single precision
}

TEST_P(InBothDimensions, CoarseMatrixFollowsTheFineOne)
{
  const Chain chain(GetParam());
  const NodeBlocks blocks = make_node_blocks(*chain.matrix, chain.dim);
  Coarsening coarsening(*chain.matrix, blocks, *chain.modes);
  TpetraVector x(coarsening.matrix()->getRowMap()), before(x.getMap()), after(x.getMap());
  x.randomize();
  coarsening.matrix()->apply(x, before);
  chain.matrix->resumeFill();
  chain.matrix->scale(4.);
  chain.matrix->fillComplete();
  renew_node_blocks(*chain.matrix, blocks);
  coarsening.renew();
  coarsening.matrix()->apply(x, after);
  before.scale(4.);
  EXPECT_LT(largest_difference(before, after), 1e-12 * after.normInf());
}

TEST_P(InBothDimensions, ModesAreKept)
{
  const Chain chain(GetParam());
  const Coarsening coarsening = chain.coarsening();
  for (std::size_t mode = 0; mode < chain.modes->getNumVectors(); ++mode)
  {
    TpetraVector prolonged(chain.map);
    coarsening.add_prolonged(*coarsening.near_null_space()->getVector(mode), prolonged);
    EXPECT_LT(largest_difference(prolonged, *chain.modes->getVector(mode)), 1e-5 * prolonged.normInf());
  }
}

INSTANTIATE_TEST_SUITE_P(Coarsening, InBothDimensions, testing::Values(2u, 3u));

TEST(Coarsening, GivesModesThatAnAggregateCannotHaveADiagonal)
{
  // One node has three unknowns for six modes.
  const auto communicator = Tpetra::getDefaultComm();
  const auto map =
      Teuchos::rcp(new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(), 3, 0, communicator));
  TpetraMatrix matrix(map, 1);
  for (int i = 0; i < 3; ++i)
  {
    const GlobalOrdinal row = map->getGlobalElement(i);
    matrix.insertGlobalValues(row, Teuchos::tuple(row), Teuchos::tuple(5.));
  }
  matrix.fillComplete();
  const auto modes = make_rigid_body_modes(map, 3, {1., 2., 3.}, {0, 0, 0});
  const Coarsening coarsening(matrix, make_node_blocks(matrix, 3), *modes);
  TpetraVector diagonal(coarsening.matrix()->getRowMap());
  coarsening.matrix()->getLocalDiagCopy(diagonal);
  const auto view = diagonal.getLocalViewHost(Tpetra::Access::ReadOnly);
  ASSERT_EQ(view.extent(0), 6u);
  for (int a = 0; a < 6; ++a)
    EXPECT_NEAR(view(a, 0), a < 3 ? 5. : 1., 1e-5);
  EXPECT_GT(coarsening.near_null_space()->getVector(5)->norm2(), 0.);
}
