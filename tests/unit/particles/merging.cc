#include "soil_block.h"
#include <gtest/gtest.h>
#include <kedge/particles/merging.h>
#include <kedge/particles/splitting.h>

using namespace kedge;

namespace
{
template <typename Dimension> class Merging : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  static bool nowhere(const dealii::Point<dim>&) { return false; }

  /// Splits every particle once, the thin ones at the interface of the layers where they are wide enough.
  void split() { split_particles(block.particles, block.mesh, 4); }

  MergeResult merge(const double energy_tolerance = 0.05)
  {
    return merge_particles<dim>(block.particles, block.mesh, 2, nowhere, energy_tolerance);
  }

  /// Removes the row of particles that the interface between the layers cuts.
  void remove_interface()
  {
    block.particles.remove_if([](const auto& particle)
                              { return std::abs(particle.get_location()[dim - 1] - 0.875) < 0.125; });
  }

  /// Moves every particle within a range (m) and gives it a state of its own.
  void scatter() { scatter(block); }
  static void scatter(test::SoilBlock<dim>& block, const double range = 0.05)
  {
    block.disturb();
    for (auto& particle : block.particles.edit())
    {
      dealii::Point<dim> x = particle.get_location();
      for (unsigned int d = 0; d < dim; ++d)
        x[d] += range * (test::noise(particle.get_id(), 50 + d) - 0.5);
      particle.set_location(x);
    }
    block.particles.edit().sort_particles_into_subdomains_and_cells();
  }

  double mass_of_layer(const unsigned int layer) const
  {
    double mass = 0.;
    for (const auto& record : block.records())
      mass += record.data[field::layer] == layer ? record.data[field::mass] : 0.;
    return mass;
  }

  test::SoilBlock<dim> block;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Merging, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Merging, UndoesASplit)
{
  this->block.disturb();
  const auto before = this->block.records();
  this->split();
  ASSERT_GT(this->block.particles.n_global(), 2 * static_cast<long long>(before.size()));
  const MergeResult result = this->merge();
  const auto after = this->block.records();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i)
  {
    ASSERT_EQ(after[i].id, before[i].id);
    for (unsigned int d = 0; d < TypeParam::value; ++d)
      ASSERT_NEAR(after[i].position[d], before[i].position[d], 1e-14);
    for (unsigned int entry = 0; entry < field::count; ++entry)
    {
      if (entry == field::contact_gap)
        continue; // not a number away from bodies
      ASSERT_NEAR(after[i].data[entry], before[i].data[entry], 1e-13 * std::max(1., std::abs(before[i].data[entry])))
          << "property " << entry;
    }
  }
  EXPECT_NEAR(result.elastic_energy_lost, 0., 1e-13 * result.elastic_energy_merged);
}

TYPED_TEST(Merging, KeepsMassMomentumVolumeAndStress)
{
  this->split();
  this->scatter();
  const Eigen::VectorXd before = this->block.totals();
  ASSERT_GT(this->merge().removed, 50);
  EXPECT_LT(test::largest_difference(before, this->block.totals()), 1e-14);
}

TYPED_TEST(Merging, CountsWhatItRemoves)
{
  this->split();
  this->scatter();
  const long long before = this->block.particles.n_global();
  const MergeResult result = this->merge();
  EXPECT_EQ(this->block.particles.n_global(), before - result.removed);
  EXPECT_EQ(static_cast<long long>(this->block.by_number().size()), before - result.removed);
}

TYPED_TEST(Merging, KeepsParticlesInTheirCells)
{
  this->split();
  this->scatter();
  this->merge();
  for (const auto& particle : this->block.particles.handler())
  {
    const auto x = this->block.mesh.mapping().transform_real_to_unit_cell(particle.get_surrounding_cell(),
                                                                          particle.get_location());
    ASSERT_LT(x.distance(particle.get_reference_location()), 1e-12);
  }
  const long long before = this->block.particles.n_global();
  this->block.particles.edit().sort_particles_into_subdomains_and_cells();
  EXPECT_EQ(this->block.particles.n_global(), before);
}

TYPED_TEST(Merging, IsAlikeOnAnyNumberOfRanks)
{
  test::SoilBlock<TypeParam::value> alone(MPI_COMM_SELF);
  for (auto* block : {&this->block, &alone})
  {
    split_particles(block->particles, block->mesh, 4);
    this->scatter(*block);
    merge_particles<TypeParam::value>(block->particles, block->mesh, 2, this->nowhere);
  }
  const auto expected = alone.records(), found = this->block.records();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
  {
    ASSERT_EQ(found[i].id, expected[i].id);
    ASSERT_EQ(found[i].position, expected[i].position);
  }
}

TYPED_TEST(Merging, MixesNoLayers)
{
  this->split();
  this->scatter();
  const double upper = this->mass_of_layer(0), lower = this->mass_of_layer(1);
  this->merge();
  EXPECT_NEAR(this->mass_of_layer(0), upper, 1e-13 * upper);
  EXPECT_NEAR(this->mass_of_layer(1), lower, 1e-13 * lower);
}

TYPED_TEST(Merging, KeepsHenckysLaw)
{
  this->split();
  this->scatter();
  this->merge();
  for (auto& record : this->block.records())
  {
    auto data = record.data;
    test::SoilBlock<TypeParam::value>::set_stress(data.data());
    for (unsigned int i = 0; i < 6; ++i)
      ASSERT_NEAR(record.data[field::stress + i], data[field::stress + i], 1e-9); // Pa, of some 10 kPa
  }
}

TYPED_TEST(Merging, LeavesParticlesAloneThatAreToBeKept)
{
  this->split();
  const auto kept = [](const auto& x) { return x[0] < 0.8; };
  const auto before = this->block.by_number();
  ASSERT_GT(merge_particles<TypeParam::value>(this->block.particles, this->block.mesh, 2, kept).removed, 0);
  const auto after = this->block.by_number();
  for (const auto& [id, record] : before)
    if (kept(record.position))
    {
      ASSERT_EQ(after.count(id), 1u);
      ASSERT_EQ(after.at(id).position, record.position);
    }
}

TYPED_TEST(Merging, LeavesParticlesNearABodyAlone)
{
  this->split();
  std::unordered_map<long long, double> gaps;
  for (const auto& record : this->block.records()) // particles are 0.125 m wide
    gaps[record.id] = record.position[0] < 1. ? 0.05 : std::numeric_limits<double>::infinity();
  this->block.particles.set_contact_gaps(gaps);
  const auto before = this->block.by_number();
  ASSERT_GT(this->merge().removed, 0);
  const auto after = this->block.by_number();
  for (const auto& [id, gap] : gaps)
    if (gap == 0.05)
    {
      ASSERT_EQ(after.count(id), 1u);
    }
}

TYPED_TEST(Merging, LeavesParticlesOfTheRightSizeAlone)
{
  this->remove_interface();
  this->scatter(this->block, 0.4);
  EXPECT_EQ(this->merge(1.).removed, 0);
}

TYPED_TEST(Merging, StartsWithTheSmallest)
{
  // particles of the right size among small ones
  this->remove_interface();
  const long long before = this->block.particles.n_global();
  this->split();
  const auto right = [](const auto& x) { return x[0] > 0.5; };
  merge_particles<TypeParam::value>(this->block.particles, this->block.mesh, 2, right);
  for (auto& particle : this->block.particles.edit())
    if (dealii::Point<TypeParam::value> x = particle.get_location(); !right(x))
    {
      x[0] += 0.5;
      particle.set_location(x);
    }
  this->block.particles.edit().sort_particles_into_subdomains_and_cells();
  ASSERT_GT(this->block.particles.n_global(), before);
  this->merge(1.);
  EXPECT_EQ(this->block.particles.n_global(), before);
}

TYPED_TEST(Merging, LeavesScatteredParticlesAlone)
{
  // of the children of a particle only those in opposite corners
  this->remove_interface();
  this->split();
  this->block.particles.remove_if(
      [](const auto& particle)
      {
        unsigned int upper = 0;
        for (unsigned int d = 0; d < TypeParam::value; ++d)
          upper += std::fmod(particle.get_location()[d], 0.25) > 0.125;
        return upper > 0 && upper < TypeParam::value;
      });
  EXPECT_EQ(this->merge(1.).removed, 0);
}

TYPED_TEST(Merging, LeavesNothingToSplit)
{
  this->split();
  this->scatter();
  this->merge(1.);
  EXPECT_TRUE(split_particles(this->block.particles, this->block.mesh, 2).empty());
}

TYPED_TEST(Merging, LeavesStressesAloneWhoseMeanWouldLoseEnergy)
{
  this->split();
  for (auto& particle : this->block.particles.edit())
  {
    double* data = particle.get_properties().data();
    for (unsigned int i = 0; i < 6; ++i)
      data[field::elastic_strain + i] = i == 3 ? (particle.get_location()[0] < 1. ? 1e-3 : 0.) : 0.;
    if (std::fmod(particle.get_location()[0], 0.25) < 0.125) // the left half of what was one particle
      data[field::elastic_strain + 3] *= 0.5;
    this->block.set_stress(data);
  }
  // (1 + 1/4) / 2 before, (3/4)^2 after: a tenth is lost
  const double lost = 0.1;
  const auto before = this->block.by_number();
  ASSERT_GT(this->merge(0.05).removed, 0);
  const auto after = this->block.by_number();
  for (const auto& [id, record] : before)
    if (record.position[0] < 1.)
    {
      ASSERT_EQ(after.count(id), 1u);
    }
  const MergeResult result = this->merge(0.11);
  EXPECT_NEAR(result.elastic_energy_lost, lost * result.elastic_energy_merged, 1e-12 * result.elastic_energy_merged);
  EXPECT_GT(result.removed, 0);
}
