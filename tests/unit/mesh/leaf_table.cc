#include "refined_mesh.h"
#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <set>

using namespace kedge;

namespace
{
/// A dimension, and how often trees are halved to give base cells.
template <int dim, unsigned int base_level> struct Forest : std::integral_constant<int, dim>
{
  static constexpr unsigned int level = base_level;
};

struct ForestName
{
  template <typename Forest> static std::string GetName(int)
  {
    return std::to_string(Forest::value) + "d" + std::to_string(1u << Forest::level);
  }
};

template <typename Forest> class LeafTables : public testing::Test, public test::RefinedMesh<Forest::value>
{
public:
  static constexpr int dim = Forest::value;

  LeafTables() : test::RefinedMesh<dim>(MPI_COMM_WORLD, Forest::level) {}

  using Point = std::array<double, dim>;

  const LeafTable<dim>& table() const { return this->mesh.leaves(); }

  Point random_point(test::RankRandom& random) const
  {
    Point x;
    for (unsigned int d = 0; d < dim; ++d)
      x[d] = random(0., this->mesh.layout().extent(d));
    return x;
  }

  /// The known leaf whose half-open box holds x, or -1.
  int find_by_trying_all(const Point& x) const
  {
    for (std::size_t i = 0; i < table().leaves.size(); ++i)
    {
      bool inside = true;
      for (unsigned int d = 0; d < dim; ++d)
        inside =
            inside && x[d] >= table().leaves[i].lower[d] && x[d] < table().leaves[i].lower[d] + table().leaves[i].size;
      if (inside)
        return static_cast<int>(i);
    }
    return -1;
  }
};

using Forests = testing::Types<Forest<2, 0>, Forest<3, 0>, Forest<2, 2>, Forest<3, 1>>;
TYPED_TEST_SUITE(LeafTables, Forests, ForestName);
} // namespace

TYPED_TEST(LeafTables, HoldSeveralLevelsAndHangingNodes)
{
  // otherwise the other tests would prove little
  std::vector<int> levels;
  long long hanging = 0;
  for (const auto& leaf : this->table().leaves)
  {
    levels.push_back(leaf.tree_level);
    hanging += !leaf.regular;
  }
  levels = gather_everywhere(levels, MPI_COMM_WORLD);
  const int base = TypeParam::level;
  EXPECT_EQ(this->mesh.layout().base_level(), TypeParam::level);
  EXPECT_EQ(std::set<int>(levels.begin(), levels.end()), (std::set<int>{base, base + 1, base + 2}));
  EXPECT_GT(sum_over_ranks(hanging, MPI_COMM_WORLD), 0);
}

TYPED_TEST(LeafTables, FindTheLeafOfAnyPoint)
{
  test::RankRandom random(1);
  for (unsigned int n = 0; n < 2000; ++n)
  {
    const auto x = this->random_point(random);
    ASSERT_EQ(this->table().find_leaf(x), this->find_by_trying_all(x));
  }
}

TYPED_TEST(LeafTables, CloseTheGridAndKnowNothingBeyond)
{
  constexpr int dim = TypeParam::value;
  std::array<double, dim> corner;
  for (unsigned int d = 0; d < dim; ++d)
    corner[d] = this->mesh.layout().extent(d);
  const int leaf = this->table().find_leaf(corner);
  if (leaf >= 0) // other ranks may not know it
  {
    EXPECT_NEAR(this->table().leaves[leaf].lower[0] + this->table().leaves[leaf].size, corner[0], 1e-14);
  }
  const double known = kedge::max_over_ranks(leaf >= 0 ? 1. : 0., MPI_COMM_WORLD);
  EXPECT_EQ(known, 1.);
  corner[dim - 1] += 1e-9;
  EXPECT_EQ(this->table().find_leaf(corner), -1);
  corner.fill(-1e-9);
  EXPECT_EQ(this->table().find_leaf(corner), -1);
}

TYPED_TEST(LeafTables, FindTheLeavesUnderAnyBox)
{
  constexpr int dim = TypeParam::value;
  test::RankRandom random(2);
  for (unsigned int n = 0; n < 500; ++n)
  {
    std::array<double, dim> lower = this->random_point(random), upper = this->random_point(random);
    for (unsigned int d = 0; d < dim; ++d)
      if (lower[d] > upper[d])
        std::swap(lower[d], upper[d]);
    std::vector<unsigned int> found, expected;
    this->table().find_leaves(lower, upper, found);
    for (std::size_t i = 0; i < this->table().leaves.size(); ++i)
    {
      const auto& leaf = this->table().leaves[i];
      bool meets = true;
      for (unsigned int d = 0; d < dim; ++d)
        meets = meets && leaf.lower[d] < upper[d] && leaf.lower[d] + leaf.size > lower[d];
      if (meets)
        expected.push_back(i);
    }
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found, expected);
  }
}

TYPED_TEST(LeafTables, FillTheBrickOnce)
{
  double volume = 0., total = 1.;
  for (const auto& leaf : this->table().leaves)
    if (leaf.owned)
      volume += std::pow(leaf.size, double(TypeParam::value));
  for (unsigned int d = 0; d < TypeParam::value; ++d)
    total *= this->mesh.layout().extent(d);
  EXPECT_NEAR(sum_over_ranks(volume, MPI_COMM_WORLD), total, 1e-12 * total);
}

TYPED_TEST(LeafTables, MatchTheCellsTheyCameFrom)
{
  for (const auto& cell : this->mesh.triangulation().active_cell_iterators())
    if (!cell->is_artificial())
    {
      const auto& leaf = this->table().leaves[this->mesh.leaf_number(cell)];
      ASSERT_EQ(leaf.tree_level, cell->level());
      ASSERT_EQ(leaf.tree_index, cell->index());
      ASSERT_EQ(leaf.owned, cell->is_locally_owned());
      ASSERT_EQ(leaf.owner, cell->subdomain_id());
      for (unsigned int d = 0; d < TypeParam::value; ++d)
        ASSERT_EQ(leaf.lower[d], cell->vertex(0)[d]);
    }
}

TYPED_TEST(LeafTables, TellTheOwnerOfAnyPlace)
{
  struct Owned
  {
    typename TestFixture::Point x;
    int owner;
  };
  test::RankRandom random(7);
  std::vector<Owned> mine;
  const auto note = [&](const typename TestFixture::Point& x)
  {
    if (const int leaf = this->table().find_leaf(x); leaf >= 0)
      mine.push_back({x, static_cast<int>(this->table().leaves[leaf].owner)});
  };
  for (unsigned int n = 0; n < 200; ++n)
    note(this->random_point(random));
  for (const auto& leaf : this->table().leaves) // corners, where up to 2^dim leaves meet
    note(leaf.lower);
  for (const Owned& place : gather_everywhere(mine, MPI_COMM_WORLD))
    ASSERT_EQ(this->table().find_owner(place.x), place.owner);

  auto outside = this->table().leaves.front().lower;
  outside[0] = -0.1;
  EXPECT_EQ(this->table().find_owner(outside), -1);
}

TYPED_TEST(LeafTables, NameEachTrueNodeOnceOverAllRanks)
{
  // A vertex is true unless it lies in the closure of a leaf without being one of its corners.
  constexpr int dim = TypeParam::value;
  const double finest = std::ldexp(0.3, -2 - static_cast<int>(TypeParam::level));
  struct Named
  {
    long long id;
    std::array<long long, dim> place;
    int owned;
  };
  std::vector<Named> mine;
  for (std::size_t i = 0; i < this->table().node_ids.size(); ++i)
  {
    Named node{this->table().node_ids[i], {}, int(this->table().node_owner_is_me[i])};
    for (unsigned int d = 0; d < dim; ++d)
      node.place[d] = std::llround(this->table().node_position[i][d] / finest);
    mine.push_back(node);
  }
  std::map<long long, std::array<long long, dim>> place_of;
  std::map<std::array<long long, dim>, long long> id_at;
  std::map<long long, int> owners;
  for (const Named& node : gather_everywhere(mine, MPI_COMM_WORLD))
  {
    ASSERT_EQ(place_of.emplace(node.id, node.place).first->second, node.place);
    ASSERT_EQ(id_at.emplace(node.place, node.id).first->second, node.id);
    owners[node.id] += node.owned;
    ASSERT_GE(node.id, 0);
    ASSERT_LT(node.id, this->table().n_global_nodes);
  }
  for (const auto& [id, count] : owners)
    ASSERT_EQ(count, 1) << "node " << id;

  const test::RefinedMesh<dim> serial(MPI_COMM_SELF, TypeParam::level);
  std::set<std::array<long long, dim>> corners, hanging;
  const auto to_place = [finest](const auto& x, const double size, const unsigned int v)
  {
    std::array<long long, dim> place;
    for (unsigned int d = 0; d < dim; ++d)
      place[d] = std::llround((x[d] + ((v >> d) & 1u ? size : 0.)) / finest);
    return place;
  };
  for (const auto& leaf : serial.mesh.leaves().leaves)
    for (unsigned int v = 0; v < (1u << dim); ++v)
      corners.insert(to_place(leaf.lower, leaf.size, v));
  for (const auto& corner : corners)
    for (const auto& leaf : serial.mesh.leaves().leaves)
    {
      const auto low = to_place(leaf.lower, leaf.size, 0), high = to_place(leaf.lower, leaf.size, (1u << dim) - 1);
      bool touches = true, is_corner = true;
      for (unsigned int d = 0; d < dim; ++d)
      {
        touches = touches && corner[d] >= low[d] && corner[d] <= high[d];
        is_corner = is_corner && (corner[d] == low[d] || corner[d] == high[d]);
      }
      if (touches && !is_corner)
        hanging.insert(corner);
    }
  EXPECT_EQ(id_at.size(), corners.size() - hanging.size());
  EXPECT_EQ(this->table().n_global_nodes, static_cast<long long>(corners.size()));
  for (const auto& place : hanging)
    EXPECT_EQ(id_at.count(place), 0u);
}

TYPED_TEST(LeafTables, KeepBoxesWithinTheNeighboursOfTheirLeaf)
{
  constexpr int dim = TypeParam::value;
  using Point = std::array<double, dim>;
  const LeafTable<dim>& table = this->table();
  test::RankRandom random(7);
  long long n_cut = 0;
  for (unsigned int n = 0; n < 3000; ++n)
  {
    const Point x = this->random_point(random);
    const int number = table.find_leaf(x);
    if (number < 0 || !table.leaves[number].owned)
      continue;
    const auto& leaf = table.leaves[number];
    Point half, lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
      half[d] = random(0.1, 1.5) * leaf.size;
    const Point result = table.within_neighbours(number, x, half);
    n_cut += result != half;
    double volume = 1., known = 0.;
    for (unsigned int d = 0; d < dim; ++d)
    {
      ASSERT_GE(result[d], std::min(half[d], 0.5 * leaf.size));
      ASSERT_LE(result[d], half[d]);
      lower[d] = std::max(table.lower_end(d), x[d] - result[d]);
      upper[d] = std::min(table.upper_end(d), x[d] + result[d]);
      volume *= upper[d] - lower[d];
    }
    std::vector<unsigned int> found;
    table.find_leaves(lower, upper, found);
    for (const unsigned int other : found)
    {
      const auto& neighbour = table.leaves[other];
      double overlap = 1.;
      bool touches = true;
      for (unsigned int d = 0; d < dim; ++d)
      {
        const double begin = neighbour.lower[d], end = neighbour.lower[d] + neighbour.size;
        overlap *= std::min(upper[d], end) - std::max(lower[d], begin);
        touches = touches && begin < leaf.lower[d] + leaf.size + 1e-12 && end > leaf.lower[d] - 1e-12;
      }
      ASSERT_TRUE(touches || overlap < 1e-12 * volume); // but for round-off
      known += overlap;
    }
    ASSERT_NEAR(known, volume, 1e-12 * volume);
  }
  EXPECT_GT(sum_over_ranks(n_cut, MPI_COMM_WORLD), 100);
}
