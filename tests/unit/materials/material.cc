#include <gtest/gtest.h>

#include "cases.h"

using namespace kedge;

TEST(Material, ElasticConstants)
{
  const HenckyElasticity elasticity = make_material(make_case<Elastic>("", {}, 0.25).parameters).elasticity(10.);
  EXPECT_DOUBLE_EQ(elasticity.lame, 4.);
  EXPECT_DOUBLE_EQ(elasticity.shear, 4.);
}

TEST(Material, ConstantsOfOtherLawsStayUnset)
{
  const Material material = make_material(frictional_case<MohrCoulomb>("", 30., 0., 0.).parameters);
  EXPECT_TRUE(std::isnan(material.laws.get<DruckerPrager>().slope));
  EXPECT_TRUE(std::isnan(material.laws.get<WillamWarnke>().slope));
  EXPECT_FALSE(std::isnan(material.laws.get<MohrCoulomb>().sin_phi));
}

TEST(EffectiveYoung, IsConstantWithoutOverburden)
{
  MaterialParameters parameters;
  parameters.young = 5e6;
  EXPECT_EQ(effective_young(parameters, 1e9), 5e6);
}

TEST(EffectiveYoung, GrowsWithThePowerOfTheVerticalStress)
{
  MaterialParameters parameters;
  parameters.young = 5e6;
  parameters.overburden = Overburden{1e5, 0.5};
  EXPECT_DOUBLE_EQ(effective_young(parameters, 4e5), 1e7);
}

TEST(EffectiveYoung, StaysPositiveAtTheSurface)
{
  MaterialParameters parameters;
  parameters.young = 5e6;
  parameters.overburden = Overburden{1e5, 0.5};
  EXPECT_DOUBLE_EQ(effective_young(parameters, 0.), 5e4);
  EXPECT_DOUBLE_EQ(effective_young(parameters, -1.), 5e4);
}

TEST(StressUpdate, RefusesAnInvertedIncrement)
{
  const Material material = make_material(make_case<Elastic>("").parameters);
  const MaterialPoint point{young, cell_size, nullptr};
  const SymmetricTensor b = left_cauchy_green(SymmetricTensor::Zero());
  SpatialTangent moduli;
  const Eigen::Matrix3d mirrored = Eigen::Vector3d(1., 1., -1.).asDiagonal();
  EXPECT_EQ(update_stress(mirrored, b, point, material, nullptr, moduli).status, Status::inverted);
  EXPECT_EQ(moduli(0, 0, 0, 0), 0.);
  EXPECT_EQ(update_stress(Eigen::Matrix3d::Zero(), b, point, material, nullptr).status, Status::inverted);
  EXPECT_EQ(update_stress(Eigen::Matrix3d::Constant(std::nan("")), b, point, material, nullptr).status,
            Status::inverted);
}

TEST(StressUpdate, UniaxialCompressionOfTheHenckySolid)
{
  // E ln(0.75) for nu = 0, whatever the direction.
  const Material material = make_material(make_case<Elastic>("", {}, 0.).parameters);
  const SymmetricTensor b = left_cauchy_green(SymmetricTensor::Zero());
  const Eigen::Matrix3d increment = Eigen::Vector3d(1., 1., 0.75).asDiagonal();
  const StressUpdate update = update_stress(increment, b, {1e6, cell_size, nullptr}, material, nullptr);
  EXPECT_NEAR(update.stress[2], 1e6 * std::log(0.75), 1e-9);
  EXPECT_NEAR(update.stress[0], 0., 1e-9);
}
