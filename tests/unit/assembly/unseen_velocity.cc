// What projected fields leave of the particles' quantities.
#include <gtest/gtest.h>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/inertia.h>
#include <kedge/assembly/unseen_velocity.h>
#include <kedge/base/communication.h>

#include "block.h"

using namespace kedge;

namespace
{
template <typename Dimension> struct UnseenVelocity : testing::Test
{
  static constexpr int dim = Dimension::value;

  /// Holds component 0 at the nodes near one side.
  static bool is_held(const std::array<double, dim>& x, const unsigned int d) { return d == 0 && x[0] < 0.1; }

  NodalPlaces find_places() const
  {
    const ParticleArrays& particles = block.particles.arrays();
    NodalPlaces places{exchange.make_nodal_vector(), exchange.make_nodal_vector(),
                       kedge::View<double*>("mass", block.parts->nodes.n_local()), exchange.make_nodal_vector(),
                       kedge::View<double* [3]>("position", particles.n)};
    fill(places.particles, [](const auto& x, const unsigned int d) { return x[d]; });
    add_particle_momentum(particles, block.parts->stencils, places.particles, places.centre);
    exchange.sum_over_ranks(places.centre);
    add_lumped_mass(particles, block.parts->stencils, 0., places.mass);
    NodalExchange(1, block.parts->numbering()).sum_over_ranks(places.mass);
    const auto host_mass = copy_to_host(places.mass);
    const auto centre = copy_to_host(places.centre), node = make_mirror(places.node),
               inertia = make_mirror(places.inertia), mean = make_mirror(places.centre);
    for (std::size_t v = 0; v < host_mass.extent(0); ++v)
      for (int d = 0; d < dim; ++d)
      {
        const auto& x = block.parts->position[v];
        mean(dim * v + d) = centre(dim * v + d) / host_mass(v);
        node(dim * v + d) = x[d];
        inertia(dim * v + d) = is_held(x, d) ? INFINITY : host_mass(v);
      }
    Kokkos::deep_copy(places.centre, mean);
    Kokkos::deep_copy(places.node, node);
    Kokkos::deep_copy(places.inertia, inertia);
    return places;
  }

  template <typename Field> void fill(const kedge::View<double* [3]>& quantity, const Field& field) const
  {
    const auto host = make_mirror(quantity);
    for (std::size_t p = 0; p < host.extent(0); ++p)
      for (int d = 0; d < dim; ++d)
        host(p, d) = field(block.particles.positions()[p], d);
    Kokkos::deep_copy(quantity, host);
  }

  const test::Block<dim> block{test::soil_material<Elastic>()};
  const NodalExchange exchange{dim, block.parts->numbering()};
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(UnseenVelocity, Dimensions, test::DimensionName);
} // namespace

/// At the edges of the block, at held nodes and at hanging ones, too.
TYPED_TEST(UnseenVelocity, LinearFieldsAreSeen)
{
  constexpr int dim = TypeParam::value;
  const NodalPlaces places = this->find_places();
  const auto linear = [](const auto& x, const unsigned int d)
  {
    double value = 0.3 - d;
    for (int i = 0; i < dim; ++i)
      value += (1. + 0.7 * i - 1.3 * d) * x[i];
    return value;
  };
  const NodalVector nodal = this->exchange.make_nodal_vector(), nothing = this->exchange.make_nodal_vector();
  const auto values = make_mirror(nodal);
  const auto centre = copy_to_host(places.centre), node = copy_to_host(places.node);
  for (std::size_t v = 0; v < this->block.parts->position.size(); ++v)
    for (int d = 0; d < dim; ++d)
      values(dim * v + d) =
          linear((this->is_held(this->block.parts->position[v], d) ? node : centre).data() + dim * v, d);
  Kokkos::deep_copy(nodal, values);

  const kedge::View<double* [3]> quantity("quantity", this->block.particles.arrays().n);
  this->fill(quantity, linear);
  take_seen_part<dim>(this->block.parts->stencils, places, nodal, quantity);
  const auto left = copy_to_host(quantity);
  for (std::size_t p = 0; p < left.extent(0); ++p)
    for (int d = 0; d < dim; ++d)
      ASSERT_NEAR(left(p, d), 0., 1e-12);

  // nearly all particles have weights
  this->fill(quantity, [](const auto&, const unsigned int) { return 1.; });
  take_seen_part<dim>(this->block.parts->stencils, places, nothing, quantity);
  const auto kept = copy_to_host(quantity);
  double with = 0.;
  for (std::size_t p = 0; p < kept.extent(0); ++p)
    with += kept(p, 0);
  const MPI_Comm communicator = MPI_COMM_WORLD;
  EXPECT_GT(sum_over_ranks(with, communicator),
            0.9 * sum_over_ranks(static_cast<double>(kept.extent(0)), communicator));
}

TYPED_TEST(UnseenVelocity, TheTwoWaysAreTransposes)
{
  constexpr int dim = TypeParam::value;
  const NodalPlaces places = this->find_places();
  const auto& block = this->block;
  const ParticleArrays& particles = block.particles.arrays();
  const NodalVector nodal =
      block.parts->nodal([](const auto& x, const unsigned int d) { return std::sin(7. * x[0] - 3. * x[1] + d); });
  const NodalVector received = this->exchange.make_nodal_vector();
  const auto wild = [](const auto& x, const unsigned int d) { return std::cos(41. * x[0] + 29. * x[1] - d); };
  const kedge::View<double*[3]> seen("seen", particles.n), quantity("quantity", particles.n);
  take_seen_part<dim>(block.parts->stencils, places, nodal, seen); // leaves minus what is seen
  this->fill(quantity, wild);
  add_seen_part<dim>(particles, block.parts->stencils, places, quantity, received);
  const auto host_seen = copy_to_host(seen), host_quantity = copy_to_host(quantity);
  const auto mass = copy_to_host(particles.mass);
  const auto a = copy_to_host(nodal), b = copy_to_host(received);
  double at_particles = 0., at_nodes = 0.;
  for (std::size_t p = 0; p < particles.n; ++p)
    for (int d = 0; d < dim; ++d)
      at_particles -= mass(p) * host_seen(p, d) * host_quantity(p, d);
  for (std::size_t i = 0; i < a.extent(0); ++i)
    at_nodes += a(i) * b(i);
  EXPECT_GT(std::abs(at_particles), 1e-3);
  EXPECT_NEAR(at_particles, at_nodes, 1e-10 * std::abs(at_particles));
}
