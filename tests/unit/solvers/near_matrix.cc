#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/solvers/near_matrix.h>

using namespace kedge;

namespace
{
constexpr long long n_nodes = 12;
constexpr unsigned int dim = 2;

/// Value of the entry (row, column) of the full matrix, by an arbitrary unsymmetric rule.
double entry(const GlobalOrdinal row, const GlobalOrdinal column) { return 1. + row + 0.1 * column * column; }

/// Nodes on a line at x = 0, 1, ..., each coupled to those up to two away; blocks of 2 x 2.
struct Chain
{
  template <typename Entry> explicit Chain(const Entry& value)
  {
    const auto communicator = Tpetra::getDefaultComm();
    const int rank = communicator->getRank(), n_ranks = communicator->getSize();
    const long long first = n_nodes * rank / n_ranks, last = n_nodes * (rank + 1) / n_ranks;
    map = Teuchos::rcp(new TpetraMap(dim * n_nodes, dim * (last - first), 0, communicator));
    matrix = Teuchos::rcp(new TpetraMatrix(map, 5 * dim));
    for (long long node = first; node < last; ++node)
    {
      places.position.push_back(node);
      places.position.push_back(0.);
      places.spacing.push_back(1.);
      for (long long other = std::max(0ll, node - 2); other <= std::min(n_nodes - 1, node + 2); ++other)
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
          {
            const GlobalOrdinal row = dim * node + i, column = dim * other + j;
            matrix->insertGlobalValues(row, Teuchos::tuple(column), Teuchos::tuple(value(row, column)));
          }
    }
    matrix->fillComplete();
  }

  Teuchos::RCP<const TpetraMap> map;
  Teuchos::RCP<TpetraMatrix> matrix;
  NodePlaces places;
};

/// Largest difference between A v and B v for v = 1 in component `component` of every node.
double difference_on_translation(const TpetraMatrix& a, const TpetraMatrix& b, const unsigned int component)
{
  TpetraVector v(a.getDomainMap()), av(a.getRangeMap()), bv(a.getRangeMap());
  {
    auto view = v.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (std::size_t dof = 0; dof < view.extent(0); ++dof)
      view(dof, 0) = dof % dim == component;
  }
  a.apply(v, av);
  b.apply(v, bv);
  av.update(-1., bv, 1.);
  return av.normInf();
}
} // namespace

TEST(NearMatrix, KeepsNeighboursOnly)
{
  const Chain chain(entry);
  const NearMatrix near(chain.matrix, dim, chain.places);
  EXPECT_EQ(near.matrix()->getGlobalNumEntries(), dim * dim * (3 * n_nodes - 2));
}

TEST(NearMatrix, RespondsToTranslationsLikeTheFullMatrix)
{
  const Chain chain(entry);
  NearMatrix near(chain.matrix, dim, chain.places);
  chain.matrix->resumeFill();
  chain.matrix->scale(3.);
  chain.matrix->fillComplete();
  EXPECT_GT(difference_on_translation(*chain.matrix, *near.matrix(), 0), 1.); // stale values
  near.update();
  for (unsigned int component = 0; component < dim; ++component)
    EXPECT_LT(difference_on_translation(*chain.matrix, *near.matrix(), component), 1e-11);
}

TEST(NearMatrix, DoesNotWeakenTheDiagonal)
{
  const auto weak = [](const GlobalOrdinal row, const GlobalOrdinal column) { return row == column ? 1. : -0.4; };
  const Chain chain(weak);
  const NearMatrix near(chain.matrix, dim, chain.places);
  TpetraVector diagonal(chain.map);
  near.matrix()->getLocalDiagCopy(diagonal);
  double smallest = INFINITY;
  const auto view = diagonal.getLocalViewHost(Tpetra::Access::ReadOnly);
  for (std::size_t dof = 0; dof < view.extent(0); ++dof)
    smallest = std::min(smallest, view(dof, 0));
  EXPECT_GE(smallest, 1.);
}
