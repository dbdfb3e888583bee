#include "soil_block.h"
#include <gtest/gtest.h>
#include <kedge/particles/cleaning.h>
#include <kedge/particles/splitting.h>

using namespace kedge;

namespace
{
template <typename Dimension> class Cleaning : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Block = test::SoilBlock<dim>;

  HopelessParticles clean(const bool has_inertia = false)
  {
    return remove_hopeless_particles(block.particles, block.mesh, has_inertia);
  }

  /// Changes the properties of every tenth particle; returns how many those are.
  template <typename Change> long long change_some(const Change& change)
  {
    long long changed = 0;
    for (auto& particle : block.particles.edit())
      if (particle.get_id() % 10 == 0)
      {
        change(particle.get_properties().data());
        ++changed;
      }
    return sum_over_ranks(changed, MPI_COMM_WORLD);
  }

  /// Leaves the particles at these places on the x axis, in the lowest row at the origin of the other axes.
  void keep_only(const std::vector<double>& places)
  {
    block.particles.remove_if(
        [&](const auto& particle)
        {
          const auto& x = particle.get_location();
          for (unsigned int d = 1; d < dim; ++d)
            if (x[d] > 0.2)
              return true;
          return std::none_of(places.begin(), places.end(),
                              [&](const double place) { return std::abs(x[0] - place) < 1e-6; });
        });
  }

  /// A few particles here and there, some with long domains, in cells of several sizes.
  static void thin_out(Block& block)
  {
    block.refine(false, 0);
    block.particles.remove_if([](const auto& particle) { return test::noise(particle.get_id(), 60) > 0.06; });
    for (auto& particle : block.particles.edit())
      if (particle.get_id() % 3 == 0)
        particle.get_properties()[field::half_width] = 0.2;
  }

  Block block;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Cleaning, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Cleaning, RemovesNothingFromSoundSoil)
{
  this->block.refine(false);
  split_particles(this->block.particles, this->block.mesh, 2);
  this->block.disturb();
  const HopelessParticles removed = this->clean();
  EXPECT_EQ(removed.distorted, 0);
  EXPECT_EQ(removed.isolated, 0);
}

TYPED_TEST(Cleaning, RemovesParticlesThatHaveBlownUp)
{
  const long long some = this->change_some([](double* data) { data[field::deformation_gradient] = 11.; });
  EXPECT_EQ(this->clean().distorted, some);
}

TYPED_TEST(Cleaning, RemovesParticlesThatHaveCollapsed)
{
  const long long some = this->change_some([](double* data) { data[field::deformation_gradient] = 0.09; });
  EXPECT_EQ(this->clean().distorted, some);
}

TYPED_TEST(Cleaning, RemovesWhatIsNotFinite)
{
  const long long before = this->block.particles.n_global();
  const long long some =
      this->change_some([](double* data) { data[field::stress + 3] = std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_EQ(this->clean().distorted, some);
  EXPECT_EQ(this->block.particles.n_global(), before - some);
}

TYPED_TEST(Cleaning, TellsTheMassThatItTakes)
{
  const auto mass = [&] { return sum_over_ranks(this->block.particles.mass(), MPI_COMM_WORLD); };
  const double all = mass();
  this->change_some([](double* data) { data[field::deformation_gradient] = 0.09; });
  const HopelessParticles distorted = this->clean();
  const double left = mass();
  EXPECT_GT(distorted.mass, 0.);
  EXPECT_NEAR(distorted.mass, all - left, 1e-12 * all);
  this->keep_only({0.375, 1.125});
  const double two = mass();
  EXPECT_DOUBLE_EQ(this->clean().mass, two);
}

TYPED_TEST(Cleaning, RemovesDomainsWithoutExtent)
{
  const long long some = this->change_some([](double* data) { data[field::half_width + 1] = 0.; });
  EXPECT_EQ(this->clean().distorted, some);
}

TYPED_TEST(Cleaning, KeepsParticlesThatAreOnlySheared)
{
  this->change_some([](double* data) { data[field::deformation_gradient + 1] = 100.; });
  EXPECT_EQ(this->clean().distorted, 0);
}

TYPED_TEST(Cleaning, RemovesIsolatedParticles)
{
  this->keep_only({0.375, 1.125});
  EXPECT_EQ(this->clean().isolated, 2);
}

TYPED_TEST(Cleaning, KeepsIsolatedParticlesThatFlyOn)
{
  this->keep_only({0.375, 1.125});
  EXPECT_EQ(this->clean(true).isolated, 0);
  EXPECT_EQ(this->block.particles.n_global(), 2);
}

TYPED_TEST(Cleaning, RemovesNeighboursAcrossACorner)
{
  const auto is_on_diagonal = [](const auto& x)
  {
    for (const double place : {0.125, 0.625})
      if (std::abs(x[0] - place) < 1e-6 && std::abs(x[TypeParam::value - 1] - place) < 1e-6 &&
          (TypeParam::value == 2 || x[1] < 0.2))
        return true;
    return false;
  };
  this->block.particles.remove_if([&](const auto& particle) { return !is_on_diagonal(particle.get_location()); });
  EXPECT_EQ(this->clean().isolated, 2);
}

TYPED_TEST(Cleaning, KeepsNeighboursAcrossAFace)
{
  this->keep_only({0.125, 0.875, 1.375});
  EXPECT_EQ(this->clean().isolated, 0);
}

TYPED_TEST(Cleaning, SeesDomainsThatReachIntoTheNextCell)
{
  this->keep_only({0.375, 1.125});
  for (auto& particle : this->block.particles.edit())
    if (particle.get_location()[0] > 1.)
      particle.get_properties()[field::half_width] = 0.2;
  EXPECT_EQ(this->clean().isolated, 1);
  for (const auto& record : this->block.records())
    EXPECT_EQ(record.position[0], 0.375);
}

TYPED_TEST(Cleaning, IsAlikeOnAnyNumberOfRanks)
{
  test::SoilBlock<TypeParam::value> alone(MPI_COMM_SELF);
  this->thin_out(alone);
  this->thin_out(this->block);
  const HopelessParticles expected = remove_hopeless_particles(alone.particles, alone.mesh, false),
                          found = this->clean();
  ASSERT_GT(expected.isolated, 0);
  EXPECT_EQ(found.isolated, expected.isolated);
  const auto left = this->block.records(), expected_left = alone.records();
  ASSERT_GT(expected_left.size(), 0u);
  ASSERT_EQ(left.size(), expected_left.size());
  for (std::size_t i = 0; i < left.size(); ++i)
    ASSERT_EQ(left[i].id, expected_left[i].id);
}
