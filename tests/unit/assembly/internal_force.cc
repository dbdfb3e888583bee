#include "block.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
template <typename Dimension> class InternalForce : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  InternalForce() : block(test::soil_material<MohrCoulomb>()), system(block.parts->make_system()) {}

  TpetraVector force(const typename test::Discretisation<dim>::Field& increment) const
  {
    return test::internal_force(block, *system, block.parts->owned(*system, increment));
  }
  TpetraVector force_at_rest() const
  {
    return force([](const auto&, unsigned int) { return 0.; });
  }

  test::Block<dim> block;
  std::unique_ptr<System> system;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(InternalForce, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(InternalForce, DoesNotChangeInATranslation)
{
  TpetraVector difference = this->force([](const auto&, const unsigned int d) { return 0.1 + 0.2 * d; });
  const TpetraVector at_rest = this->force_at_rest();
  difference.update(-1., at_rest, 1.);
  EXPECT_LT(difference.normInf(), 1e-12 * at_rest.normInf());
}

TYPED_TEST(InternalForce, TurnsWithARotationOf30Degrees)
{
  // rotation about y in 3-D, within the plane in 2-D
  constexpr int dim = TypeParam::value;
  const double c = std::cos(M_PI / 6.), s = std::sin(M_PI / 6.);
  constexpr unsigned int first = 0, second = dim - 1;
  const TpetraVector turned = this->force(
      [&](const std::array<double, dim>& x, const unsigned int d)
      {
        const double a = x[first] - 0.5, b = x[second] - 0.2;
        return d == first ? c * a - s * b - a : d == second ? s * a + c * b - b : 0.;
      });
  const TpetraVector at_rest = this->force_at_rest();
  const auto f = at_rest.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto g = turned.getLocalViewHost(Tpetra::Access::ReadOnly);
  double largest = 0.;
  for (std::size_t v = 0; v < f.extent(0) / dim; ++v)
    for (unsigned int d = 0; d < dim; ++d)
    {
      const double a = f(dim * v + first, 0), b = f(dim * v + second, 0);
      const double expected = d == first ? c * a - s * b : d == second ? s * a + c * b : f(dim * v + d, 0);
      largest = std::max(largest, std::abs(g(dim * v + d, 0) - expected));
    }
  EXPECT_LT(max_over_ranks(largest, MPI_COMM_WORLD), 1e-11 * at_rest.normInf());
}

TYPED_TEST(InternalForce, SumsToZero)
{
  constexpr int dim = TypeParam::value;
  const TpetraVector total = this->force(this->block.random_field(5e-3, 1));
  const auto f = total.getLocalViewHost(Tpetra::Access::ReadOnly);
  for (unsigned int d = 0; d < dim; ++d)
  {
    double sum = 0.;
    for (std::size_t v = 0; v < f.extent(0) / dim; ++v)
      sum += f(dim * v + d, 0);
    const double scale = total.norm1();
    EXPECT_NEAR(sum_over_ranks(sum, MPI_COMM_WORLD), 0., 1e-13 * scale);
  }
}

TYPED_TEST(InternalForce, CountsInadmissibleIncrements)
{
  constexpr int dim = TypeParam::value;
  const TpetraVector mirror = this->block.parts->owned(
      *this->system, [](const std::array<double, dim>& x, const unsigned int d) { return d == 0 ? -2. * x[0] : 0.; });
  const NodalVector force = this->system->make_nodal_vector();
  EXPECT_EQ(update_stress_and_force<dim>(this->block.particles.arrays(), this->block.parts->stencils,
                                         this->block.materials, this->system->spread(mirror), force),
            this->block.particles.ids().size());
}

TYPED_TEST(InternalForce, IsThatOfOneRank)
{
  constexpr int dim = TypeParam::value;
  const auto increment = this->block.random_field(5e-3, 1);
  const TpetraVector spread = this->force(increment);

  const test::Block<dim> serial(test::soil_material<MohrCoulomb>(), MPI_COMM_SELF);
  const NodalVector force("force", dim * serial.parts->nodes.n_local());
  update_stress_and_force<dim>(serial.particles.arrays(), serial.parts->stencils, serial.materials,
                               serial.parts->nodal(increment), force);
  const auto expected = copy_to_host(force);
  std::map<std::array<long long, dim>, unsigned int> node_at;
  const auto place = [](const std::array<double, dim>& x)
  {
    std::array<long long, dim> key;
    for (unsigned int d = 0; d < dim; ++d)
      key[d] = std::llround(1e6 * x[d]);
    return key;
  };
  for (unsigned int v = 0; v < serial.parts->nodes.n_local(); ++v)
    node_at[place(serial.parts->position[v])] = v;

  EXPECT_EQ(this->block.parts->nodes.n_global, serial.parts->nodes.n_global);
  const auto found = spread.getLocalViewHost(Tpetra::Access::ReadOnly);
  double largest = 0.;
  for (unsigned int v = 0; v < this->block.parts->nodes.n_owned; ++v)
  {
    const unsigned int w = node_at.at(place(this->block.parts->position[v]));
    for (unsigned int d = 0; d < dim; ++d)
      largest = std::max(largest, std::abs(found(dim * v + d, 0) - expected(dim * w + d)));
  }
  EXPECT_LT(max_over_ranks(largest, MPI_COMM_WORLD), 1e-12 * spread.normInf());
}

TYPED_TEST(InternalForce, WeightSumsToTheMassTimesGravity)
{
  constexpr int dim = TypeParam::value;
  const NodalVector weight = this->system->make_nodal_vector();
  add_weight<dim>(this->block.particles.arrays(), this->block.parts->stencils, {{1., 2., 3.}}, 0.5, weight);
  const auto host = copy_to_host(weight);
  double volume = 1.;
  for (unsigned int d = 0; d < dim; ++d)
    volume *= this->block.layout().soil_extent[d];
  for (unsigned int d = 0; d < dim; ++d)
  {
    double sum = 0.;
    for (std::size_t v = 0; v < host.extent(0) / dim; ++v)
      sum += host(dim * v + d);
    EXPECT_NEAR(sum_over_ranks(sum, MPI_COMM_WORLD), 0.5 * (d + 1.) * 2000. * volume, 1e-9);
  }
}

TYPED_TEST(InternalForce, IncrementsOfALinearFieldAreExact)
{
  // gradient of the position dotted with constants: dF = 1 + g, displacement at the centre of the box
  constexpr int dim = TypeParam::value;
  const auto linear = [](const std::array<double, dim>& x, const unsigned int d)
  {
    double u = 0.01;
    for (unsigned int j = 0; j < dim; ++j)
      u += 0.1 * (d + 2. * j + 1.) * x[j];
    return u;
  };
  const ParticleIncrements increments = interpolate_increments<dim>(
      this->block.particles.arrays(), this->block.parts->stencils, this->block.parts->nodal(linear));
  const auto f = copy_to_host(increments.deformation_gradient);
  const auto u = copy_to_host(increments.displacement);
  for (std::size_t p = 0; p < this->block.particles.ids().size(); ++p)
  {
    bool inside = true;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        ASSERT_NEAR(f(p, 3 * i + j), (i == j) + (i < dim && j < dim ? 0.1 * (i + 2. * j + 1.) : 0.), 1e-12);
    for (unsigned int d = 0; d < dim; ++d)
    {
      const double x = this->block.particles.positions()[p][d], half = this->block.particles.half_widths()[p][d];
      inside = inside && x - half >= 0. && x + half <= this->block.layout().extent(d);
    }
    for (unsigned int d = 0; inside && d < dim; ++d)
      ASSERT_NEAR(u(p, d), linear(this->block.particles.positions()[p], d), 1e-12);
  }
}
