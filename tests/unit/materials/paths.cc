#include <gtest/gtest.h>

#include "cases.h"

using namespace kedge;

namespace
{
class Paths : public testing::TestWithParam<Case>
{
protected:
  StressUpdate update(const Eigen::Matrix3d& increment, const SymmetricTensor& strain, State& state) const
  {
    return update_stress(increment, left_cauchy_green(strain), {young, cell_size, state.value}, material, state.value);
  }

  const Material material = make_material(GetParam().parameters);
};
INSTANTIATE_TEST_SUITE_P(Laws, Paths, testing::ValuesIn(all_cases()), case_name);
} // namespace

TEST_P(Paths, ManyRandomStepsStayFiniteAndWithinTheSurface)
{
  RandomStrain random(1);
  SymmetricTensor strain = SymmetricTensor::Zero();
  State state = initial_state(GetParam());
  SpatialTangent moduli;
  for (int n = 0; n < 100000; ++n)
  {
    const Eigen::Matrix3d increment =
        Eigen::Matrix3d::Identity() + random.matrix(random.magnitude(-8., -0.7)) +
        random.uniform(-1., 1.) * random.magnitude(-6., -2.) * Eigen::Matrix3d::Identity();
    const State before = state;
    const StressUpdate update = update_stress(increment, left_cauchy_green(strain), {young, cell_size, before.value},
                                              material, state.value, moduli);
    ASSERT_NE(update.status, Status::inverted);
    ASSERT_TRUE(update.stress.allFinite() && update.elastic_strain.allFinite());
    for (const double entry : moduli.value)
      ASSERT_TRUE(std::isfinite(entry));
    ASSERT_GE(update.plastic_increment, 0.);
    const Eigen::Vector3d stress = principal_frame(update.stress).values;
    ASSERT_LE(yield_function(GetParam(), stress, state), 1e-8 * stress.norm() + 1e-13 * young) << "step " << n;
    // An elastic point would strain without bound.
    strain = update.elastic_strain.norm() < 0.5 ? update.elastic_strain : SymmetricTensor::Zero().eval();
  }
}

TEST_P(Paths, ResponseIsContinuous)
{
  // Along a random line the stress may change no faster than a bound times the strain, however short the piece: halving
  // homes in on the piece with the larger jump.
  RandomStrain random(2), states(99);
  double worst = 0.;
  for (int n = 0; n < 10000; ++n)
  {
    const double size = random.magnitude(-6., -1.);
    Eigen::Vector3d a = random.principal(size), b = random.principal(size);
    const State state = random_state(GetParam(), states);
    Eigen::Vector3d stress_a = respond<false>(a, state, material).stress;
    Eigen::Vector3d stress_b = respond<false>(b, state, material).stress;
    for (int halving = 0; halving < 25; ++halving)
    {
      const Eigen::Vector3d middle = 0.5 * (a + b);
      const Eigen::Vector3d stress = respond<false>(middle, state, material).stress;
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
  RandomStrain random(3), states(99);
  for (int n = 0; n < 10000; ++n)
  {
    const double size = random.magnitude(-4., -1.);
    const SymmetricTensor strain = random.symmetric(size);
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(size);
    const Eigen::Matrix3d rotation = random.rotation();
    State plain_state = random_state(GetParam(), states), turned_state = plain_state;
    const Eigen::Matrix3d plain = full_matrix(update(increment, strain, plain_state).stress);
    const Eigen::Matrix3d turned = full_matrix(update(rotation * increment, strain, turned_state).stress);
    // Strains carry an absolute round-off of 1e-16, stresses one of 1e-16 times the modulus.
    ASSERT_LT((rotation * plain * rotation.transpose() - turned).norm(), 1e-12 * plain.norm() + 2e-14 * young);
  }
}

TEST_P(Paths, ResidualOnlyUpdateGivesTheSameState)
{
  RandomStrain random(4), states(99);
  for (int n = 0; n < 1000; ++n)
  {
    const SymmetricTensor strain = random.symmetric(1e-2);
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(1e-2);
    SpatialTangent moduli;
    State state = random_state(GetParam(), states), next = state;
    const StressUpdate with = update_stress(increment, left_cauchy_green(strain), {young, cell_size, state.value},
                                            material, next.value, moduli);
    const StressUpdate without = update(increment, strain, state);
    // round-off of the strain, times the largest modulus: E / (1 - 2 nu)
    ASSERT_LT((with.stress - without.stress).norm(), 2.5e-15 * young);
    ASSERT_LT((with.elastic_strain - without.elastic_strain).norm(), 1e-15);
    ASSERT_EQ(with.status, without.status);
    for (std::size_t i = 0; i < Laws::max_state; ++i)
      ASSERT_NEAR(next.value[i], state.value[i], 1e-15 * std::max(1., state.value[i]));
  }
}

TEST_P(Paths, ARestingPointStaysAsItIs)
{
  RandomStrain random(5);
  SymmetricTensor strain = SymmetricTensor::Zero();
  State state = initial_state(GetParam());
  for (int n = 0; n < 1000; ++n)
  {
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(1e-3);
    strain = update(increment, strain, state).elastic_strain;
    const StressUpdate rest = update(Eigen::Matrix3d::Identity(), strain, state);
    ASSERT_LT((rest.elastic_strain - strain).norm(), 3e-15);
    ASSERT_EQ(rest.status, Status::elastic) << "step " << n;
  }
}
