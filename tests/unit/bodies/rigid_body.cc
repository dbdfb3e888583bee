#include "rigid_fixtures.h"
#include "shapes.h"
#include <random>

namespace kedge
{
namespace
{
using Eigen::Vector3d;

using test::increment;

TEST(Pose, PointsGoToTheBodyAndBack)
{
  Pose pose;
  pose.position = {1., 2., 3.};
  pose.rotation = rotation_from_vector({0.3, -0.7, 1.1});
  const Vector3d x(0.4, -2., 5.);
  EXPECT_NEAR((pose.to_world(pose.to_body(x)) - x).norm(), 0., 1e-14);
  EXPECT_NEAR((pose.direction_to_world(pose.direction_to_body(x)) - x).norm(), 0., 1e-14);
}

TEST(Pose, QuarterTurnAboutZTakesXToY)
{
  const Pose pose = Pose().moved(increment(Vector3d::Zero(), M_PI / 2. * Vector3d::UnitZ()));
  EXPECT_NEAR((pose.to_world(Vector3d::UnitX()) - Vector3d::UnitY()).norm(), 0., 1e-15);
}

TEST(Pose, ManyIncrementsAboutOneAxisMakeOneRotation)
{
  const Vector3d axis = Vector3d(1., -2., 0.5).normalized();
  Pose pose;
  for (int i = 0; i < 1000; ++i)
    pose = pose.moved(increment(Vector3d::Zero(), 2.5e-3 * axis));
  EXPECT_NEAR(pose.rotation.angularDistance(rotation_from_vector(2.5 * axis)), 0., 1e-12);
}

TEST(Pose, IncrementsAreAboutWorldAxes)
{
  const Vector3d first(0.3, 0., 0.), second(0., 0.4, 0.);
  const Pose pose = Pose().moved(increment(Vector3d::Zero(), first)).moved(increment(Vector3d::Zero(), second));
  EXPECT_NEAR(pose.rotation.angularDistance(rotation_from_vector(second) * rotation_from_vector(first)), 0., 1e-15);
}

TEST(Pose, RotationStaysOrthogonalOverManyUpdates)
{
  std::mt19937 engine(1);
  std::normal_distribution<double> normal(0., 0.1);
  Pose pose;
  for (int i = 0; i < 100000; ++i)
    pose = pose.moved(increment(Vector3d::Zero(), {normal(engine), normal(engine), normal(engine)}));
  const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_NEAR(R.determinant(), 1., 1e-14);
}

TEST(Rotation, VectorAndRotationAreInverse)
{
  const Vector3d axis = Vector3d(0.2, 1., -0.4).normalized();
  for (const double angle : {0., 1e-13, 1e-8, 1e-4, 0.5, 2., 3.1})
    EXPECT_NEAR((vector_from_rotation(rotation_from_vector(angle * axis)) - angle * axis).norm(), 0.,
                1e-14 + 1e-14 * angle)
        << angle;
}

TEST(Rotation, VectorOfTheNegativeQuaternionIsTheSame)
{
  Eigen::Quaterniond q = rotation_from_vector({0.1, 0.2, 0.3});
  q.coeffs() *= -1.;
  EXPECT_NEAR((vector_from_rotation(q) - Vector3d(0.1, 0.2, 0.3)).norm(), 0., 1e-15);
}

TEST(Rotation, MotionTangentIsTheDerivative)
{
  Pose start;
  start.position = {1., 2., 3.};
  start.rotation = rotation_from_vector({0.3, -0.7, 1.1});
  const Vector3d X(0.5, -0.4, 2.);
  constexpr double h = 1e-6;
  for (const double angle : {0., 1e-6, 1e-2, 0.499, 0.501, 2.5})
  {
    const Vector6 y = increment({0.1, 0.2, 0.3}, angle * Vector3d(0.6, 0., -0.8));
    Eigen::Matrix<double, 3, 6> differences;
    for (int i = 0; i < 6; ++i)
      differences.col(i) =
          (start.moved(y + h * Vector6::Unit(i)).to_world(X) - start.moved(y - h * Vector6::Unit(i)).to_world(X)) /
          (2. * h);
    EXPECT_NEAR((motion_tangent(start, y, X) - differences).norm(), 0., 1e-8) << angle;
  }
}

TEST(Rotation, TangentsAreContinuousWhereTheSeriesTakesOver)
{
  const Vector3d axis = Vector3d(1., 2., 3.).normalized(), moment(0.5, -2., 1.);
  const Vector3d below = (0.5 - 1e-15) * axis, above = (0.5 + 1e-15) * axis;
  EXPECT_NEAR((rotation_tangent(below) - rotation_tangent(above)).norm(), 0., 1e-13);
  EXPECT_NEAR((generalised_moment_tangent(below, moment) - generalised_moment_tangent(above, moment)).norm(), 0.,
              1e-12);
}

TEST(Rotation, GeneralisedMomentTangentIsTheDerivative)
{
  const Vector3d moment(0.5, -2., 1.);
  constexpr double h = 1e-5;
  for (const double angle : {0., 1e-6, 0.1, 0.499, 0.501, 2.5})
  {
    const Vector3d theta = angle * Vector3d(0.6, 0., -0.8);
    Eigen::Matrix3d differences;
    for (int i = 0; i < 3; ++i)
      differences.col(i) = (rotation_tangent(theta + h * Vector3d::Unit(i)).transpose() -
                            rotation_tangent(theta - h * Vector3d::Unit(i)).transpose()) *
                           moment / (2. * h);
    EXPECT_LT((generalised_moment_tangent(theta, moment) - differences).norm(), 1e-8 * differences.norm()) << angle;
  }
}

TEST(RigidPoint, PrescribedMotionIsCutWithTheStep)
{
  PointParameters parameters;
  parameters.conditions[0] = {DofCondition::Kind::prescribed, 0.04};
  parameters.conditions[1] = {DofCondition::Kind::free, 0.};
  parameters.conditions[4] = {DofCondition::Kind::prescribed, -0.02};
  const RigidPoint point(parameters, {}, 3);
  Vector6 expected;
  expected << 0.01, 0., 0., 0., -0.005, 0.;
  EXPECT_EQ(point.prescribed_increment(0.25), expected);
  EXPECT_EQ(point.n_free_dofs(), 1u);
  EXPECT_TRUE(point.is_free(1));
}

TEST(RigidPoint, CutStepsAddUpToTheUncutOne)
{
  PointParameters parameters;
  for (unsigned int dof = 0; dof < 6; ++dof)
    parameters.conditions[dof] = {DofCondition::Kind::prescribed, 0.1 * (dof + 1)};
  const RigidPoint point(parameters, {}, 3);
  const Pose once = point.pose.moved(point.prescribed_increment(1.));
  Pose cut = point.pose;
  for (const double fraction : {0.5, 0.25, 0.125, 0.125})
    cut = cut.moved(point.prescribed_increment(fraction));
  EXPECT_NEAR((cut.position - once.position).norm(), 0., 1e-15);
  EXPECT_NEAR(cut.rotation.angularDistance(once.rotation), 0., 1e-14);
}

TEST(RigidPoint, OffsetMovesIt)
{
  PointParameters parameters;
  parameters.position = {1., 2., 3.};
  EXPECT_EQ(RigidPoint(parameters, {10., 20., 30.}, 3).pose.position, Vector3d(11., 22., 33.));
  EXPECT_EQ(RigidPoint(parameters, {10., 20., 0.}, 2).pose.position, Vector3d(11., 0., 22.));
}

TEST(RigidPoint, InertiaTurnsWithTheBody)
{
  PointParameters parameters;
  parameters.inertia = {1., 2., 3.};
  RigidPoint point(parameters, {}, 3);
  point.pose = point.pose.moved(increment(Vector3d::Zero(), M_PI / 2. * Vector3d::UnitZ()));
  EXPECT_NEAR((point.world_inertia() - Vector3d(2., 1., 3.).asDiagonal().toDenseMatrix()).norm(), 0., 1e-14);
}

TEST(RigidSystems, ATurnTakesFarCornersFarther)
{
  RigidSystems systems;
  systems.first_point.push_back(0);
  systems.points.emplace_back(test::point_at({0., 0., 0.}, true), std::array<double, 3>{}, 3);
  systems.surfaces.push_back({Surface(test::box({9., 0., 0.}, {10., 1., 1.})), 0});
  const Vector3d shift(0.2, 0., 0.);
  const auto apart = farthest_apart(systems, {increment(shift, {0., 0., 0.3})}, {increment(shift, {0., 0., 0.2})});
  ASSERT_EQ(apart.size(), 1u);
  EXPECT_NEAR(apart[0], 2. * std::hypot(10., 1.) * std::sin(0.05), 1e-12); // the chord of the outer edge
  EXPECT_EQ(farthest_apart(systems, {increment(shift, shift)}, {increment(shift, shift)}), std::vector<double>{0.});
}
} // namespace
} // namespace kedge
