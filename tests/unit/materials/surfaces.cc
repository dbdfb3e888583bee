#include <gtest/gtest.h>

#include "cases.h"

using namespace kedge;

namespace
{
class Surfaces : public testing::TestWithParam<Case>
{
protected:
  const Material material = make_material(GetParam().parameters);
};
INSTANTIATE_TEST_SUITE_P(Laws, Surfaces, testing::ValuesIn(plastic_cases()), case_name);

using Flow = Surfaces;
INSTANTIATE_TEST_SUITE_P(Laws, Flow, testing::ValuesIn(frictional_cases()), case_name);

Eigen::Vector3d plastic_strain(const Response& response, const Eigen::Vector3d& trial)
{
  return trial - response.elastic_strain;
}

/// Stress after compression along z at the lateral stress `cell` (negative in compression): strain steps whose lateral
/// part is corrected by Newton until the lateral stress is `cell`.
Eigen::Vector3d compressed_along_z(const Material& material, const double cell)
{
  Eigen::Vector3d strain = material.elasticity(young).strain(Eigen::Vector3d::Constant(cell));
  Response response = respond(strain, young, material);
  for (int step = 0; step < 500; ++step)
  {
    strain = response.elastic_strain + Eigen::Vector3d(0., 0., -1e-4);
    for (int i = 0; i < 30; ++i)
    {
      response = respond(strain, young, material);
      const double stiffness = response.tangent(0, 0) + response.tangent(0, 1);
      const double change = (cell - response.stress[0]) / stiffness;
      strain[0] += change;
      strain[1] += change;
    }
  }
  return response.stress;
}
} // namespace

TEST_P(Surfaces, StressIsNeverOutside)
{
  RandomStrain random(1);
  for (int n = 0; n < 100000; ++n)
  {
    const Response response = respond<false>(random.principal(random.magnitude(-7., 0.)), young, material);
    const double f = yield_function(GetParam(), response.stress);
    const double strength = std::max(response.stress.norm(), cohesion_of(GetParam()));
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
    const Response response = respond<false>(random.principal(size), young, material);
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
    const Response once = respond<false>(random.principal(size), young, material);
    const Response twice = respond<false>(once.elastic_strain, young, material);
    ASSERT_LT((once.stress - twice.stress).norm(), 1e-12 * size * young);
  }
}

TEST_P(Surfaces, PermutedStrainsPermuteTheResponse)
{
  RandomStrain random(4);
  for (int n = 0; n < 1000; ++n)
  {
    const Eigen::Vector3d strain = random.principal(1e-2);
    const Response plain = respond(strain, young, material);
    Eigen::PermutationMatrix<3> permutation;
    permutation.indices() = Eigen::Vector3i(n % 3, (n + 1 + n % 2) % 3, (n + 2 - n % 2) % 3);
    const Response permuted = respond((permutation * strain).eval(), young, material);
    ASSERT_LT((permutation * plain.stress - permuted.stress).norm(), 1e-9);
    ASSERT_LT((permutation * plain.tangent * permutation.transpose() - permuted.tangent).norm(), 1e-7 * young);
  }
}

TEST_P(Flow, VolumeChangesAsTheDilationAngleSays)
{
  RandomStrain random(5);
  const double sine = std::sin(GetParam().parameters.dilation_angle * degree);
  int seen = 0;
  for (int n = 0; n < 20000; ++n)
  {
    const double size = random.magnitude(-5., -1.);
    const Eigen::Vector3d trial = random.principal(size);
    const Response response = respond<false>(trial, young, material);
    if (response.status != Status::plastic && response.status != Status::edge)
      continue;
    ++seen;
    const Eigen::Vector3d plastic = plastic_strain(response, trial);
    const double deviator = (plastic.array() - plastic.mean()).matrix().norm();
    double volume;
    switch (GetParam().parameters.type)
    {
      case MaterialType::mohr_coulomb: // |strains| sum of both signs: the sum of all multipliers is half of 1-norm
        volume = sine * plastic.lpNorm<1>();
        break;
      case MaterialType::drucker_prager:
        volume = std::sqrt(3.) * deviator * 2. * std::sqrt(2.) * sine / (3. - sine);
        break;
      default:
        volume = std::sqrt(3.) * deviator * sine / std::sqrt(1. - sine * sine);
    }
    ASSERT_NEAR(plastic.sum(), volume, 1e-12 * size);
  }
  EXPECT_GT(seen, 1000);
}

TEST_P(Surfaces, PlasticIncrementIsTheEquivalentStrain)
{
  RandomStrain random(6);
  for (int n = 0; n < 1000; ++n)
  {
    const Eigen::Vector3d trial = random.principal(1e-2);
    const Response response = respond<false>(trial, young, material);
    const Eigen::Vector3d plastic = plastic_strain(response, trial);
    const double equivalent = std::sqrt(2. / 3.) * (plastic.array() - plastic.mean()).matrix().norm();
    ASSERT_NEAR(response.plastic_increment, equivalent, 1e-15);
  }
}

TEST(MohrCoulomb, TriaxialCompressionFailsAtTheRankineRatio)
{
  const Material material = make_material(make_case("", MaterialType::mohr_coulomb, 30., 0., 0.).parameters);
  const Eigen::Vector3d stress = compressed_along_z(material, -1e5);
  EXPECT_NEAR(stress[0], -1e5, 1e-4);
  EXPECT_NEAR(stress[2] / stress[0], 3., 1e-4); // the apparent cohesion of 1 Pa adds 3.5e-5
}

TEST(DruckerPrager, MeetsMohrCoulombInTriaxialCompression)
{
  const Material material = make_material(make_case("", MaterialType::drucker_prager, 30., 10., 2e3).parameters);
  const Eigen::Vector3d stress = compressed_along_z(material, -1e5);
  EXPECT_NEAR(stress[2], -3e5 - 2. * 2e3 * std::sqrt(3.), 1e-3);
}

TEST(MohrCoulomb, PlaneStrainShearEndsOnAFaceWithTheRightMohrCircle)
{
  const Case c = make_case("", MaterialType::mohr_coulomb, 35., 5., 1e3);
  const Response response = respond<false>(Eigen::Vector3d(5e-3, 0., -1.5e-2), young, make_material(c.parameters));
  ASSERT_EQ(response.status, Status::plastic);
  const double radius = 0.5 * (response.stress[0] - response.stress[2]);
  const double centre = 0.5 * (response.stress[0] + response.stress[2]);
  EXPECT_NEAR(radius, 1e3 * std::cos(35. * degree) - centre * std::sin(35. * degree), 1e-8 * radius);
  EXPECT_GT(response.stress[0], response.stress[1]);
  EXPECT_GT(response.stress[1], response.stress[2]);
}

TEST(MohrCoulomb, EdgesHaveTwoEqualStresses)
{
  const Material material = make_material(make_case("", MaterialType::mohr_coulomb, 30., 0., 1e3).parameters);
  const Response compression = respond<false>(Eigen::Vector3d(1e-2, 0.99e-2, -6e-2), young, material);
  ASSERT_EQ(compression.status, Status::edge);
  EXPECT_NEAR(compression.stress[0], compression.stress[1], 1e-9 * compression.stress.norm());
  const Response extension = respond<false>(Eigen::Vector3d(-3.01e-2, 2e-2, -3e-2), young, material);
  ASSERT_EQ(extension.status, Status::edge);
  EXPECT_NEAR(extension.stress[0], extension.stress[2], 1e-9 * extension.stress.norm());
}

TEST(Apex, SharedByEveryFrictionalLaw)
{
  for (const Case& c : frictional_cases())
  {
    const Response response = respond<false>(Eigen::Vector3d(2e-2, 1e-2, 3e-2), young, make_material(c.parameters));
    ASSERT_EQ(response.status, Status::apex) << c;
    const double expected = cohesion_of(c) / std::tan(c.parameters.friction_angle * degree);
    EXPECT_NEAR(response.stress[1], expected, 1e-12 * expected) << c;
  }
}

TEST(WillamWarnke, SectionIsOneInCompressionAndTheExtensionRatioInExtension)
{
  const WillamWarnke law =
      make_material(make_case("", MaterialType::willam_warnke, 32., 0., 0.).parameters).willam_warnke;
  const double sine = std::sin(32. * degree);
  EXPECT_NEAR(law.section(0.5, std::sqrt(0.75)).radius, 1., 1e-15);
  EXPECT_NEAR(law.section(1., 0.).radius, (3. - sine) / (3. + sine), 1e-15);
  EXPECT_NEAR(law.section(0.5, std::sqrt(0.75)).derivative, 0., 1e-14);
  EXPECT_EQ(law.section(1., 0.).derivative, 0.);
}

TEST(VonMises, UniaxialStressIsTheYieldStress)
{
  const Material material = make_material(make_case("", MaterialType::von_mises, 0., 0., 0.).parameters);
  EXPECT_NEAR(compressed_along_z(material, 0.)[2], -2e4, 1e-6);
}

TEST(Tresca, StressDifferenceIsTwiceTheCohesion)
{
  const Material material = make_material(make_case("", MaterialType::mohr_coulomb, 0., 0., 1e4).parameters);
  const Response response = respond<false>(Eigen::Vector3d(1e-2, 3e-3, -5e-3), young, material);
  EXPECT_NEAR(response.stress.maxCoeff() - response.stress.minCoeff(), 2e4, 1e-7);
}
