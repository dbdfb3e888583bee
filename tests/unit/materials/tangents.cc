#include <gtest/gtest.h>
#include <map>

#include "cases.h"

using namespace kedge;

namespace
{
class Tangents : public testing::TestWithParam<Case>
{
protected:
  const Material material = make_material(GetParam().parameters);
  RandomStrain states{99};
  State any_state() { return random_state(GetParam(), states); }
};
INSTANTIATE_TEST_SUITE_P(Laws, Tangents, testing::ValuesIn(all_cases()), case_name);

/// d stress_i / d strain_j by central differences; false where the steps cross into another region.
bool differentiate(const Material& material, const State& state, const Eigen::Vector3d& strain, const double step,
                   Eigen::Matrix3d& tangent)
{
  const Status status = respond<false>(strain, state, material).status;
  for (int j = 0; j < 3; ++j)
  {
    const Response forth = respond<false>(strain + step * Eigen::Vector3d::Unit(j), state, material);
    const Response back = respond<false>(strain - step * Eigen::Vector3d::Unit(j), state, material);
    if (forth.status != status || back.status != status)
      return false;
    tangent.col(j) = (forth.stress - back.stress) / (2. * step);
  }
  return true;
}

/// Largest difference between the kernel's moduli and differences of tau G under du (x) G_b, over Young's modulus.
double spatial_error(const Material& material, const State& state, const Eigen::Matrix3d& increment,
                     const SymmetricTensor& b, const double step)
{
  const MaterialPoint point{young, cell_size, state.value};
  State ignored;
  const Eigen::Vector3d reference_a(0.7, -0.4, 0.5), reference_b(-0.3, 0.8, 0.6); // grad S before the increment
  SpatialTangent moduli;
  update_stress(increment, b, point, material, ignored.value, moduli);
  const auto force = [&](const Eigen::Matrix3d& f)
  {
    const Eigen::Vector3d gradient = f.inverse().transpose() * reference_a;
    return (full_matrix(update_stress(f, b, point, material, ignored.value).stress) * gradient).eval();
  };
  const Eigen::Vector3d gradient_a = increment.inverse().transpose() * reference_a;
  const Eigen::Vector3d gradient_b = increment.inverse().transpose() * reference_b;
  double contracted[27];
  moduli.contract({gradient_b[0], gradient_b[1], gradient_b[2]}, contracted);

  double error = 0.;
  for (int k = 0; k < 3; ++k)
  {
    const Eigen::Matrix3d change = step * Eigen::Vector3d::Unit(k) * reference_b.transpose();
    const Eigen::Vector3d difference = (force(increment + change) - force(increment - change)) / (2. * step);
    for (int i = 0; i < 3; ++i)
    {
      double sum = 0.;
      for (int j = 0; j < 3; ++j)
        sum += gradient_a[j] * contracted[(j * 3 + i) * 3 + k];
      error = std::max(error, std::abs(sum - difference[i]) / young);
    }
  }
  return error;
}

/// Far enough from regions' boundaries and from the residual stiffness for differences to be meaningful.
bool is_smooth(const Material& material, const State& state, const Eigen::Matrix3d& increment, const SymmetricTensor& b,
               const double step)
{
  const SymmetricTensor strain = logarithmic_strain(push_forward(increment, b));
  const Eigen::Vector3d principal = principal_frame(strain).values;
  Eigen::Matrix3d ignored;
  return differentiate(material, state, principal, 3. * step, ignored) &&
         respond(principal, state, material).residual_stiffness == 0.;
}
} // namespace

TEST_P(Tangents, PrincipalAgainstDifferences)
{
  RandomStrain random(1);
  std::map<Status, int> seen;
  for (int n = 0; n < 20000; ++n)
  {
    const double size = random.magnitude(-5., -1.);
    const Eigen::Vector3d strain = random.principal(size);
    const State state = any_state();
    Eigen::Matrix3d differences;
    if (!differentiate(material, state, strain, 1e-6 * size, differences))
      continue;
    const Response response = respond(strain, state, material);
    ++seen[response.status];
    ASSERT_LT((response.tangent - differences).lpNorm<Eigen::Infinity>(), 1e-6 * young)
        << strain.transpose() << " status " << int(response.status);
  }
  EXPECT_GT(seen[Status::elastic], 100);
  if (!GetParam().is<Elastic>())
  {
    EXPECT_GT(seen[Status::plastic], 100);
  }
  if (is_frictional(GetParam()))
  {
    EXPECT_GT(seen[Status::apex], 100);
  }
  if (GetParam().is<MohrCoulomb>())
  {
    EXPECT_GT(seen[Status::edge], 100);
  }
}

TEST_P(Tangents, ShearStiffnessIsTheQuotientOfDifferences)
{
  RandomStrain random(5);
  for (int n = 0; n < 20000; ++n)
  {
    const double size = random.magnitude(-5., -1.);
    const Eigen::Vector3d strain = random.principal(size);
    const Response response = respond(strain, any_state(), material);
    for (int i = 0; i < 3; ++i)
    {
      const int j = (i + 1) % 3;
      const double quotient = (response.stress[i] - response.stress[j]) / (strain[i] - strain[j]);
      if (std::abs(strain[i] - strain[j]) > 1e-4 * size)
      {
        ASSERT_NEAR(response.shear_stiffness[i], quotient, 1e-10 * young);
      }
    }
  }
}

TEST_P(Tangents, ShearStiffnessOfEqualStrainsIsTheTangent)
{
  RandomStrain random(6);
  for (int n = 0; n < 1000; ++n)
  {
    Eigen::Vector3d strain = random.principal(1e-2);
    const int i = n % 3, j = (n + 1) % 3;
    strain[j] = strain[i];
    const Response response = respond(strain, any_state(), material);
    const Eigen::Matrix3d& tangent = response.tangent;
    const double limit = 0.5 * (tangent(i, i) - tangent(i, j) + tangent(j, j) - tangent(j, i));
    ASSERT_NEAR(response.shear_stiffness[i], limit, 1e-12 * young);
  }
}

TEST_P(Tangents, SpatialAgainstDifferencesOfForces)
{
  RandomStrain random(2);
  int compared = 0;
  for (int n = 0; n < 3000; ++n)
  {
    const double size = random.magnitude(-3., -1.), step = 1e-5 * size;
    const SymmetricTensor b = left_cauchy_green(from_principal(random.principal(size), random.rotation()));
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(0.5 * size);
    const State state = any_state();
    if (!is_smooth(material, state, increment, b, step))
      continue;
    ++compared;
    ASSERT_LT(spatial_error(material, state, increment, b, step), 1e-6) << "case " << n;
  }
  EXPECT_GT(compared, 1000);
}

TEST_P(Tangents, SpatialWithEqualEigenvalues)
{
  RandomStrain random(3);
  for (const Eigen::Vector3d& strain : {Eigen::Vector3d(-2., -2., -2.), Eigen::Vector3d(-3., -1., -1.),
                                        Eigen::Vector3d(-1., -1., -4.), Eigen::Vector3d(-2.5, -2., -2.5)})
    for (const double gap : {0., 1e-16, 1e-13, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4})
    {
      const double size = 1e-2;
      const Eigen::Vector3d principal = size * (strain + gap * Eigen::Vector3d(1., 2., -1.));
      const SymmetricTensor b = left_cauchy_green(from_principal(principal, random.rotation()));
      const Eigen::Matrix3d increment = random.rotation();
      EXPECT_LT(spatial_error(material, any_state(), increment, b, 1e-5 * size), 1e-6)
          << strain.transpose() << " gap " << gap;
    }
}

TEST_P(Tangents, SpatialInLargeStrain)
{
  RandomStrain random(4);
  int compared = 0;
  for (int n = 0; n < 300; ++n)
  {
    const SymmetricTensor b = left_cauchy_green(random.symmetric(0.2));
    const Eigen::Matrix3d increment = random.rotation() * (Eigen::Matrix3d::Identity() + random.matrix(0.3));
    const State state = any_state();
    if (!is_smooth(material, state, increment, b, 1e-6))
      continue;
    ++compared;
    ASSERT_LT(spatial_error(material, state, increment, b, 1e-6), 1e-6) << "case " << n;
  }
  EXPECT_GT(compared, 100);
}

/// The damped moduli of a yielding point less its own are a share of 1/2 D : L : B alone, the elastic law's moduli plus
/// its tau_il delta_jk; an elastic point has nothing to add.
TEST_P(Tangents, DampingAddsAShareOfTheElasticModuli)
{
  const double share = 0.05;
  MaterialParameters linear = GetParam().parameters;
  linear.law = law_index<Elastic>;
  const Material elastic = make_material(linear);
  RandomStrain random(7);
  int yielding = 0;
  for (int n = 0; n < 300; ++n)
  {
    const SymmetricTensor b = left_cauchy_green(random.symmetric(1e-2));
    const Eigen::Matrix3d increment = Eigen::Matrix3d::Identity() + random.matrix(1e-2);
    const State state = any_state();
    if (!is_smooth(material, state, increment, b, 1e-7))
      continue;
    SpatialTangent own, damped, full;
    const MaterialPoint point{young, cell_size, state.value};
    State ignored;
    const Status status = update_stress(increment, b, point, material, ignored.value, own).status;
    update_stress(increment, b, point, material, ignored.value, damped, share);
    const Eigen::Matrix3d stress = full_matrix(update_stress(increment, b, point, elastic, ignored.value, full).stress);
    const double expected_share = status == Status::elastic ? 0. : share;
    yielding += status != Status::elastic;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l)
            ASSERT_NEAR(damped(i, j, k, l) - own(i, j, k, l),
                        expected_share * (full(i, j, k, l) + (j == k ? stress(i, l) : 0.)), 1e-12 * young);
  }
  if (!GetParam().is<Elastic>())
  {
    EXPECT_GT(yielding, 30);
  }
}

TEST(ApexTangent, KeepsTheResidualFractionOfTheElasticOne)
{
  const Material material = make_material(frictional_case<MohrCoulomb>("", 30., 0., 0.).parameters);
  SpatialTangent moduli;
  const StressUpdate update =
      update_stress(1.001 * Eigen::Matrix3d::Identity(), left_cauchy_green(SymmetricTensor::Zero()),
                    {young, cell_size, nullptr}, material, nullptr, moduli);
  ASSERT_EQ(update.status, Status::apex);
  const HenckyElasticity elasticity = material.elasticity(young);
  const double stress = 1e-7 * young / std::tan(30. * degree);
  EXPECT_NEAR(update.stress[0], stress, 1e-12 * stress);
  EXPECT_NEAR(moduli(0, 0, 0, 0), 1e-3 * (elasticity.lame + 2. * elasticity.shear) - stress, 1e-9 * young);
  EXPECT_NEAR(moduli(0, 1, 0, 1), 1e-3 * elasticity.shear, 1e-9 * young);
  EXPECT_NEAR(moduli(0, 0, 1, 1), 1e-3 * elasticity.lame, 1e-9 * young);
  EXPECT_NEAR(moduli(0, 1, 1, 0), 1e-3 * elasticity.shear - stress, 1e-9 * young);
}
