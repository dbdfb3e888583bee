#include "block.h"
#include <gtest/gtest.h>
#include <kedge/assembly/deformation.h>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/highest_frequency.h>

using namespace kedge;

namespace
{
/// A block at rest with some dofs held, and its fastest vibration by many iterations with the assembled matrix.
template <typename Dimension> class HighestFrequency : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  HighestFrequency()
      : exchange(dim, block.parts->numbering()),
        node_exchange(1, block.parts->numbering()),
        inertia(exchange.make_nodal_vector())
  {
    const kedge::View<double*> mass("mass", block.parts->nodes.n_local());
    add_lumped_mass(block.particles.arrays(), block.parts->stencils, 0., mass);
    node_exchange.sum_over_ranks(mass);
    const auto on_nodes = copy_to_host(mass);
    const auto on_dofs = make_mirror(inertia);
    for (std::size_t v = 0; v < on_nodes.extent(0); ++v)
      for (int d = 0; d < dim; ++d)
        on_dofs(dim * v + d) =
            block.parts->position[v][d] == 0. ? std::numeric_limits<double>::infinity() : on_nodes(v);
    Kokkos::deep_copy(inertia, on_dofs);
  }

  ElasticSoil soil() const
  {
    std::vector<double> start;
    for (const auto& x : block.parts->position)
      for (int d = 0; d < dim; ++d)
        start.push_back(test::noise_at(x, dim, d) - 0.5);
    return {block.particles.arrays(),
            block.parts->stencils,
            block.materials,
            inertia,
            exchange,
            std::size_t(dim) * block.parts->nodes.n_owned,
            start,
            MPI_COMM_WORLD,
            {},
            {}};
  }

  double by_many_iterations() const
  {
    const auto system = block.parts->make_system();
    system->clear_matrix();
    deform<dim>(block.particles.arrays(), block.parts->stencils, exchange.make_nodal_vector());
    add_tangent<dim>(block.particles.arrays(), block.parts->stencils, block.materials, system->graph(),
                     system->values());
    system->finish_matrix();
    TpetraVector x = block.parts->owned(*system, block.random_field(1., 3)), y(x, Teuchos::Copy);
    const auto masses = copy_to_host(inertia);
    double value = 0.;
    for (int k = 0; k < 3000; ++k)
    {
      x.scale(1. / x.norm2());
      system->matrix()->apply(x, y);
      const auto rates = y.getLocalViewHost(Tpetra::Access::ReadWrite);
      for (std::size_t i = 0; i < rates.extent(0); ++i)
        rates(i, 0) /= masses(i);
      value = y.norm2();
      x.assign(y);
    }
    return value;
  }

  test::Block<dim> block{test::soil_material<Elastic>(), MPI_COMM_WORLD, false};
  NodalExchange exchange, node_exchange;
  NodalVector inertia;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(HighestFrequency, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(HighestFrequency, IsFoundFromAboveToAFewPercent)
{
  constexpr int dim = TypeParam::value;
  const double bound = max_over_ranks(
      bound_squared_frequency(this->block.particles.arrays(), this->block.parts->stencils, this->block.materials, 0.),
      MPI_COMM_WORLD);
  const double exact = this->by_many_iterations(), found = find_squared_frequency<dim>(this->soil(), bound);
  EXPECT_GT(found, exact);
  EXPECT_LT(found, 1.15 * exact);
  EXPECT_GT(bound, 1.3 * exact);
  EXPECT_EQ(find_squared_frequency<dim>(this->soil(), 0.9 * exact), 0.9 * exact);
}

/// The vectors of Lanczos' method are used up after as many products as there are frequencies.
TYPED_TEST(HighestFrequency, IsThatOfFewDofs)
{
  constexpr int dim = TypeParam::value;
  const auto masses = copy_to_host(this->inertia);
  const std::vector<long long>& global = this->block.parts->nodes.global;
  for (const unsigned int n_free : {1u, 2u, 3u, 4u, 7u})
    for (const double scale : {1e-8, 1e-4, 1., 1e4})
    {
      const auto few = make_mirror(this->inertia);
      for (std::size_t i = 0; i < few.extent(0); ++i)
        few(i) = dim * global[i / dim] + i % dim < 20 + n_free && dim * global[i / dim] + i % dim >= 20
                     ? scale * masses(i)
                     : std::numeric_limits<double>::infinity();
      Kokkos::deep_copy(this->inertia, few);
      const double exact = this->by_many_iterations(), found = find_squared_frequency<dim>(this->soil(), 1e300);
      if (exact == 0. && n_free < 7u) // all of them held
        continue;
      ASSERT_GT(exact, 0.);
      ASSERT_GT(found, exact) << n_free << " " << scale;
      ASSERT_LT(found, 1.2 * exact) << n_free << " " << scale;
    }
}

TYPED_TEST(HighestFrequency, GrowsUnderPressure)
{
  constexpr int dim = TypeParam::value;
  for (auto& particle : this->block.particles.edit())
  {
    double* data = particle.get_properties().data();
    const double strain[3] = {-0.2, -0.6, -0.2}, young = data[field::young];
    const double lame = young * 0.3 / (1.3 * 0.4), shear = young / 2.6;
    for (int i = 0; i < 3; ++i)
    {
      data[field::elastic_strain + i] = strain[i];
      data[field::stress + i] = -lame + 2. * shear * strain[i];
    }
  }
  const double exact = this->by_many_iterations(), found = find_squared_frequency<dim>(this->soil(), 1e300);
  EXPECT_GT(found, exact);
  EXPECT_LT(found, 1.5 * exact);
}

/// Each node hangs on a spring of its own, many times as stiff as the soil: the fastest is that of the least mass.
TYPED_TEST(HighestFrequency, OfSpringsIsThatOfTheStiffestForItsMass)
{
  constexpr int dim = TypeParam::value;
  const unsigned int n = this->block.parts->nodes.n_owned;
  ElasticSoil held = this->soil();
  const kedge::View<unsigned int*> begin("begin", n + 1), nodes("nodes", n);
  const kedge::View<double*> weights("weights", n), force("force", 3 * n), stiffness("stiffness", n);
  const double k = 1e12;
  double fastest = 0.;
  const auto masses = copy_to_host(this->inertia);
  for (unsigned int i = 0; i < n; ++i)
    for (int d = 0; d < dim; ++d)
      fastest = std::max(fastest, k / masses(dim * i + d));
  Kokkos::parallel_for(
      "hang nodes", n + 1, KOKKOS_LAMBDA(const unsigned int i) {
        begin(i) = i;
        if (i == n)
          return;
        nodes(i) = i;
        weights(i) = 1.;
        stiffness(i) = k;
      });
  held.points.begin = begin;
  held.points.nodes = nodes;
  held.points.weights = weights;
  held.points.force = force;
  held.stiffness = stiffness;
  fastest = max_over_ranks(fastest, MPI_COMM_WORLD);
  const double found = find_squared_frequency<dim>(held, 1e30);
  EXPECT_GT(found, 0.999 * fastest);
  EXPECT_LT(found, 1.2 * fastest);
}
