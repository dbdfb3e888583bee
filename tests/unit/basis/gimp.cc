#include "../mesh/refined_mesh.h"
#include "box_average.h"
#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/basis/gimp.h>
#include <map>

using namespace kedge;

namespace
{
/// Boxes on a refined mesh, centred in this rank's cells and no wider than the cell of their centre.
template <typename Dimension> class Gimp : public testing::Test, public test::RefinedMesh<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;
  using Point = std::array<double, dim>;
  struct Box
  {
    Point centre, half_width;
  };

  const LeafTable<dim>& table() const { return this->mesh.leaves(); }

  std::vector<Box> random_boxes(const unsigned int per_leaf) const
  {
    test::RankRandom random(3);
    std::vector<Box> boxes;
    for (const auto& leaf : table().leaves)
      for (unsigned int n = 0; leaf.owned && n < per_leaf; ++n)
      {
        Box box;
        for (unsigned int d = 0; d < dim; ++d)
        {
          box.centre[d] = leaf.lower[d] + leaf.size * random(0., 1.);
          box.half_width[d] = 0.5 * leaf.size * random(0.01, 1.);
        }
        boxes.push_back(box);
      }
    return boxes;
  }

  /// As far to either side of the centre as the grid allows.
  Box shrunk(Box box) const
  {
    for (unsigned int d = 0; d < dim; ++d)
      box.half_width[d] = std::min({box.half_width[d], box.centre[d], this->mesh.layout().extent(d) - box.centre[d]});
    return box;
  }

  std::vector<NodeShare<dim>> average(const Box& box) const
  {
    return test::average_over_box<dim>(table(), box.centre, box.half_width);
  }

  /// Largest difference of values, and of gradients times a length, between two sets of shares.
  double difference(const std::vector<NodeShare<dim>>& a, const std::vector<NodeShare<dim>>& b,
                    const double length) const
  {
    std::map<unsigned int, std::array<double, dim + 1>> sums;
    for (const double sign : {1., -1.})
      for (const NodeShare<dim>& share : sign > 0. ? a : b)
      {
        auto& sum = sums[share.node];
        sum[dim] += sign * share.value;
        for (unsigned int d = 0; d < dim; ++d)
          sum[d] += sign * length * share.gradient[d];
      }
    double largest = 0.;
    for (const auto& [node, sum] : sums)
      for (const double entry : sum)
        largest = std::max(largest, std::abs(entry));
    return largest;
  }

  /// Largest over all boxes of all ranks of a number per box.
  template <typename Error> double worst(const Error& error) const
  {
    double largest = 0.;
    for (const Box& box : random_boxes(20))
      largest = std::max(largest, error(box, average(box)));
    return max_over_ranks(largest, MPI_COMM_WORLD);
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Gimp, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Gimp, ValuesSumToOne)
{
  EXPECT_LT(this->worst(
                [](const auto&, const auto& shares)
                {
                  double sum = -1.;
                  for (const auto& share : shares)
                    sum += share.value;
                  return std::abs(sum);
                }),
            1e-12);
}

TYPED_TEST(Gimp, GradientsSumToZero)
{
  EXPECT_LT(this->worst(
                [](const auto& box, const auto& shares)
                {
                  double largest = 0.;
                  for (unsigned int d = 0; d < TypeParam::value; ++d)
                  {
                    double sum = 0.;
                    for (const auto& share : shares)
                      sum += share.gradient[d] * box.half_width[d];
                    largest = std::max(largest, std::abs(sum));
                  }
                  return largest;
                }),
            1e-12);
}

TYPED_TEST(Gimp, PositionsAverageToTheCentreOfTheBox)
{
  EXPECT_LT(this->worst(
                [&](const auto& box, const auto& shares)
                {
                  double largest = 0.;
                  for (unsigned int d = 0; d < TypeParam::value; ++d)
                  {
                    double sum = -box.centre[d];
                    for (const auto& share : shares)
                      sum += share.value * this->table().node_position[share.node][d];
                    largest = std::max(largest, std::abs(sum));
                  }
                  return largest;
                }),
            1e-12);
}

TYPED_TEST(Gimp, PositionsHaveTheIdentityAsGradient)
{
  EXPECT_LT(this->worst(
                [&](const auto&, const auto& shares)
                {
                  double largest = 0.;
                  for (unsigned int i = 0; i < TypeParam::value; ++i)
                    for (unsigned int j = 0; j < TypeParam::value; ++j)
                    {
                      double sum = i == j ? -1. : 0.;
                      for (const auto& share : shares)
                        sum += this->table().node_position[share.node][i] * share.gradient[j];
                      largest = std::max(largest, std::abs(sum));
                    }
                  return largest;
                }),
            1e-12);
}

TYPED_TEST(Gimp, HangingNodesNeverAppear)
{
  // A hanging node lies in the closure of a leaf, of any rank, without being one of its corners.
  constexpr int dim = TypeParam::value;
  const test::RefinedMesh<dim> serial(MPI_COMM_SELF);
  std::vector<unsigned char> hangs(this->table().node_position.size(), 0);
  for (std::size_t node = 0; node < hangs.size(); ++node)
    for (const auto& leaf : serial.mesh.leaves().leaves)
    {
      bool touches = true, corner = true;
      for (unsigned int d = 0; d < dim; ++d)
      {
        const double offset = (this->table().node_position[node][d] - leaf.lower[d]) / leaf.size;
        touches = touches && offset > -1e-9 && offset < 1. + 1e-9;
        corner = corner && (std::abs(offset) < 1e-9 || std::abs(offset - 1.) < 1e-9);
      }
      hangs[node] |= touches && !corner;
    }
  EXPECT_EQ(this->worst(
                [&](const auto&, const auto& shares) {
                  return std::any_of(shares.begin(), shares.end(), [&](const auto& share) { return hangs[share.node]; })
                             ? 1.
                             : 0.;
                }),
            0.);
}

TYPED_TEST(Gimp, ChangesContinuouslyAsABoxSlidesAcrossAFace)
{
  // Along each axis, both sides of the box and its centre move across the lower face of its leaf.
  constexpr int dim = TypeParam::value;
  constexpr double hair = 1e-8;
  test::RankRandom random(4);
  double largest = 0.;
  for (const auto& leaf : this->table().leaves)
    for (unsigned int axis = 0; leaf.owned && axis < dim; ++axis)
      for (const double side : {-1., 0., 1.})
      {
        if (leaf.lower[axis] == 0.)
          continue; // the box would leave the grid
        typename TestFixture::Box box;
        for (unsigned int d = 0; d < dim; ++d)
        {
          box.half_width[d] = 0.25 * leaf.size * random(0.5, 1.);
          box.centre[d] = leaf.lower[d] + leaf.size * random(0.3, 0.7);
        }
        box.centre[axis] = leaf.lower[axis] - side * box.half_width[axis] - 0.5 * hair * leaf.size;
        const auto before = this->average(box);
        box.centre[axis] += hair * leaf.size;
        largest = std::max(largest, this->difference(before, this->average(box), leaf.size));
      }
  EXPECT_LT(max_over_ranks(largest, MPI_COMM_WORLD), 20. * hair);
}

TYPED_TEST(Gimp, ABoxThatReachesBeyondTheGridShrinksToWithinIt)
{
  EXPECT_LT(
      this->worst(
          [&](const auto& box, const auto& shares)
          { return this->difference(shares, this->average(this->shrunk(box)), 1e-2 * this->mesh.layout().base_size); }),
      1e-12);
}

TYPED_TEST(Gimp, ABoxBesideTheGridHasNoOverlaps)
{
  constexpr int dim = TypeParam::value;
  std::array<double, dim> centre, half_width;
  centre.fill(0.1);
  half_width.fill(0.05);
  centre[dim - 1] = -0.05 - 1e-9;
  EXPECT_TRUE(find_box_parts<dim>(this->table(), {centre}, {half_width}).leaf.empty());
}

TYPED_TEST(Gimp, ABoxWithinItsLeafSeesTheShapeFunctionsAtItsCentre)
{
  constexpr int dim = TypeParam::value;
  EXPECT_LT(this->worst(
                [&](const auto& box, const auto&)
                {
                  const int leaf = this->table().find_leaf(box.centre);
                  auto small = box;
                  for (unsigned int d = 0; d < dim; ++d)
                  {
                    const auto& cell = this->table().leaves[leaf];
                    const double to_face =
                        std::min(box.centre[d] - cell.lower[d], cell.lower[d] + cell.size - box.centre[d]);
                    small.half_width[d] = std::min(box.half_width[d], 0.9 * to_face);
                  }
                  std::vector<NodeShare<dim>> shape;
                  add_leaf_shape<dim>(this->table(), leaf, box.centre, 1., shape);
                  return this->difference(this->average(small), shape, 1e-2);
                }),
            1e-12);
}

TEST(GimpOnRegularCells, ABoxEndingOnAFaceActivatesNoSlivers)
{
  // 0.1 has no exact binary form: the sides of the boxes miss the faces by round-off.
  for (const double size : {0.1, 0.3, 0.7})
  {
    BackgroundMesh<3> mesh(MPI_COMM_SELF, test::make_brick<3>({{7, 5, 3}}, size));
    for (unsigned int i = 0; i < 14; ++i)
      for (unsigned int j = 0; j < 10; ++j)
        for (unsigned int k = 0; k < 6; ++k)
        {
          const double spacing = size / 2.;
          const std::array<double, 3> centre{{spacing * (i + 0.5), spacing * (j + 0.5), spacing * (k + 0.5)}},
              half_width{{0.5 * spacing, 0.5 * spacing, 0.5 * spacing}};
          EXPECT_EQ(find_box_parts<3>(mesh.leaves(), {centre}, {half_width}).leaf.size(), 1u);
          EXPECT_EQ(test::average_over_box<3>(mesh.leaves(), centre, half_width).size(), 8u);
        }
  }
}

TEST(GimpOnRegularCells, ABoxAcrossAllFacesSees27Nodes)
{
  BackgroundMesh<3> mesh(MPI_COMM_SELF, test::make_brick<3>({{3, 3, 3}}, 0.1));
  const std::array<double, 3> centre{{0.11, 0.12, 0.13}}, half_width{{0.035, 0.035, 0.035}};
  EXPECT_EQ(find_box_parts<3>(mesh.leaves(), {centre}, {half_width}).leaf.size(), 8u);
  EXPECT_EQ(test::average_over_box<3>(mesh.leaves(), centre, half_width).size(), 27u);
}
