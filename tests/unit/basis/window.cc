// At the planes of the moving window the basis ends as it does at the faces of the grid.
#include "../mesh/refined_mesh.h"
#include "box_average.h"
#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/basis/ghost_faces.h>
#include <kedge/basis/gimp.h>

using namespace kedge;

namespace
{
/// The refined mesh with a window of its middle column of base cells, from 0.3 m to 0.6 m; boxes in all active leaves
/// reach across the planes.
template <typename Dimension> class BasisInWindow : public testing::Test, public test::RefinedMesh<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;
  static constexpr double lower = 0.3, upper = 0.6, round_off = 1e-12;
  using Position = std::array<double, dim>;

  BasisInWindow()
  {
    Window<dim> window{{}, this->layout().base_cells};
    window.lower[0] = 1;
    window.upper[0] = 2;
    this->mesh.set_window(window);
    for (unsigned int i = 0; i < table().leaves.size(); ++i)
    {
      const auto& leaf = table().leaves[i];
      if (!leaf.owned || !table().in_window(leaf))
        continue;
      Position middle, half;
      for (unsigned int d = 0; d < dim; ++d)
        middle[d] = leaf.lower[d] + 0.5 * leaf.size;
      half.fill(0.8 * leaf.size);
      centre.push_back(middle);
      half_width.push_back(half);
      leaf_of_box.push_back(i);
    }
  }

  const LeafTable<dim>& table() const { return this->mesh.leaves(); }

  std::vector<LeafContent> contents() const
  {
    const std::vector<double> ones(centre.size(), 1.);
    return find_leaf_contents<dim>(
        table(), {find_box_parts<dim>(table(), centre, half_width), half_width, ones, ones, ones}, 0., MPI_COMM_WORLD);
  }

  std::vector<Position> centre, half_width;
  std::vector<unsigned int> leaf_of_box;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(BasisInWindow, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(BasisInWindow, SumsToOneAndItsGradientsToZero)
{
  constexpr int dim = TypeParam::value;
  for (std::size_t p = 0; p < this->centre.size(); ++p)
  {
    double sum = 0., largest_sum = 0.;
    std::array<double, dim> gradient{};
    for (const auto& share : test::average_over_box<dim>(this->table(), this->centre[p], this->half_width[p]))
    {
      sum += share.value;
      for (unsigned int d = 0; d < dim; ++d)
        gradient[d] += share.gradient[d];
    }
    for (const double g : gradient)
      largest_sum = std::max(largest_sum, std::abs(g));
    EXPECT_NEAR(sum, 1., this->round_off);
    EXPECT_LT(largest_sum * this->half_width[p][0], this->round_off);
  }
}

TYPED_TEST(BasisInWindow, HasItsCentreInThatOfTheBox)
{
  constexpr int dim = TypeParam::value;
  unsigned int shrunk = 0;
  for (std::size_t p = 0; p < this->centre.size(); ++p)
  {
    double x = 0.;
    for (const auto& share : test::average_over_box<dim>(this->table(), this->centre[p], this->half_width[p]))
      x += share.value * this->table().node_position[share.node][0];
    const double low = this->centre[p][0] - this->half_width[p][0], high = this->centre[p][0] + this->half_width[p][0];
    shrunk += low < this->lower - 1e-6 || high > this->upper + 1e-6;
    EXPECT_NEAR(x, this->centre[p][0], this->round_off);
  }
  EXPECT_GT(sum_over_ranks(static_cast<long long>(shrunk), MPI_COMM_WORLD), 0);
}

TYPED_TEST(BasisInWindow, NamesNoNodesBeyondThePlanes)
{
  const HostStencils stencils = build_stencils<TypeParam::value>(
      this->table(), find_box_parts<TypeParam::value>(this->table(), this->centre, this->half_width));
  for (const unsigned int node : stencils.pattern_nodes)
  {
    EXPECT_GT(this->table().node_position[node][0], this->lower - 1e-9);
    EXPECT_LT(this->table().node_position[node][0], this->upper + 1e-9);
  }
}

TYPED_TEST(BasisInWindow, HasNoBoundaryCellsAtThePlanes)
{
  // The soil fills the window, and cells beyond it are no neighbours.
  const auto contents = this->contents();
  for (std::size_t i = 0; i < contents.size(); ++i)
  {
    EXPECT_EQ(contents[i].boundary, 0.);
    EXPECT_EQ(is_populated(contents[i]), this->table().in_window(this->table().leaves[i]));
  }
}
