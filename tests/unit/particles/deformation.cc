// How domains and F follow large deformations.
#include "soil_block.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <kedge/particles/cleaning.h>

using namespace kedge;

namespace
{
template <typename Dimension> class Deformation : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  /// Commits the same increment of deformation for all particles, which stay where they are.
  void deform(const Eigen::Matrix3d& dF) { deform(block, dF, DomainUpdate::stretch); }

  static void deform(test::SoilBlock<dim>& block, const Eigen::Matrix3d& dF, const DomainUpdate update)
  {
    ParticleIncrements increments =
        test::increments_of(block.particles, [](long long, const unsigned int) { return 0.; });
    const auto f = make_mirror(increments.deformation_gradient);
    for (std::size_t p = 0; p < f.extent(0); ++p)
      for (unsigned int i = 0; i < 9; ++i)
        f(p, i) = dF(i / 3, i % 3);
    Kokkos::deep_copy(increments.deformation_gradient, f);
    block.particles.commit(increments, update);
  }

  /// A turn in the plane of the first and the last axis of the grid.
  static Eigen::Matrix3d turn(const double degrees)
  {
    const double angle = degrees * M_PI / 180.;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R(0, 0) = R(dim - 1, dim - 1) = std::cos(angle);
    R(dim - 1, 0) = std::sin(angle);
    R(0, dim - 1) = -std::sin(angle);
    return R;
  }

  /// Largest deviation of a half-width from `stretch` times the initial one along each axis, relative.
  double worst_half_width(const Eigen::Vector3d& stretch) const
  {
    double worst = 0.;
    for (const auto& record : block.records())
      for (unsigned int d = 0; d < dim; ++d)
        worst = std::max(worst, std::abs(record.data[field::half_width + d] /
                                             (stretch[d] * record.data[field::initial_half_width + d]) -
                                         1.));
    return worst;
  }

  double mass() const
  {
    double sum = 0.;
    for (const auto& record : block.records())
      sum += record.data[field::mass];
    return sum;
  }

  test::SoilBlock<dim> block;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Deformation, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Deformation, LeavesADomainThatOnlyTurnsAsItIs)
{
  const double before = this->mass();
  const long long n = this->block.particles.n_global();
  for (unsigned int step = 0; step < 19; ++step) // 95 degrees, and 190
  {
    this->deform(this->turn(5.));
    ASSERT_LT(this->worst_half_width(Eigen::Vector3d::Ones()), 1e-12);
  }
  this->deform(this->turn(95.));
  EXPECT_LT(this->worst_half_width(Eigen::Vector3d::Ones()), 1e-12);
  remove_hopeless_particles(this->block.particles, this->block.mesh, false);
  EXPECT_EQ(this->block.particles.n_global(), n);
  EXPECT_NEAR(this->mass(), before, 1e-12 * before);
}

TYPED_TEST(Deformation, StretchesDomainsAlongTheirAxesWithinBounds)
{
  Eigen::Vector3d stretch(1.3, 1., 1.);
  stretch[this->dim - 1] = 0.8;
  this->deform(stretch.asDiagonal());
  EXPECT_LT(this->worst_half_width(stretch), 1e-12);
  this->deform(this->turn(70.)); // U of R F is that of F
  EXPECT_LT(this->worst_half_width(stretch), 1e-12);
  Eigen::Vector3d more(2., 1., 1.);
  more[this->dim - 1] = 0.05;
  this->deform(this->turn(-70.));
  this->deform(more.asDiagonal());
  stretch[0] = 1.99;
  stretch[this->dim - 1] = 0.1;
  EXPECT_LT(this->worst_half_width(stretch), 1e-12);
}

TYPED_TEST(Deformation, KeepsSoilThatOpensWithoutStress)
{
  const double before = this->mass();
  Eigen::Matrix3d opening = Eigen::Matrix3d::Identity();
  opening.topLeftCorner(this->dim, this->dim) *= 1.5;
  for (unsigned int step = 0; step < 12; ++step) // 1.5^24 in the plane
  {
    Kokkos::deep_copy(this->block.particles.arrays().trial_strain, 0.);
    Kokkos::deep_copy(this->block.particles.arrays().trial_stress, 0.);
    this->deform(opening);
    EXPECT_EQ(remove_hopeless_particles(this->block.particles, this->block.mesh, false).distorted, 0);
  }
  EXPECT_NEAR(this->mass(), before, 1e-12 * before);
  for (const auto& record : this->block.records())
    ASSERT_NEAR(record.F().determinant(), 10., 1e-9);
}

/// What cells integrate over is what is there, however much it is pressed or, under stress, stretched.
TYPED_TEST(Deformation, DomainsThatFollowTheFlowKeepTheVolumeOfSoilUnderStress)
{
  for (const double stretch : {0.85, 1.1})
  {
    test::SoilBlock<TypeParam::value> block;
    Eigen::Matrix3d change = Eigen::Matrix3d::Identity();
    change(0, 0) = stretch;
    for (unsigned int step = 0; step < 7; ++step) // 0.32 and 1.95
    {
      const auto strain = make_mirror(block.particles.arrays().trial_strain);
      Kokkos::deep_copy(strain, 0.);
      for (std::size_t p = 0; p < strain.extent(0); ++p)
        strain(p, 0) = (step + 1) * std::log(stretch);
      Kokkos::deep_copy(block.particles.arrays().trial_strain, strain);
      this->deform(block, change, DomainUpdate::flow);
    }
    for (const auto& record : block.records())
    {
      double volume = 1.;
      for (int d = 0; d < this->dim; ++d)
        volume *= 2. * record.data[field::half_width + d];
      ASSERT_NEAR(volume, record.data[field::initial_volume] * std::pow(stretch, 7), 1e-12);
    }
  }
}

TYPED_TEST(Deformation, RemovesSoilThatIsElasticallyBeyondItsVolume)
{
  for (auto& particle : this->block.particles.edit())
    if (particle.get_id() % 2 == 0)
      particle.get_properties()[field::elastic_strain] = particle.get_id() % 4 == 0 ? 2.4 : -2.4; // ln 10 is 2.3
  const long long removed = remove_hopeless_particles(this->block.particles, this->block.mesh, false).distorted;
  EXPECT_NEAR(removed, 0.5 * (this->block.particles.n_global() + removed), 1.);
}
