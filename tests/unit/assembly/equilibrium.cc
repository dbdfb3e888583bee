// The initial stress balances the weight of a layered block, at every node and to round-off.
#include "block.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
template <typename Dimension> class InitialStress : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  /// A half-filled upper row of cells, and an interface within a row of particles.
  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(3);
    cells[dim - 1] = 8;
    GridLayout<dim> grid = test::make_brick<dim>(cells, 0.5);
    grid.soil_extent[dim - 1] = 2.75;
    return grid;
  }

  static MaterialPointParameters two_layers()
  {
    MaterialPointParameters parameters;
    parameters.points_per_axis = 2;
    parameters.layers = {{0.6, test::soil_material<Elastic>()}, {2.15, test::soil_material<MohrCoulomb>()}};
    parameters.layers[0].material.density = 1500.;
    parameters.layers[0].material.young = 2e6;
    parameters.layers[1].material.overburden = Overburden{1e5, 0.5};
    parameters.K0 = 0.45;
    return parameters;
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(InitialStress, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(InitialStress, BalancesTheWeightOfLayers)
{
  constexpr int dim = TypeParam::value;
  const test::SoilFixture<dim> block(this->layout(), this->two_layers(), 9.81);
  const ParticleSet<dim>& particles = block.particles;
  const test::Discretisation<dim> parts(block.mesh, particles);
  const std::unique_ptr<System> system = parts.make_system();

  const NodalVector force = system->make_nodal_vector();
  std::array<double, 3> gravity{};
  gravity[dim - 1] = -9.81;
  update_stress_and_force<dim>(particles.arrays(), parts.stencils, block.soil.materials(), system->make_nodal_vector(),
                               force);
  add_weight<dim>(particles.arrays(), parts.stencils, gravity, -1., force);
  TpetraVector residual(system->graph().row_map);
  system->collect(force, residual);

  const auto r = residual.getLocalViewHost(Tpetra::Access::ReadOnly);
  double free = 0., held = 0.;
  for (unsigned int v = 0; v < parts.nodes.n_owned; ++v)
    for (unsigned int d = 0; d < dim; ++d)
    {
      const double x = parts.position[v][d];
      const bool on_support = x < 1e-9 || (d < dim - 1 && x > block.mesh.layout().extent(d) - 1e-9);
      (on_support ? held : free) = std::max(on_support ? held : free, std::abs(r(dim * v + d, 0)));
    }
  held = max_over_ranks(held, MPI_COMM_WORLD);
  EXPECT_GT(held, 0.);
  EXPECT_LT(max_over_ranks(free, MPI_COMM_WORLD), 1e-11 * held);
}
