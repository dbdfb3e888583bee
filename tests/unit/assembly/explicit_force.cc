// Forces along a path, the lumped mass and the bound on the frequencies.
#include "block.h"
#include <gtest/gtest.h>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/highest_frequency.h>
#include <numeric>

using namespace kedge;

namespace
{
template <typename Dimension> class ExplicitForce : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  /// Internal force after following the increments one after the other, on this rank's nodes.
  static std::vector<double> follow(const test::Block<dim>& block, const std::vector<double>& shares,
                                    const CellGroups& cells, const double strain = 0.02)
  {
    const auto system = block.parts->make_system();
    const TpetraVector whole = block.parts->owned(*system, test::Block<dim>::random_field(strain, 5));
    const ParticlePath path = begin_path(block.particles.arrays(), dim, block.parts->nodes.n_local());
    NodalVector force;
    for (const double share : shares)
    {
      TpetraVector part(whole, Teuchos::Copy);
      part.scale(share);
      force = system->make_nodal_vector();
      EXPECT_EQ(advance_stress_and_force<dim>(block.particles.arrays(), block.parts->stencils, block.materials,
                                              system->spread(part), path, force, cells),
                0u);
    }
    const auto host = copy_to_host(force);
    return {host.data(), host.data() + host.extent(0)};
  }

  static double difference(const std::vector<double>& a, const std::vector<double>& b)
  {
    double largest = 0., scale = 0.;
    for (std::size_t i = 0; i < a.size(); ++i)
    {
      largest = std::max(largest, std::abs(a[i] - b[i]));
      scale = std::max(scale, std::abs(b[i]));
    }
    return largest / scale;
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(ExplicitForce, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(ExplicitForce, OneIncrementIsThatOfTheImplicitStep)
{
  constexpr int dim = TypeParam::value;
  // With F-bar they share volume or pressure, which in elastic soil is one for small increments.
  const test::Block<dim> plastic(test::soil_material<MohrCoulomb>()), elastic(test::soil_material<Elastic>());
  const auto difference = [&](const test::Block<dim>& block, const CellGroups& cells, const double strain)
  {
    const auto system = block.parts->make_system();
    const NodalVector force = system->make_nodal_vector();
    const TpetraVector whole = block.parts->owned(*system, test::Block<dim>::random_field(strain, 5));
    update_stress_and_force<dim>(block.particles.arrays(), block.parts->stencils, block.materials,
                                 system->spread(whole), force, cells);
    const auto host = copy_to_host(force);
    const std::vector<double> expected(host.data(), host.data() + host.extent(0));
    return this->difference(this->follow(block, {1.}, cells, strain), expected);
  };
  EXPECT_LT(difference(plastic, {}, 0.02), 1e-11);
  EXPECT_LT(difference(elastic, elastic.parts->cells, 1e-4), 1e-5);
}

TYPED_TEST(ExplicitForce, OneIncrementLeavesTheStateOfTheImplicitStep)
{
  constexpr int dim = TypeParam::value;
  const test::Block<dim> block(test::softening_soil());
  const ParticleArrays& arrays = block.particles.arrays();
  const auto system = block.parts->make_system();
  const TpetraVector whole = block.parts->owned(*system, test::Block<dim>::random_field(0.02, 5));
  update_stress_and_force<dim>(arrays, block.parts->stencils, block.materials, system->spread(whole),
                               system->make_nodal_vector());
  std::vector<double> expected(arrays.n);
  for (std::size_t p = 0; p < arrays.n; ++p)
    expected[p] = copy_to_host(arrays.trial_state)(p, 0);
  EXPECT_GT(*std::max_element(expected.begin(), expected.end()), 1e-4);
  this->follow(block, {1.}, {});
  const auto found = copy_to_host(arrays.trial_state);
  for (std::size_t p = 0; p < arrays.n; ++p)
    ASSERT_NEAR(found(p, 0), expected[p], 1e-12);
}

/// Lanes go across cells: one with an inverted particle must not disturb the others.
TYPED_TEST(ExplicitForce, CountsInvertedParticlesOfCellsThatShareTheirVolume)
{
  constexpr int dim = TypeParam::value;
  const test::Block<dim> block(test::soil_material<MohrCoulomb>());
  const ParticleArrays& arrays = block.particles.arrays();
  const auto system = block.parts->make_system();
  const auto pulled = [](const std::array<double, dim>& x, const unsigned int d)
  {
    double distance = 0.;
    for (const double y : x)
      distance += std::abs(y - 0.3);
    return d == 0 && distance < 1e-9 ? 3. : 0.;
  };
  const NodalVector increment = system->spread(block.parts->owned(*system, pulled));
  const auto follow = [&](const CellGroups& cells)
  {
    const NodalVector force = system->make_nodal_vector();
    const ParticlePath path = begin_path(arrays, dim, block.parts->nodes.n_local());
    const unsigned long inverted =
        advance_stress_and_force<dim>(arrays, block.parts->stencils, block.materials, increment, path, force, cells);
    for (const double f : download(force))
      EXPECT_TRUE(std::isfinite(f));
    return inverted;
  };
  const unsigned long expected = follow({});
  EXPECT_EQ(follow(block.parts->cells), expected);
  EXPECT_GT(sum_over_ranks(static_cast<long long>(expected), MPI_COMM_WORLD), 0);
  for (const double factor : download(block.parts->cells.volume_factor))
    EXPECT_TRUE(std::isfinite(factor) && factor > 0.);
}

/// To and fro: each increment goes on from the state that the last one left.
TYPED_TEST(ExplicitForce, TheStateFollowsThePath)
{
  const test::Block<TypeParam::value> block(test::softening_soil());
  const auto states = [&](const std::vector<double>& shares)
  {
    this->follow(block, shares, {});
    const auto state = copy_to_host(block.particles.arrays().trial_state);
    std::vector<double> first(block.particles.arrays().n);
    for (std::size_t p = 0; p < first.size(); ++p)
      first[p] = state(p, 0);
    return first;
  };
  const std::vector<double> there = states({1.}), back = states({1., -1.});
  for (std::size_t i = 0; i < there.size(); ++i)
    ASSERT_GE(back[i], there[i]);
  const auto sum = [](const std::vector<double>& values)
  { return sum_over_ranks(std::accumulate(values.begin(), values.end(), 0.), MPI_COMM_WORLD); };
  EXPECT_GT(sum(back), 1.05 * sum(there));
}

TYPED_TEST(ExplicitForce, ElasticSoilForgetsItsPath)
{
  const test::Block<TypeParam::value> block(test::soil_material<Elastic>());
  for (const CellGroups& cells : {CellGroups(), block.parts->cells})
    EXPECT_LT(this->difference(this->follow(block, {0.4, -1.5, 2., 1.}, cells), this->follow(block, {1.}, cells)),
              1e-10);
}

TYPED_TEST(ExplicitForce, PlasticSoilRemembersItsPath)
{
  const test::Block<TypeParam::value> block(test::soil_material<MohrCoulomb>());
  const std::vector<double> straight = this->follow(block, {1.}, {});
  EXPECT_GT(this->difference(this->follow(block, {0.4, -1.5, 2., 1.}, {}), straight), 1e-3);
  EXPECT_LT(this->difference(this->follow(block, {0.25, 0.5, 0.75, 1.}, {}), straight), 0.2);
}

/// Sum of the nodal masses: the mass of the particles, or more with a least share.
TYPED_TEST(ExplicitForce, LumpedMassIsThatOfTheSoil)
{
  const test::Block<TypeParam::value> block(test::soil_material<Elastic>());
  const auto sum = [](const kedge::View<double*>& view)
  {
    const auto host = copy_to_host(view);
    double total = 0.;
    for (std::size_t i = 0; i < host.extent(0); ++i)
      total += host(i);
    return total;
  };
  const kedge::View<double*> mass("mass", block.parts->nodes.n_local()), more("mass", block.parts->nodes.n_local());
  add_lumped_mass(block.particles.arrays(), block.parts->stencils, 0., mass);
  add_lumped_mass(block.particles.arrays(), block.parts->stencils, 0.02, more);
  EXPECT_NEAR(sum(mass), sum(block.particles.arrays().mass), 1e-12 * sum(mass));
  EXPECT_GT(sum(more), sum(mass) * (1. + 1e-6));
  EXPECT_LT(sum(more), sum(mass) * 1.6);
  EXPECT_LT(bound_squared_frequency(block.particles.arrays(), block.parts->stencils, block.materials, 0.02),
            bound_squared_frequency(block.particles.arrays(), block.parts->stencils, block.materials, 0.));
}
