#include "soil_block.h"
#include <gtest/gtest.h>
#include <kedge/particles/splitting.h>

using namespace kedge;

namespace
{
template <typename Dimension> class Splitting : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  static constexpr unsigned int n_children = 1u << dim;
  using Block = test::SoilBlock<dim>;

  Splitting() { prepare(block); }

  /// Cells of three sizes, particles of one size in a state of their own.
  static void prepare(Block& block)
  {
    block.refine(false, 0);
    block.refine(false, 1);
    block.disturb();
  }

  std::vector<Split<dim>> split(const unsigned int points_per_axis = 2)
  {
    return gather_everywhere(split_particles(block.particles, block.mesh, points_per_axis), MPI_COMM_WORLD);
  }

  /// Leaves particles in opposite corners and in the middle, four times as wide, in cells of an eighth of a metre.
  void keep_few_wide_ones()
  {
    block.refine(true);
    block.particles.remove_if(
        [](const auto& particle)
        {
          for (const double corner : {0.125, 0.875, 1.125, 1.875})
          {
            bool here = std::abs(particle.get_location()[dim - 1] - std::min(corner, 1.125)) < 0.13;
            for (unsigned int d = 0; d < dim - 1; ++d)
              here = here && std::abs(particle.get_location()[d] - corner) < 1e-6;
            if (here)
              return false;
          }
          return true;
        });
    for (auto& particle : block.particles.edit())
      for (unsigned int d = 0; d < dim; ++d)
        particle.get_properties()[field::half_width + d] = 0.5;
  }

  Block block;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Splitting, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Splitting, EndsWhenEveryParticleFitsItsCell)
{
  ASSERT_GT(this->split().size(), 0u);
  const auto& particles = this->block.particles;
  for (std::size_t p = 0; p < particles.ids().size(); ++p)
  {
    double volume = 1.;
    for (const double half : particles.half_widths()[p])
      volume *= 2. * half;
    const double size = this->block.mesh.leaves().leaves[particles.leaves()[p]].size;
    ASSERT_LE(std::pow(volume, 1. / TypeParam::value), std::sqrt(2.) * size / 2.);
  }
}

TYPED_TEST(Splitting, LeavesParticlesThatFitAlone)
{
  test::SoilBlock<TypeParam::value> block;
  const long long before = block.particles.n_global();
  EXPECT_TRUE(split_particles(block.particles, block.mesh, 2).empty());
  EXPECT_EQ(block.particles.n_global(), before);
}

TYPED_TEST(Splitting, KeepsMassMomentumVolumeAndStress)
{
  const Eigen::VectorXd before = this->block.totals();
  this->split();
  EXPECT_LT(test::largest_difference(before, this->block.totals()), 1e-14);
}

TYPED_TEST(Splitting, LosesNoParticle)
{
  const long long before = this->block.particles.n_global();
  long long added = 0;
  for (const auto& split : this->split())
    added += split.n_children() - 1;
  EXPECT_GT(added, 0);
  EXPECT_EQ(this->block.particles.n_global(), before + added);
}

TYPED_TEST(Splitting, PlacesChildrenInTheOctantsOfTheirParent)
{
  constexpr int dim = TypeParam::value;
  const auto parents = this->block.by_number();
  const auto splits = this->split(3); // one generation in most places
  const auto children = this->block.by_number();
  unsigned int compared = 0;
  for (const auto& split : splits)
    for (unsigned int octant = 0; octant < this->n_children; ++octant)
    {
      if (parents.count(split.parent) == 0 || !split.has_child(octant))
        continue;
      const auto &parent = parents.at(split.parent), &child = children.at(split.children[octant]);
      if (child.data[field::mass] < 0.9 * parent.data[field::mass] / split.n_children())
        continue; // split again
      ++compared;
      Eigen::Vector3d offset = Eigen::Vector3d::Zero(), share = Eigen::Vector3d::Ones();
      for (unsigned int d = 0; d < dim; ++d)
      {
        if (split.is_cut_along(d))
          share[d] = 0.5;
        offset[d] =
            !split.is_cut_along(d) ? 0. : ((octant >> d) & 1u ? 0.5 : -0.5) * parent.data[field::half_width + d];
        ASSERT_NEAR(child.position[d], parent.position[d] + offset[d], 1e-14);
      }
      const Eigen::Vector3d initial = child.vector(field::initial_position) - parent.vector(field::initial_position);
      ASSERT_LT((parent.F() * initial - offset).norm(), 1e-14);
      ASSERT_EQ(child.vector(field::half_width), share.cwiseProduct(parent.vector(field::half_width)));
      ASSERT_EQ(child.vector(field::initial_half_width), share.cwiseProduct(parent.vector(field::initial_half_width)));
    }
  EXPECT_GT(compared, 30u);
}

TYPED_TEST(Splitting, CopiesTheStateOfTheParent)
{
  const auto parents = this->block.by_number();
  std::map<long long, long long> ancestor;
  for (const auto& split : this->split())
    for (const long long child : split.children)
      ancestor[child] = ancestor.count(split.parent) ? ancestor[split.parent] : split.parent;
  ASSERT_FALSE(ancestor.empty());
  for (const auto& child : this->block.records())
    if (ancestor.count(child.id))
    {
      const auto& data = parents.at(ancestor.at(child.id)).data;
      for_each_field(
          [&](const FieldDeclaration& field, const unsigned int at)
          {
            const bool is_copied = field.rule != FieldRule::share && field.rule != FieldRule::width &&
                                   field.rule != FieldRule::place && !std::isnan(field.initial);
            for (unsigned int i = at; is_copied && i < at + n_components(field.kind); ++i)
              ASSERT_EQ(child.data[i], data[i]) << field.name;
          });
    }
}

TYPED_TEST(Splitting, NumbersParticlesAlikeOnAnyNumberOfRanks)
{
  test::SoilBlock<TypeParam::value> alone(MPI_COMM_SELF);
  this->prepare(alone);
  split_particles(alone.particles, alone.mesh, 2);
  this->split();
  const auto expected = alone.records(), found = this->block.records();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
  {
    ASSERT_EQ(found[i].id, expected[i].id);
    ASSERT_EQ(found[i].position, expected[i].position);
    ASSERT_TRUE(i == 0 || found[i].id > found[i - 1].id) << "a number twice";
  }
}

TYPED_TEST(Splitting, BringsChildrenToCellsBeyondTheNeighbours)
{
  this->keep_few_wide_ones();
  const long long before = this->block.particles.n_global();
  const Eigen::VectorXd totals = this->block.totals();
  ASSERT_GT(before, 3);
  this->split(1);
  EXPECT_GE(this->block.particles.n_global(), before * this->n_children * this->n_children * this->n_children);
  const Eigen::VectorXd after = this->block.totals();
  EXPECT_NEAR(after[0], totals[0], 1e-14 * totals[0]);
  this->block.particles.edit().sort_particles_into_subdomains_and_cells();
  EXPECT_NEAR(this->block.totals()[0], totals[0], 1e-14 * totals[0]);
}

TYPED_TEST(Splitting, ReturnsSplitsWhereTheFirstParentWas)
{
  this->keep_few_wide_ones();
  std::map<long long, int> holder;
  for (const auto& particle : this->block.particles.handler())
    holder[particle.get_id()] = 1;
  for (const auto& split : split_particles(this->block.particles, this->block.mesh, 1))
  {
    ASSERT_EQ(holder.count(split.parent), 1u);
    for (const long long child : split.children)
      holder[child] = 1;
  }
}

TYPED_TEST(Splitting, KeepsChildrenInsideTheGrid)
{
  this->keep_few_wide_ones();
  this->split(1);
  bool some_at_the_edge = false;
  for (const auto& record : this->block.records())
    for (unsigned int d = 0; d < TypeParam::value; ++d)
    {
      ASSERT_GT(record.position[d], 0.);
      ASSERT_LT(record.position[d], 2.);
      some_at_the_edge = some_at_the_edge || record.position[d] < 1e-6;
    }
  EXPECT_TRUE(some_at_the_edge);
}
