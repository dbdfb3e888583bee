#include <gtest/gtest.h>

#include "element.h"

using namespace kedge;

namespace
{
class Surfaces : public testing::TestWithParam<Case>
{
protected:
  const Material material = make_material(GetParam().parameters);
  RandomStrain states{99};
  State any_state() { return random_state(GetParam(), states); }
};
INSTANTIATE_TEST_SUITE_P(Laws, Surfaces, testing::ValuesIn(plastic_cases()), case_name);

Eigen::Vector3d plastic_strain(const Response& response, const Eigen::Vector3d& trial)
{
  return trial - response.elastic_strain;
}

/// Stress after compression along z at the lateral stress `cell` (negative in compression).
Eigen::Vector3d compressed_along_z(const Case& c, const double cell)
{
  Element element(c, cell);
  for (int step = 0; step < 500; ++step)
    element.strain_along_z(-1e-4, cell);
  return element.stress;
}
} // namespace

TEST_P(Surfaces, StressIsNeverOutside)
{
  RandomStrain random(1);
  for (int n = 0; n < 100000; ++n)
  {
    const Answer response = respond<false>(random.principal(random.magnitude(-7., 0.)), any_state(), material);
    const double f = yield_function(GetParam(), response.stress, response.next);
    const double strength = std::max(response.stress.norm(), 1e-7 * young);
    ASSERT_LE(f, 1e-8 * strength);
    if (response.status != Status::elastic)
    {
      ASSERT_GE(f, -1e-8 * strength);
    }
  }
}

TEST_P(Surfaces, ElasticStrainIsThatOfTheStress)
{
  RandomStrain random(2);
  for (int n = 0; n < 10000; ++n)
  {
    const double size = random.magnitude(-6., -1.);
    const Response response = respond<false>(random.principal(size), any_state(), material);
    const Eigen::Vector3d strain = material.elasticity(young).strain(response.stress);
    ASSERT_LT((response.elastic_strain - strain).norm(), 1e-13 * size);
  }
}

TEST_P(Surfaces, ReturningTwiceChangesNothing)
{
  RandomStrain random(3);
  for (int n = 0; n < 10000; ++n)
  {
    const double size = random.magnitude(-6., -1.);
    const Answer once = respond<false>(random.principal(size), any_state(), material);
    const Answer twice = respond<false>(once.elastic_strain, once.next, material);
    ASSERT_LT((once.stress - twice.stress).norm(), 1e-12 * size * young);
  }
}

TEST_P(Surfaces, PermutedStrainsPermuteTheResponse)
{
  RandomStrain random(4);
  for (int n = 0; n < 1000; ++n)
  {
    const Eigen::Vector3d strain = random.principal(1e-2);
    const State state = any_state();
    const Response plain = respond(strain, state, material);
    Eigen::PermutationMatrix<3> permutation;
    permutation.indices() = Eigen::Vector3i(n % 3, (n + 1 + n % 2) % 3, (n + 2 - n % 2) % 3);
    const Response permuted = respond((permutation * strain).eval(), state, material);
    ASSERT_LT((permutation * plain.stress - permuted.stress).norm(), 1e-9);
    ASSERT_LT((permutation * plain.tangent * permutation.transpose() - permuted.tangent).norm(), 1e-7 * young);
  }
}

TEST_P(Surfaces, VolumeChangesAsTheDilationAngleSays)
{
  RandomStrain random(5);
  int seen = 0;
  for (int n = 0; n < 20000; ++n)
  {
    const double size = random.magnitude(-5., -1.);
    const Eigen::Vector3d trial = random.principal(size);
    const Answer response = respond<false>(trial, any_state(), material);
    if (response.status != Status::plastic && response.status != Status::edge)
      continue;
    ++seen;
    const Eigen::Vector3d plastic = plastic_strain(response, trial);
    ASSERT_NEAR(plastic.sum(), plastic_volume(GetParam(), plastic, response.next), 1e-12 * size);
  }
  EXPECT_GT(seen, 1000);
}

TEST_P(Surfaces, PlasticIncrementIsTheEquivalentStrain)
{
  RandomStrain random(6);
  for (int n = 0; n < 1000; ++n)
  {
    const Eigen::Vector3d trial = random.principal(1e-2);
    const Response response = respond<false>(trial, any_state(), material);
    const Eigen::Vector3d plastic = plastic_strain(response, trial);
    const double equivalent = std::sqrt(2. / 3.) * (plastic.array() - plastic.mean()).matrix().norm();
    ASSERT_NEAR(response.plastic_increment, equivalent, 1e-15);
  }
}

TEST(MohrCoulomb, TriaxialCompressionFailsAtTheRankineRatio)
{
  const Eigen::Vector3d stress = compressed_along_z(frictional_case<MohrCoulomb>("", 30., 0., 0.), -1e5);
  EXPECT_NEAR(stress[0], -1e5, 1e-4);
  EXPECT_NEAR(stress[2] / stress[0], 3., 1e-4); // the apparent cohesion of 1 Pa adds 3.5e-5
}

TEST(DruckerPrager, MeetsMohrCoulombInTriaxialCompression)
{
  const Eigen::Vector3d stress = compressed_along_z(frictional_case<DruckerPrager>("", 30., 10., 2e3), -1e5);
  EXPECT_NEAR(stress[2], -3e5 - 2. * 2e3 * std::sqrt(3.), 1e-3);
}

TEST(MohrCoulomb, PlaneStrainShearEndsOnAFaceWithTheRightMohrCircle)
{
  const Case c = frictional_case<MohrCoulomb>("", 35., 5., 1e3);
  const Response response = respond<false>(Eigen::Vector3d(5e-3, 0., -1.5e-2), State(), make_material(c.parameters));
  ASSERT_EQ(response.status, Status::plastic);
  const double radius = 0.5 * (response.stress[0] - response.stress[2]);
  const double centre = 0.5 * (response.stress[0] + response.stress[2]);
  EXPECT_NEAR(radius, 1e3 * std::cos(35. * degree) - centre * std::sin(35. * degree), 1e-8 * radius);
  EXPECT_GT(response.stress[0], response.stress[1]);
  EXPECT_GT(response.stress[1], response.stress[2]);
}

TEST(MohrCoulomb, EdgesHaveTwoEqualStresses)
{
  const Material material = make_material(frictional_case<MohrCoulomb>("", 30., 0., 1e3).parameters);
  const Response compression = respond<false>(Eigen::Vector3d(1e-2, 0.99e-2, -6e-2), State(), material);
  ASSERT_EQ(compression.status, Status::edge);
  EXPECT_NEAR(compression.stress[0], compression.stress[1], 1e-9 * compression.stress.norm());
  const Response extension = respond<false>(Eigen::Vector3d(-3.01e-2, 2e-2, -3e-2), State(), material);
  ASSERT_EQ(extension.status, Status::edge);
  EXPECT_NEAR(extension.stress[0], extension.stress[2], 1e-9 * extension.stress.norm());
}

TEST(Apex, SharedByEveryFrictionalLaw)
{
  for (const Case& c : frictional_cases())
  {
    const Answer response = respond<false>(Eigen::Vector3d(2e-2, 1e-2, 3e-2), State(), make_material(c.parameters));
    ASSERT_EQ(response.status, Status::apex) << c;
    const double expected = least_cohesion(c) / std::tan(std::asin(friction_now(c, response.next)));
    EXPECT_NEAR(response.stress[1], expected, 1e-12 * expected) << c;
  }
}

TEST(WillamWarnke, SectionIsOneInCompressionAndTheExtensionRatioInExtension)
{
  const WillamWarnke law =
      make_material(frictional_case<WillamWarnke>("", 32., 0., 0.).parameters).laws.get<WillamWarnke>();
  const double sine = std::sin(32. * degree);
  EXPECT_NEAR(law.section(0.5, std::sqrt(0.75)).radius, 1., 1e-15);
  EXPECT_NEAR(law.section(1., 0.).radius, (3. - sine) / (3. + sine), 1e-15);
  EXPECT_NEAR(law.section(0.5, std::sqrt(0.75)).derivative, 0., 1e-14);
  EXPECT_EQ(law.section(1., 0.).derivative, 0.);
}

TEST(VonMises, UniaxialStressIsTheYieldStress)
{
  EXPECT_NEAR(compressed_along_z(make_case<VonMises>("", {{"yield stress", 2e4}}), 0.)[2], -2e4, 1e-6);
}

TEST(Tresca, StressDifferenceIsTwiceTheCohesion)
{
  const Material material = make_material(frictional_case<MohrCoulomb>("", 0., 0., 1e4).parameters);
  const Response response = respond<false>(Eigen::Vector3d(1e-2, 3e-3, -5e-3), State(), material);
  EXPECT_NEAR(response.stress.maxCoeff() - response.stress.minCoeff(), 2e4, 1e-7);
}
