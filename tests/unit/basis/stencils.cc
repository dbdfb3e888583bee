#include "../mesh/refined_mesh.h"
#include "box_average.h"
#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/basis/cell_groups.h>
#include <kedge/basis/gimp.h>
#include <map>
#include <set>

using namespace kedge;

namespace
{
/// Particles at random places, leaf by leaf, and their stencils.
template <typename Dimension> class Stencils : public testing::Test, public test::RefinedMesh<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;

  Stencils()
  {
    test::RankRandom random(5);
    const LeafTable<dim>& table = this->mesh.leaves();
    for (std::size_t l = 0; l < table.leaves.size(); ++l)
      for (unsigned int n = 0; table.leaves[l].owned && n < 8; ++n)
      {
        std::array<double, dim> x, half;
        for (unsigned int d = 0; d < dim; ++d)
        {
          x[d] = table.leaves[l].lower[d] + table.leaves[l].size * random(0.05, 0.95);
          half[d] = 0.25 * table.leaves[l].size;
        }
        centre.push_back(x);
        half_width.push_back(half);
        leaf.push_back(l);
      }
  }

  HostStencils build(const bool point_basis = false) const
  {
    const LeafTable<dim>& table = this->mesh.leaves();
    return build_stencils<dim>(
        table, find_box_parts<dim>(table, centre, point_basis ? point_boxes<dim>(half_width) : half_width, leaf));
  }

  /// Numbers in reverse order, so that the order of nodes within a pattern must change.
  std::vector<unsigned int> renumbering() const
  {
    std::vector<unsigned int> number(this->mesh.leaves().node_ids.size());
    for (std::size_t i = 0; i < number.size(); ++i)
      number[i] = number.size() - 1 - i;
    return number;
  }

  using Shares = std::map<unsigned int, std::array<double, dim + 1>>;

  /// What particle p of the uploaded stencils sees: gradient and value by the leaf table's node number.
  Shares shares_of(const StencilSet& set, const unsigned int p) const
  {
    const unsigned int pattern = copy_to_host(set.pattern_of_particle)(p);
    const auto begin = copy_to_host(set.pattern_node_begin);
    const auto nodes = copy_to_host(set.pattern_nodes);
    const auto value = copy_to_host(set.value), gradient = copy_to_host(set.gradient);
    std::size_t entry = copy_to_host(set.value_begin)(p);
    Shares shares;
    for (unsigned int i = begin(pattern); i < begin(pattern + 1); ++i, ++entry)
    {
      auto& share = shares[this->mesh.leaves().node_ids.size() - 1 - nodes(i)];
      share[dim] = value(entry);
      for (unsigned int d = 0; d < dim; ++d)
        share[d] = gradient(dim * entry + d);
    }
    return shares;
  }

  static Shares to_map(const std::vector<NodeShare<dim>>& list)
  {
    Shares shares;
    for (const NodeShare<dim>& share : list)
    {
      std::copy(share.gradient.begin(), share.gradient.end(), shares[share.node].begin());
      shares[share.node][dim] = share.value;
    }
    return shares;
  }

  std::vector<std::array<double, dim>> centre, half_width;
  std::vector<unsigned int> leaf;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Stencils, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Stencils, GiveEachParticleItsOwnValues)
{
  const StencilSet set = upload_stencils<TypeParam::value>(this->build(), this->renumbering());
  for (std::size_t p = 0; p < this->centre.size(); ++p)
  {
    constexpr int dim = TypeParam::value;
    const auto alone = test::average_over_box<dim>(this->mesh.leaves(), this->centre[p], this->half_width[p]);
    ASSERT_EQ(this->shares_of(set, p), this->to_map(alone)) << "particle " << p;
  }
}

TYPED_TEST(Stencils, OfThePointBasisAreTheShapeFunctionsAtTheCentre)
{
  constexpr int dim = TypeParam::value;
  const StencilSet set = upload_stencils<dim>(this->build(true), this->renumbering());
  for (std::size_t p = 0; p < this->centre.size(); ++p)
  {
    std::vector<NodeShare<dim>> shape;
    add_leaf_shape<dim>(this->mesh.leaves(), this->leaf[p], this->centre[p], 1., shape);
    const auto expected = this->to_map(shape), found = this->shares_of(set, p);
    ASSERT_EQ(found.size(), expected.size());
    for (const auto& [node, share] : expected)
      for (unsigned int i = 0; i <= dim; ++i)
        ASSERT_NEAR(found.at(node)[i], share[i], 1e-12 / this->half_width[p][0]);
  }
}

TYPED_TEST(Stencils, SortTheNodesOfEveryPattern)
{
  const StencilSet set = upload_stencils<TypeParam::value>(this->build(), this->renumbering());
  const auto begin = copy_to_host(set.pattern_node_begin);
  const auto nodes = copy_to_host(set.pattern_nodes);
  for (std::size_t k = 0; k < set.n_patterns; ++k)
  {
    ASSERT_TRUE(std::is_sorted(nodes.data() + begin(k), nodes.data() + begin(k + 1)));
    ASSERT_LE(begin(k + 1) - begin(k), set.max_nodes);
  }
}

TYPED_TEST(Stencils, GroupTheParticlesOfACellWithAllTheNodesThatTheySee)
{
  const StencilSet set = upload_stencils<TypeParam::value>(this->build(), this->renumbering());
  const unsigned int n_leaves = *std::max_element(this->leaf.begin(), this->leaf.end()) + 1;
  const CellGroups cells = group_by_cell(set, this->leaf, std::vector<unsigned char>(n_leaves, 1));
  const auto particle_begin = copy_to_host(cells.particle_begin), node_begin = copy_to_host(cells.node_begin);
  const auto nodes = copy_to_host(cells.nodes), pattern_of = copy_to_host(set.pattern_of_particle);
  const auto pattern_begin = copy_to_host(set.pattern_node_begin), pattern_nodes = copy_to_host(set.pattern_nodes);
  EXPECT_EQ(cells.n_cells(), std::set<unsigned int>(this->leaf.begin(), this->leaf.end()).size());
  EXPECT_EQ(particle_begin(cells.n_cells()), this->leaf.size());
  for (std::size_t c = 0; c < cells.n_cells(); ++c)
  {
    std::set<unsigned int> seen;
    for (unsigned int p = particle_begin(c); p < particle_begin(c + 1); ++p)
    {
      ASSERT_EQ(this->leaf[p], this->leaf[particle_begin(c)]);
      seen.insert(pattern_nodes.data() + pattern_begin(pattern_of(p)),
                  pattern_nodes.data() + pattern_begin(pattern_of(p) + 1));
    }
    const std::vector<unsigned int> expected(seen.begin(), seen.end());
    ASSERT_EQ(std::vector<unsigned int>(nodes.data() + node_begin(c), nodes.data() + node_begin(c + 1)), expected);
  }
}

TYPED_TEST(Stencils, FormOneGroupPerParticleInACellThatIsNotFull)
{
  const StencilSet set = upload_stencils<TypeParam::value>(this->build(), this->renumbering());
  std::vector<unsigned char> is_full(*std::max_element(this->leaf.begin(), this->leaf.end()) + 1, 1);
  const unsigned int open = this->leaf[this->leaf.size() / 2];
  is_full[open] = 0;
  const CellGroups cells = group_by_cell(set, this->leaf, is_full);
  const auto particle_begin = copy_to_host(cells.particle_begin);
  const auto n_open = std::count(this->leaf.begin(), this->leaf.end(), open);
  ASSERT_GT(n_open, 1);
  EXPECT_EQ(cells.n_cells(), std::set<unsigned int>(this->leaf.begin(), this->leaf.end()).size() + n_open - 1);
  for (std::size_t c = 0; c < cells.n_cells(); ++c)
    if (this->leaf[particle_begin(c)] == open)
    {
      EXPECT_EQ(particle_begin(c + 1), particle_begin(c) + 1);
    }
}

TYPED_TEST(Stencils, ListEachParticleOnceUnderItsPattern)
{
  const StencilSet set = upload_stencils<TypeParam::value>(this->build(), this->renumbering());
  const auto begin = copy_to_host(set.pattern_particle_begin), particles = copy_to_host(set.pattern_particles);
  const auto pattern_of = copy_to_host(set.pattern_of_particle);
  std::set<unsigned int> seen;
  for (std::size_t k = 0; k < set.n_patterns; ++k)
    for (unsigned int i = begin(k); i < begin(k + 1); ++i)
    {
      ASSERT_EQ(pattern_of(particles(i)), k);
      ASSERT_TRUE(seen.insert(particles(i)).second);
    }
  EXPECT_EQ(seen.size(), this->centre.size());
}

/// Patterns of 3 cells of 0.1 m along each axis, with boxes of half their size. Along each axis two of a cell have
/// their centres `off` (m) from its faces.
template <int dim> std::size_t count_patterns(const double off)
{
  std::array<unsigned int, dim> cells;
  cells.fill(3);
  const BackgroundMesh<dim> mesh(MPI_COMM_SELF, test::make_brick<dim>(cells, 0.1));
  std::vector<std::array<double, dim>> centre, half_width;
  std::vector<unsigned int> leaf;
  for (std::size_t l = 0; l < mesh.leaves().leaves.size(); ++l)
    for (unsigned int n = 0; n < (1u << dim); ++n)
    {
      std::array<double, dim> x = mesh.leaves().leaves[l].lower, half;
      half.fill(0.025);
      for (unsigned int d = 0; d < dim; ++d)
        x[d] += (n >> d) & 1u ? 0.1 - off : off;
      centre.push_back(x);
      half_width.push_back(half);
      leaf.push_back(l);
    }
  const HostStencils host =
      build_stencils<dim>(mesh.leaves(), find_box_parts<dim>(mesh.leaves(), centre, half_width, leaf));
  return host.pattern_node_begin.size() - 1;
}

TYPED_TEST(Stencils, ShareOnePatternPerCellOnTheInitialGrid)
{
  EXPECT_EQ(count_patterns<TypeParam::value>(0.025), std::pow(3, TypeParam::value));
}

TYPED_TEST(Stencils, ShareThePatternsOfNeighboursAcrossFaces)
{
  EXPECT_EQ(count_patterns<TypeParam::value>(0.01), std::pow(4, TypeParam::value));
}

TYPED_TEST(Stencils, RefuseAParticleOutsideTheGrid)
{
  constexpr int dim = TypeParam::value;
  const auto look = [this] {
    refuse_boxes_outside<dim>(find_box_parts<dim>(this->mesh.leaves(), this->centre, this->half_width), this->centre);
  };
  EXPECT_NO_THROW(look());
  this->centre.back().fill(-1.);
  EXPECT_THROW(look(), SolverError);
}

namespace
{
template <typename Dimension> class ActiveNumbers : public testing::Test, public test::RefinedMesh<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;

  ActiveNumbers()
  {
    // Each rank uses the nodes of some of its leaves only, so the owner of a node may not use it.
    const LeafTable<dim>& table = this->mesh.leaves();
    used.assign(table.node_ids.size(), 0);
    for (const auto& leaf : table.leaves)
      if (leaf.owned && is_used(leaf))
        for (unsigned int n = 0; n < leaf.n_nodes; ++n)
          used[table.nodes[leaf.node_begin + n]] = 1;
    nodes = number_active_nodes<dim>(table, used, MPI_COMM_WORLD);
  }

  template <typename Leaf> static bool is_used(const Leaf& leaf) { return test::noise_at(leaf.lower, dim, 9) < 0.2; }

  std::vector<unsigned char> used;
  ActiveNodes nodes;
};
TYPED_TEST_SUITE(ActiveNumbers, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(ActiveNumbers, CountEachUsedNodeOnce)
{
  const test::RefinedMesh<TypeParam::value> serial(MPI_COMM_SELF);
  std::set<unsigned int> expected;
  for (const auto& leaf : serial.mesh.leaves().leaves)
    if (this->is_used(leaf))
      for (unsigned int n = 0; n < leaf.n_nodes; ++n)
        expected.insert(serial.mesh.leaves().nodes[leaf.node_begin + n]);
  EXPECT_EQ(this->nodes.n_global, static_cast<long long>(expected.size()));
}

TYPED_TEST(ActiveNumbers, AreContiguousOverTheRanks)
{
  std::vector<long long> owned(this->nodes.global.begin(), this->nodes.global.begin() + this->nodes.n_owned);
  owned = gather_everywhere(owned, MPI_COMM_WORLD);
  ASSERT_EQ(static_cast<long long>(owned.size()), this->nodes.n_global);
  for (std::size_t i = 0; i < owned.size(); ++i)
    ASSERT_EQ(owned[i], static_cast<long long>(i));
}

TYPED_TEST(ActiveNumbers, BelongToTheSamePlaceOnAllRanks)
{
  constexpr int dim = TypeParam::value;
  struct Named
  {
    long long global;
    std::array<double, dim> x;
  };
  std::vector<Named> mine;
  for (unsigned int i = 0; i < this->nodes.n_local(); ++i)
    mine.push_back({this->nodes.global[i], this->mesh.leaves().node_position[this->nodes.mesh_node[i]]});
  std::map<long long, std::array<double, dim>> place;
  for (const Named& node : gather_everywhere(mine, MPI_COMM_WORLD))
  {
    const auto& first = place.emplace(node.global, node.x).first->second;
    for (unsigned int d = 0; d < dim; ++d)
      ASSERT_NEAR(first[d], node.x[d], 1e-14);
  }
}

TYPED_TEST(ActiveNumbers, ReachEveryUsedNodeOfTheTable)
{
  for (std::size_t i = 0; i < this->used.size(); ++i)
    if (this->used[i])
    {
      ASSERT_LT(this->nodes.number[i], this->nodes.n_local());
      ASSERT_EQ(this->nodes.mesh_node[this->nodes.number[i]], i);
    }
}

TYPED_TEST(ActiveNumbers, GroupGhostsByOwner)
{
  ASSERT_EQ(this->nodes.ghost_begin.size(), std::size_t(size_of(MPI_COMM_WORLD)) + 1);
  EXPECT_EQ(this->nodes.ghost_begin.front(), this->nodes.n_owned);
  EXPECT_EQ(this->nodes.ghost_begin.back(), this->nodes.n_local());
  std::vector<long long> first;
  for (const long long n : gather_everywhere(std::vector<long long>{this->nodes.n_owned}, MPI_COMM_WORLD))
    first.push_back(n + (first.empty() ? 0 : first.back())); // one past the numbers of each rank
  for (std::size_t r = 0; r < first.size(); ++r)
    for (unsigned int i = this->nodes.ghost_begin[r]; i < this->nodes.ghost_begin[r + 1]; ++i)
    {
      EXPECT_LT(this->nodes.global[i], first[r]);
      EXPECT_GE(this->nodes.global[i], r == 0 ? 0 : first[r - 1]);
    }
}
