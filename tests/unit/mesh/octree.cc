#include "refined_mesh.h"
#include <gtest/gtest.h>
#include <kedge/mesh/octree.h>
#include <map>

using namespace kedge;

namespace
{
template <typename Dimension> class Octree : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Places = std::vector<LeafPlace<dim>>;
  using Owners = std::map<std::pair<unsigned int, std::array<std::int64_t, dim>>, int>;

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells{};
    for (unsigned int d = 0; d < dim; ++d)
      cells[d] = 3 + d;
    return make(cells);
  }
  static GridLayout<dim> make(const std::array<unsigned int, dim>& cells) { return test::make_brick<dim>(cells, 0.3); }

  /// A mesh refined twice at random and distributed over the ranks by very uneven work.
  static void change(BackgroundMesh<dim>& mesh)
  {
    test::refine_some_cells(mesh, 1);
    mesh.repartition();
    mesh.update();
    test::refine_some_cells(mesh, 2);
    std::vector<double> work(mesh.triangulation().n_active_cells(), 0.);
    for (const auto& cell : mesh.triangulation().active_cell_iterators())
      if (cell->is_locally_owned())
        work[cell->active_cell_index()] = cell->center()[dim - 1] < 0.4 ? 30. : 1.;
    mesh.repartition(work);
    mesh.update();
  }

  static Places places(const BackgroundMesh<dim>& mesh)
  {
    Places mine;
    for (const auto& cell : cells_in_forest_order(mesh))
      mine.push_back(place_of(cell, mesh));
    return gather_everywhere(mine, mesh.communicator());
  }

  /// Ranks of this rank's leaves and ghosts.
  static Owners owners(const BackgroundMesh<dim>& mesh)
  {
    Owners result;
    for (const auto& cell : mesh.triangulation().active_cell_iterators())
      if (!cell->is_artificial())
      {
        const LeafPlace<dim> place = place_of<dim>(cell, mesh);
        result[{place.level, place.index}] = cell->subdomain_id();
      }
    return result;
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Octree, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Octree, IsBuiltAgainWithItsPartition)
{
  constexpr int dim = TypeParam::value;
  BackgroundMesh<dim> mesh(MPI_COMM_WORLD, TestFixture::layout()), again(MPI_COMM_WORLD, TestFixture::layout());
  TestFixture::change(mesh);
  const std::int64_t mine = cells_in_forest_order(mesh).size();
  const auto places = TestFixture::places(mesh);
  std::vector<LeafPlace<dim>> share; // whosever they are
  for (std::size_t i = rank_of(MPI_COMM_WORLD); i < places.size(); i += size_of(MPI_COMM_WORLD))
    share.push_back(places[i]);
  refine_to(again, share);
  repartition_to(again, gather_everywhere(std::vector<std::int64_t>{mine}, MPI_COMM_WORLD));
  again.update();
  EXPECT_EQ(TestFixture::owners(again), TestFixture::owners(mesh));
}

TYPED_TEST(Octree, OrderDoesNotDependOnTheRanks)
{
  constexpr int dim = TypeParam::value;
  BackgroundMesh<dim> mesh(MPI_COMM_WORLD, TestFixture::layout()), alone(MPI_COMM_SELF, TestFixture::layout());
  TestFixture::change(mesh);
  TestFixture::change(alone);
  const auto places = TestFixture::places(mesh), expected = TestFixture::places(alone);
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    EXPECT_EQ(places[i].level, expected[i].level) << i;
    EXPECT_EQ(places[i].index, expected[i].index) << i;
  }
}
