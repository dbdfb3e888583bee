#include <gtest/gtest.h>

#include "cases.h"

using namespace kedge;

namespace
{
class Paths : public testing::TestWithParam<Case>
{
protected:
  const Material material = make_material(GetParam().parameters);
};
INSTANTIATE_TEST_SUITE_P(Laws, Paths, testing::ValuesIn(all_cases()), case_name);
} // namespace

TEST_P(Paths, ManyRandomStepsStayFiniteAndWithinTheSurface)
{
  RandomStrain random(1);
  SymmetricTensor strain = SymmetricTensor::Zero();
  SpatialTangent moduli;
  for (int n = 0; n < 100000; ++n)
  {
    const Eigen::Matrix3d increment =
        Eigen::Matrix3d::Identity() + random.matrix(random.magnitude(-8., -0.7)) +
        random.uniform(-1., 1.) * random.magnitude(-6., -2.) * Eigen::Matrix3d::Identity();
    const StressUpdate update = update_stress(increment, left_cauchy_green(strain), young, material, moduli);
    ASSERT_NE(update.status, Status::inverted);
    ASSERT_TRUE(update.stress.allFinite() && update.elastic_strain.allFinite());
    for (const double entry : moduli.value)
      ASSERT_TRUE(std::isfinite(entry));
    ASSERT_GE(update.plastic_increment, 0.);
    const Eigen::Vector3d stress = principal_frame(update.stress).values;
    ASSERT_LE(yield_function(GetParam(), stress), 1e-8 * stress.norm() + 1e-13 * young) << "step " << n;
    // An elastic point would strain without bound.
    strain = update.elastic_strain.norm() < 0.5 ? update.elastic_strain : SymmetricTensor::Zero().eval();
  }
}

TEST_P(Paths, ResponseIsContinuous)
{
  // Along a random line the stress may change no faster than a bound times the strain, however short the piece: halving
  // homes in on the piece with the larger jump.
  RandomStrain random(2);
  double worst = 0.;
  for (int n = 0; n < 10000; ++n)
  {
    const double size = random.magnitude(-6., -1.);
    Eigen::Vector3d a = random.principal(size), b = random.principal(size);
    Eigen::Vector3d stress_a = respond<false>(a, young, material).stress;
    Eigen::Vector3d stress_b = respond<false>(b, young, material).stress;
    for (int halving = 0; halving < 25; ++halving)
    {
      const Eigen::Vector3d middle = 0.5 * (a + b);
      const Eigen::Vector3d stress = respond<false>(middle, young, material).stress;
      const bool first = (stress - stress_a).norm() > (stress_b - stress).norm();
      (first ? b : a) = middle;
      (first ? stress_b : stress_a) = stress;
    }
    worst = std::max(worst, (stress_b - stress_a).norm() / (young * (b - a).norm()));
  }
  EXPECT_LT(worst, 6.); // the elastic bulk response is 3 K / E = 2.5 for nu = 0.3, steep cones return obliquely
}

TEST_P(Paths, SuperposedRotationTurnsTheStress)
{
  RandomStrain random(3);
  for (int n = 0; n < 10000; ++n)
  {
    const double size = random.magnitude(-4., -1.);
    const SymmetricTensor b = left_cauchy_green(random.symmetric(size));
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(size);
    const Eigen::Matrix3d rotation = random.rotation();
    const Eigen::Matrix3d plain = full_matrix(update_stress(increment, b, young, material).stress);
    const Eigen::Matrix3d turned = full_matrix(update_stress(rotation * increment, b, young, material).stress);
    // Strains carry an absolute round-off of 1e-16, stresses one of 1e-16 times the modulus.
    ASSERT_LT((rotation * plain * rotation.transpose() - turned).norm(), 1e-12 * plain.norm() + 2e-14 * young);
  }
}

TEST_P(Paths, ResidualOnlyUpdateGivesTheSameState)
{
  RandomStrain random(4);
  for (int n = 0; n < 1000; ++n)
  {
    const SymmetricTensor b = left_cauchy_green(random.symmetric(1e-2));
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(1e-2);
    SpatialTangent moduli;
    const StressUpdate with = update_stress(increment, b, young, material, moduli);
    const StressUpdate without = update_stress(increment, b, young, material);
    ASSERT_LT((with.stress - without.stress).norm(), 1e-15 * young);
    ASSERT_LT((with.elastic_strain - without.elastic_strain).norm(), 1e-15);
    ASSERT_EQ(with.status, without.status);
  }
}

TEST_P(Paths, ARestingPointStaysAsItIs)
{
  RandomStrain random(5);
  SymmetricTensor strain = SymmetricTensor::Zero();
  for (int n = 0; n < 1000; ++n)
  {
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(1e-3);
    strain = update_stress(increment, left_cauchy_green(strain), young, material).elastic_strain;
    const StressUpdate rest = update_stress(Eigen::Matrix3d::Identity(), left_cauchy_green(strain), young, material);
    ASSERT_LT((rest.elastic_strain - strain).norm(), 3e-15);
    ASSERT_EQ(rest.status, Status::elastic) << "step " << n;
  }
}
