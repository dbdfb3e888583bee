#include "../mesh/refined_mesh.h"
#include <gtest/gtest.h>
#include <kedge/soil/prediction.h>
#include <limits>

using namespace kedge;

namespace
{
template <typename Dimension> class PredictionOn : public testing::Test, public test::RefinedMesh<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;

  static double component(const std::array<double, dim>& x, const unsigned int d)
  {
    double value = 0.1 * (d + 1.);
    for (unsigned int e = 0; e < dim; ++e)
      value += (1. + d - 0.5 * e) * x[e];
    return value;
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(PredictionOn, Dimensions, test::DimensionName);
} // namespace

/// A rank is sure to know the values of the nodes that it owns, not those of others.
TYPED_TEST(PredictionOn, AnotherMeshAndPartitionIsExactWhereItIsLinear)
{
  constexpr int dim = TypeParam::value;
  const LeafTable<dim> before = this->mesh.leaves();
  std::vector<double> known(dim * before.node_position.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t node = 0; node < before.node_position.size(); ++node)
    for (unsigned int d = 0; d < dim && before.node_owner_is_me[node]; ++d)
      known[dim * node + d] = this->component(before.node_position[node], d);

  test::refine_some_cells(this->mesh, 17);
  std::vector<double> work(this->mesh.triangulation().n_active_cells(), 1.);
  for (const auto& cell : this->mesh.triangulation().active_cell_iterators())
    if (cell->center()[0] < 0.4)
      work[cell->active_cell_index()] = 5.;
  this->mesh.repartition(work);
  this->mesh.update();

  const LeafTable<dim>& after = this->mesh.leaves();
  const Prediction moved = transfer_prediction<dim>(known, before, after, MPI_COMM_WORLD);
  ASSERT_TRUE(moved.has_value());
  ASSERT_EQ(moved->size(), dim * after.node_position.size());
  for (std::size_t node = 0; node < after.node_position.size(); ++node)
    for (unsigned int d = 0; d < dim; ++d)
      EXPECT_NEAR((*moved)[dim * node + d], this->component(after.node_position[node], d), 1e-12);
}
