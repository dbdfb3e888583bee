// F-bar: what it changes and what it must not change. tangent.cc tests its tangent.
#include "block.h"
#include <gtest/gtest.h>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/volume_average.h>

using namespace kedge;

namespace
{
template <typename Dimension> class FBar : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Position = std::array<double, dim>;

  FBar() : FBar(true) {}
  /// Stress that differs within cells, or none.
  explicit FBar(const bool stressed)
      : block(test::soil_material<MohrCoulomb>(), MPI_COMM_WORLD, stressed), system(block.parts->make_system(true))
  {
  }

  TpetraVector force(const typename test::Discretisation<dim>::Field& increment, const CellGroups& cells) const
  {
    return test::internal_force(block, *system, block.parts->owned(*system, increment), cells);
  }
  /// Change of the force by F-bar, over the force.
  double change(const typename test::Discretisation<dim>::Field& increment) const
  {
    TpetraVector with = force(increment, block.parts->cells);
    const TpetraVector without = force(increment, {});
    with.update(-1., without, 1.);
    return with.normInf() / without.normInf();
  }
  void update(const typename test::Discretisation<dim>::Field& increment)
  {
    const NodalVector force = system->make_nodal_vector();
    const NodalVector local = system->spread(block.parts->owned(*system, increment));
    update_stress_and_force<dim>(block.particles.arrays(), block.parts->stencils, block.materials, local, force,
                                 block.parts->cells);
  }

  test::Block<dim> block;
  std::unique_ptr<System> system;
};

template <typename Dimension> class FBarOfUniformStress : public FBar<Dimension>
{
public:
  FBarOfUniformStress() : FBar<Dimension>(false) {}
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(FBar, Dimensions, test::DimensionName);
TYPED_TEST_SUITE(FBarOfUniformStress, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(FBarOfUniformStress, IsThatOfNoFBarInALinearField)
{
  constexpr int dim = TypeParam::value;
  const auto dilation = [](const std::array<double, dim>& x, const unsigned int d) { return 0.05 * x[d]; };
  const auto shear = [](const std::array<double, dim>& x, const unsigned int d)
  { return -0.01 * x[d] + (d == 0 ? 0.05 * x[1] : 0.); };
  EXPECT_LT(this->change(dilation), 1e-12);
  EXPECT_LT(this->change(shear), 1e-12);
  EXPECT_GT(this->change(this->block.random_field(5e-3, 1)), 1e-3);
}

TYPED_TEST(FBar, TurnsItsForceWithARotation)
{
  constexpr int dim = TypeParam::value;
  const double c = std::cos(0.5), s = std::sin(0.5);
  const auto rotation = [&](const std::array<double, dim>& x, const unsigned int d) {
    return d == 0 ? (c - 1.) * x[0] - s * x[1] : d == 1 ? s * x[0] + (c - 1.) * x[1] : 0.;
  };
  const auto nothing = [](const auto&, unsigned int) { return 0.; };
  const auto host = [](TpetraVector& vector) { return vector.getLocalViewHost(Tpetra::Access::ReadOnly); };
  TpetraVector before = this->force(nothing, this->block.parts->cells),
               after = this->force(rotation, this->block.parts->cells);
  const auto first = host(before), last = host(after);
  const double scale = before.normInf();
  for (std::size_t i = 0; i < first.extent(0); i += dim)
  {
    EXPECT_NEAR(last(i, 0), c * first(i, 0) - s * first(i + 1, 0), 1e-12 * scale);
    EXPECT_NEAR(last(i + 1, 0), s * first(i, 0) + c * first(i + 1, 0), 1e-12 * scale);
  }
}

TYPED_TEST(FBar, BringsTheParticlesOfACellToOnePressureAndKeepsItsVolume)
{
  constexpr int dim = TypeParam::value;
  const ParticleArrays& arrays = this->block.particles.arrays();
  const CellGroups& cells = this->block.parts->cells;
  const auto mean_stresses = [&]
  {
    const auto stress = copy_to_host(arrays.trial_stress);
    std::vector<double> mean(stress.extent(0));
    for (std::size_t p = 0; p < mean.size(); ++p)
      for (int d = 0; d < dim; ++d)
        mean[p] += stress(p, d) / dim;
    return mean;
  };
  const auto determinants = [&](const typename test::Discretisation<dim>::Field& field, const CellGroups& groups)
  {
    const auto f = copy_to_host(
        interpolate_increments<dim>(arrays, this->block.parts->stencils, this->block.parts->nodal(field), groups)
            .deformation_gradient);
    std::vector<double> J;
    for (std::size_t p = 0; p < f.extent(0); ++p)
    {
      Eigen::Matrix3d dF;
      for (int i = 0; i < 9; ++i)
        dF(i / 3, i % 3) = f(p, i);
      EXPECT_EQ(f(p, 8) == 1., dim == 2);
      J.push_back(determinant(dF));
    }
    return J;
  };
  const auto committed = copy_to_host(arrays.elastic_left_cauchy_green);
  const auto young = copy_to_host(arrays.young);
  std::vector<double> start(committed.extent(0));
  for (std::size_t p = 0; p < start.size(); ++p)
  {
    SymmetricTensor b;
    for (int i = 0; i < 6; ++i)
      b[i] = committed(p, i);
    const SymmetricTensor strain = logarithmic_strain(b);
    const HenckyElasticity elasticity = copy_to_host(this->block.materials)(0).elasticity(young(p));
    start[p] = elasticity.lame * (strain[0] + strain[1] + strain[2]);
    for (int d = 0; d < dim; ++d)
      start[p] += 2. * elasticity.shear / dim * strain[d];
  }
  const auto field = this->block.random_field(0.02, 1);
  this->update(field);
  const auto end = mean_stresses();
  const auto own = determinants(field, {}), shared = determinants(field, cells);
  const auto volume = copy_to_host(arrays.initial_volume),
             factor = copy_to_host(this->block.parts->stencils.volume_factor);
  const auto begin = copy_to_host(cells.particle_begin);
  const auto springs = copy_to_host(cells.spring);
  double spread = 0., start_spread = 0.;
  for (std::size_t c = 0; c < cells.n_cells(); ++c)
  {
    double before = 0., after = 0., total = 0., mean = 0.;
    for (unsigned int p = begin(c); p < begin(c + 1); ++p)
    {
      const double V = volume(p) * factor(p);
      before += V * own[p];
      after += V * shared[p];
      total += V;
      mean += V * start[p];
    }
    ASSERT_NEAR(after, before, 1e-10 * before);
    for (unsigned int p = begin(c); p < begin(c + 1); ++p)
    {
      const double offset = start[p] - mean / total, first = start[begin(c)] - mean / total;
      const auto spring = [&](const unsigned int q) { return springs(q) * std::log(shared[q]); };
      ASSERT_NEAR(end[p] / shared[p] - offset + spring(p), end[begin(c)] / shared[begin(c)] - first + spring(begin(c)),
                  1e-7 * std::abs(end[p]));
      spread = std::max(spread, std::abs(own[p] - shared[p]));
      start_spread = std::max(start_spread, std::abs(offset));
    }
  }
  EXPECT_GT(max_over_ranks(spread, MPI_COMM_WORLD), 0.005);
  EXPECT_GT(max_over_ranks(start_spread, MPI_COMM_WORLD), 0.);
}

TYPED_TEST(FBar, SharesTheVolumeChangeInExplicitSteps)
{
  constexpr int dim = TypeParam::value;
  const ParticleArrays& arrays = this->block.particles.arrays();
  const CellGroups& cells = this->block.parts->cells;
  const NodalVector field = this->block.parts->nodal(this->block.random_field(0.1, 1));
  ASSERT_EQ(advance_stress_and_force<dim>(arrays, this->block.parts->stencils, this->block.materials, field,
                                          begin_path(arrays, dim, this->block.parts->nodes.n_local()),
                                          this->system->make_nodal_vector(), cells),
            0u);
  const auto f =
      copy_to_host(interpolate_increments<dim>(arrays, this->block.parts->stencils, field, cells).deformation_gradient);
  const auto determinant_of = [&](const std::size_t p)
  {
    Eigen::Matrix3d dF;
    for (int i = 0; i < 9; ++i)
      dF(i / 3, i % 3) = f(p, i);
    return determinant(dF);
  };
  const auto begin = copy_to_host(cells.particle_begin);
  for (std::size_t c = 0; c < cells.n_cells(); ++c)
    for (unsigned int p = begin(c); p < begin(c + 1); ++p)
      ASSERT_NEAR(determinant_of(p), determinant_of(begin(c)), 1e-13);
}

TYPED_TEST(FBar, SharesNothingWhereAParticleIsInverted)
{
  // One node is pulled far away: some particles are inverted, and with them nothing of their cells is shared.
  constexpr int dim = TypeParam::value;
  const auto pulled = [](const std::array<double, dim>& x, const unsigned int d)
  {
    double distance = 0.;
    for (const double y : x)
      distance += std::abs(y - 0.3);
    return d == 0 && distance < 1e-9 ? 3. : 0.;
  };
  const NodalVector force = this->system->make_nodal_vector();
  const NodalVector increment = this->system->spread(this->block.parts->owned(*this->system, pulled));
  const unsigned long inverted =
      update_stress_and_force<dim>(this->block.particles.arrays(), this->block.parts->stencils, this->block.materials,
                                   increment, force, this->block.parts->cells);
  long long unscaled = 0, scaled = 0;
  for (const double factor : download(this->block.parts->cells.volume_factor))
  {
    ASSERT_TRUE(std::isfinite(factor) && factor > 0.);
    (factor == 1. ? unscaled : scaled) += 1;
  }
  EXPECT_GT(sum_over_ranks(unscaled, MPI_COMM_WORLD), 0);
  EXPECT_GT(sum_over_ranks(scaled, MPI_COMM_WORLD), 0);
  const unsigned long expected = update_stress_and_force<dim>(
      this->block.particles.arrays(), this->block.parts->stencils, this->block.materials, increment, force);
  EXPECT_EQ(inverted, expected);
  EXPECT_GT(sum_over_ranks(static_cast<long long>(inverted), MPI_COMM_WORLD), 0);
}
