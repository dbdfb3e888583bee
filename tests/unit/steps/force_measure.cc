#include <cmath>
#include <gtest/gtest.h>
#include <kedge/assembly/node_graph.h>
#include <kedge/steps/force_measure.h>

using namespace kedge;

namespace
{
/// Forces at the nodes of one rank, two entries each; the other ranks have the same.
struct Nodes
{
  explicit Nodes(const std::vector<double>& sizes_of_cells)
      : map(Teuchos::rcp(new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(),
                                       2 * sizes_of_cells.size(), 0, Tpetra::getDefaultComm()))),
        measure(2, MPI_COMM_WORLD, sizes_of_cells)
  {
  }

  TpetraVector vector(const std::vector<double>& first_entries) const
  {
    TpetraVector result(map);
    const auto view = result.getLocalViewHost(Tpetra::Access::ReadWrite);
    for (std::size_t v = 0; v < first_entries.size(); ++v)
      view(2 * v, 0) = first_entries[v];
    return result;
  }

  Teuchos::RCP<const TpetraMap> map;
  ForceMeasure measure;
};
} // namespace

TEST(ForceMeasure, AFineNodeCountsAsMuchAsACoarseOne)
{
  Nodes nodes({1., 0.01}); // cells under the same stress: in the plane, forces go with their size
  nodes.measure.renew(nodes.vector({1000., 10.}));
  const double coarse = nodes.measure.of(nodes.vector({100., 0.})), fine = nodes.measure.of(nodes.vector({0., 1.}));
  EXPECT_NEAR(coarse, 0.05 / std::sqrt(2.), 1e-14); // the mean stress is added at every node
  EXPECT_NEAR(fine, coarse, 1e-14);
}

TEST(ForceMeasure, DoesNotDependOnTheUnitOfForce)
{
  Nodes nodes({1., 0.5, 0.25});
  nodes.measure.renew(nodes.vector({3., 0., 1.}));
  const double measure = nodes.measure.of(nodes.vector({0.1, -0.2, 0.3}));
  nodes.measure.renew(nodes.vector({3e6, 0., 1e6}));
  EXPECT_NEAR(nodes.measure.of(nodes.vector({0.1e6, -0.2e6, 0.3e6})), measure, 1e-12 * measure);
}

TEST(ForceMeasure, SoilWithoutStressNeedsNoBetterBalanceThanTheRest)
{
  Nodes nodes({1., 1.});
  nodes.measure.renew(nodes.vector({std::sqrt(2.), 0.})); // the mean square is 1
  EXPECT_NEAR(nodes.measure.of(nodes.vector({0., 0.01})), 0.01 / std::sqrt(2.), 1e-14);
}

TEST(ForceMeasure, OneNodeAmongManyCounts)
{
  Nodes nodes(std::vector<double>(10000, 1.));
  std::vector<double> sizes(10000, 1.), residual(10000, 0.);
  nodes.measure.renew(nodes.vector(sizes));
  residual[77] = 2.;
  EXPECT_NEAR(nodes.measure.of(nodes.vector(residual)), 1. / 50., 1e-12); // 0.01 / sqrt(ranks) without the limit
  const WorstNode worst = nodes.measure.worst(nodes.vector(residual));
  EXPECT_EQ(worst.node, 77u);
  EXPECT_EQ(worst.rank, 0);
  EXPECT_NEAR(worst.share, 1., 1e-12);
}

TEST(ForceMeasure, WithoutForcesOnlyZeroIsBalance)
{
  Nodes nodes({1., 1.});
  EXPECT_TRUE(nodes.measure.is_zero());
  EXPECT_EQ(nodes.measure.of(nodes.vector({0., 0.})), 0.);
  EXPECT_EQ(nodes.measure.of(nodes.vector({1e-9, 0.})), INFINITY);
}
