#include "soil_block.h"
#include <gtest/gtest.h>
#include <kedge/particles/splitting.h>

using namespace kedge;

namespace
{
/// One layer, 2 m deep, in 4 (by 4) by 4 cells of 0.5 m with 2 particles per axis.
template <int dim> GridLayout<dim> brick()
{
  std::array<unsigned int, dim> cells;
  cells.fill(4);
  GridLayout<dim> grid = test::make_brick<dim>(cells, 0.5);
  grid.soil_extent[dim - 1] = 2.;
  return grid;
}

template <typename Dimension> class StressSlopes : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Block = test::SoilFixture<dim>;

  static Layer clay(const double yield_stress)
  {
    Layer layer = test::elastic_layer(2.);
    layer.material.law = law_index<VonMises>;
    layer.material.constants.values["yield stress"] = yield_stress;
    return layer;
  }

  /// Gives particles the stress of a place (m), and the strain that belongs to it.
  template <typename Stress> static void set_stress(Block& block, const Stress& stress_at)
  {
    for (auto& particle : block.particles.edit())
    {
      double* data = particle.get_properties().data();
      const SymmetricTensor stress = stress_at(particle.get_location());
      Eigen::Map<SymmetricTensor>(data + field::stress) = stress;
      Eigen::Map<SymmetricTensor>(data + field::elastic_strain) = strain_of(stress);
    }
  }

  /// Hooke's law for Poisson's ratio 1/4 and 10 MPa.
  static SymmetricTensor strain_of(const SymmetricTensor& stress)
  {
    SymmetricTensor strain = 1.25e-7 * stress;
    for (unsigned int i = 0; i < 3; ++i)
      strain[i] -= 0.25e-7 * (stress[0] + stress[1] + stress[2]);
    return strain;
  }

  /// Refines all cells and splits their particles. Returns the number of splits on all ranks.
  static long long refine(Block& block)
  {
    const LeafTable<dim> before = block.mesh.leaves();
    block.particles.carry_through([&] { block.mesh.triangulation().refine_global(1); });
    const FormerCells<dim> former{before, block.soil.materials()};
    const auto splits = split_particles<dim>(block.particles, block.mesh, 2, former);
    return sum_over_ranks(static_cast<long long>(splits.size()), MPI_COMM_WORLD);
  }

  static SymmetricTensor stress_of(const double* data)
  {
    return Eigen::Map<const SymmetricTensor>(data + field::stress);
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(StressSlopes, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(StressSlopes, ChildrenFollowALinearStress)
{
  constexpr int dim = TypeParam::value;
  const auto linear = [](const dealii::Point<dim>& x)
  {
    SymmetricTensor stress;
    for (unsigned int i = 0; i < 6; ++i)
      stress[i] = 1e3 * (i + 1.) - 2e3 * (i % 2 + 0.3) * x[0] + 3e3 * x[dim - 1] + (dim == 3 ? 700. * i * x[1] : 0.);
    return stress;
  };
  test::SoilFixture<dim> block(brick<dim>(), test::layers_of({test::elastic_layer(2.)}, 0.4), 10.);
  this->set_stress(block, linear);
  ASSERT_GT(this->refine(block), 0);
  for (const auto& particle : block.particles.handler())
  {
    const double* data = particle.get_properties().data();
    const SymmetricTensor expected = linear(particle.get_location());
    ASSERT_LT((this->stress_of(data) - expected).norm(), 1e-9);
    ASSERT_LT((Eigen::Map<const SymmetricTensor>(data + field::elastic_strain) - this->strain_of(expected)).norm(),
              1e-15);
  }
}

TYPED_TEST(StressSlopes, ChildrenHaveTheMeanOfTheirParent)
{
  constexpr int dim = TypeParam::value;
  const auto rough = [](const dealii::Point<dim>& x)
  {
    SymmetricTensor stress;
    for (unsigned int i = 0; i < 6; ++i)
      stress[i] = 1e3 * std::sin(7. * x[0] + i) * std::cos(11. * x[dim - 1]);
    return stress;
  };
  test::SoilFixture<dim> block(brick<dim>(), test::layers_of({this->clay(1500.)}, 0.4), 10.);
  this->set_stress(block, rough);
  SymmetricTensor before = SymmetricTensor::Zero(), after = before;
  const auto add_to = [&](SymmetricTensor& sum)
  {
    for (const auto& particle : block.particles.handler())
      sum += particle.get_properties()[field::initial_volume] * this->stress_of(particle.get_properties().data());
  };
  add_to(before);
  ASSERT_GT(this->refine(block), 0);
  add_to(after);
  EXPECT_LT((after - before).norm(), 1e-10);
}

/// Rows of particles whose shear stress grows by tenths of the strength along an axis and reaches it in the last one:
/// only there children would have more.
TYPED_TEST(StressSlopes, ChildrenDoNotLeaveTheYieldSurface)
{
  constexpr int dim = TypeParam::value;
  const double yield = 1000., strength = yield / std::sqrt(3.); // in shear
  const auto rising = [&](const dealii::Point<dim>& x)
  {
    SymmetricTensor stress = SymmetricTensor::Zero();
    stress[3] = strength * std::min(1., 0.3 + 0.4 * x[0]); // 1 at the last row
    return stress;
  };
  test::SoilFixture<dim> block(brick<dim>(), test::layers_of({this->clay(yield)}, 0.4), 10.);
  this->set_stress(block, rising);
  ASSERT_GT(this->refine(block), 0);
  double in_last_row = 0.; // the largest
  for (const auto& particle : block.particles.handler())
  {
    const double shear = this->stress_of(particle.get_properties().data())[3] / strength;
    const double x = particle.get_location()[0];
    ASSERT_LT(shear, 1. + 1e-6);
    if (x < 1.5)
      ASSERT_NEAR(shear, 0.3 + 0.4 * x, 1e-6);
    else if (x > 1.75)
      in_last_row = std::max(in_last_row, shear);
  }
  EXPECT_GT(max_over_ranks(in_last_row, MPI_COMM_WORLD), 0.99);
}
