#include <gtest/gtest.h>

#include "cases.h"

using namespace kedge;

namespace
{
/// Largest error of Q diag(values) Q^T, and of Q^T Q = 1, over the largest entry.
double frame_error(const SymmetricTensor& s)
{
  const PrincipalFrame frame = principal_frame(s);
  const Eigen::Matrix3d& q = frame.directions;
  const double rebuilt = (from_principal(frame.values, q) - s).lpNorm<Eigen::Infinity>() / s.lpNorm<Eigen::Infinity>();
  return std::max(rebuilt, (q.transpose() * q - Eigen::Matrix3d::Identity()).lpNorm<Eigen::Infinity>());
}

/// R diag(values) R^T.
SymmetricTensor turned(const Eigen::Vector3d& values, const Eigen::Matrix3d& rotation)
{
  return from_principal(values, rotation);
}
} // namespace

TEST(PrincipalFrame, RandomTensors)
{
  RandomStrain random(1);
  for (int n = 0; n < 100000; ++n)
    ASSERT_LT(frame_error(random.symmetric(random.magnitude(-140., 140.))), 4e-15);
}

TEST(PrincipalFrame, NearlyEqualEigenvalues)
{
  RandomStrain random(2);
  for (int n = 0; n < 100000; ++n)
  {
    const double gap = random.magnitude(-18., 0.), other = random.magnitude(-18., 0.);
    ASSERT_LT(frame_error(turned({1., 1. + gap, 1. - other}, random.rotation())), 4e-15);
  }
}

TEST(PrincipalFrame, IsotropicUpToTheLastBits)
{
  RandomStrain random(6);
  for (int n = 0; n < 100000; ++n)
  {
    SymmetricTensor s;
    for (int i = 0; i < 6; ++i)
      s[i] = (i < 3 ? 1. / 3. : 0.) + std::round(random.uniform(-2., 2.)) * 5.551115123125783e-17;
    ASSERT_LT(frame_error(s), 4e-15);
  }
}

TEST(PrincipalFrame, EqualEigenvaluesAndDiagonals)
{
  for (const Eigen::Vector3d& values :
       {Eigen::Vector3d(1., 1., 1.), Eigen::Vector3d(1., 2., 2.), Eigen::Vector3d(2., 1., 2.),
        Eigen::Vector3d(-3., -3., 1.), Eigen::Vector3d(1., 0., -1.), Eigen::Vector3d(0., 0., 5.)})
    EXPECT_LT(frame_error(turned(values, Eigen::Matrix3d::Identity())), 1e-15) << values.transpose();
  EXPECT_EQ(principal_frame(SymmetricTensor::Zero()).values, Eigen::Vector3d::Zero().eval());
}

TEST(PrincipalFrame, DirectionsAreARotation)
{
  RandomStrain random(3);
  for (int n = 0; n < 1000; ++n)
    ASSERT_NEAR(principal_frame(random.symmetric(1.)).directions.determinant(), 1., 1e-14);
}

TEST(PrincipalFrame, OfThePlaneKeepsTheThirdAxis)
{
  const auto tensor = [](const double xx, const double yy, const double zz, const double xy)
  { return SymmetricTensor((SymmetricTensor() << xx, yy, zz, xy, 0., 0.).finished()); };
  const std::array<SymmetricTensor, 5> tensors{{tensor(2., 1., 1.5, 0.3), tensor(1., 2., 0.5, -0.3),
                                                tensor(1., 1., 3., 0.2), tensor(1., 1., 1., 0.),
                                                tensor(1., 1. + 1e-15, 2., 1e-16)}};
  for (const SymmetricTensor& s : tensors)
  {
    const PrincipalFrame frame = plane_frame(s);
    EXPECT_EQ(frame.values[2], s[2]);
    EXPECT_LT((frame.directions.col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
    EXPECT_LT((frame.directions * frame.directions.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(frame.directions.determinant(), 1., 1e-14);
    EXPECT_LT((from_principal(frame.values, frame.directions) - s).norm(), 1e-14);
  }
}

TEST(PrincipalFrame, EigenvaluesOfEigen)
{
  RandomStrain random(4);
  for (int n = 0; n < 1000; ++n)
  {
    const SymmetricTensor s = random.symmetric(1.);
    Eigen::Vector3d values = principal_frame(s).values;
    std::sort(values.data(), values.data() + 3);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> reference(full_matrix(s));
    ASSERT_LT((values - reference.eigenvalues()).norm(), 3e-15);
  }
}

TEST(LogarithmicStrain, InvertsTheLeftCauchyGreenTensor)
{
  RandomStrain random(5);
  for (int n = 0; n < 10000; ++n)
  {
    const SymmetricTensor strain = random.symmetric(random.magnitude(-8., -0.5));
    ASSERT_LT((logarithmic_strain(left_cauchy_green(strain)) - strain).lpNorm<Eigen::Infinity>(), 2e-15);
  }
}

TEST(LogarithmicStrain, OfAUniaxialStretch)
{
  SymmetricTensor b;
  b << 1., 1.44, 1., 0., 0., 0.;
  SymmetricTensor expected = SymmetricTensor::Zero();
  expected[1] = std::log(1.2);
  EXPECT_LT((logarithmic_strain(b) - expected).norm(), 1e-15);
}

TEST(HenckyElasticity, StrainInvertsStress)
{
  const HenckyElasticity elasticity{3e6, 2e6};
  const Eigen::Vector3d strain(1e-3, -4e-3, 2e-4);
  EXPECT_LT((elasticity.strain(elasticity.stress(strain)) - strain).norm(), 1e-17);
  EXPECT_LT((elasticity.tangent() * strain - elasticity.stress(strain)).norm(), 1e-10);
}
