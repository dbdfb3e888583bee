#include "rigid_fixtures.h"

namespace kedge
{
namespace
{
using namespace test;
using Eigen::Vector3d;

constexpr double degree = M_PI / 180.;

const std::vector<std::pair<std::string, JointParameters>>& every_joint()
{
  static const auto joints = []
  {
    JointParameters oblique_hinge = hinge({0.3, 0.2, -0.4}, 2e3, 5e3);
    oblique_hinge.direction_1 = oblique_hinge.direction_2 = {1., 2., -0.5};
    JointParameters oblique_stop = stop({0.3, 0.2, -0.4}, {1., 0.5, 0.3}, 20., 3e3);
    oblique_stop.position_2 = {0.9, 0.8, -0.1};
    return std::vector<std::pair<std::string, JointParameters>>{
        {"ball", ball({0.3, 0.2, -0.4}, 1e3)},
        {"hinge", oblique_hinge},
        {"rod", rod({1.2, 0.1, 0.4}, {2., -0.5, 1.}, 1.1, 2e3)},
        {"stop", oblique_stop},
    };
  }();
  return joints;
}

/// Two points away from the anchors and already turned, so that the tangents are tested at a general orientation.
std::array<Pose, 2> turned_poses()
{
  std::array<Pose, 2> poses;
  poses[0].position = {1., -0.2, 0.3};
  poses[0].rotation = rotation_from_vector({0.2, -0.1, 0.15});
  poses[1].position = {1.9, 0.1, 0.6};
  poses[1].rotation = rotation_from_vector({-0.3, 0.25, 0.1});
  return poses;
}

Joint joint_of(const JointParameters& parameters)
{
  return make_joint(parameters, {point_at({1., -0.2, 0.3}, true), point_at({1.9, 0.1, 0.6}, true)}, 0, 3);
}

Vector12 both(const std::array<Vector6, 2>& increments)
{
  Vector12 y;
  y << increments[0], increments[1];
  return y;
}

JointResponse response_at(const Joint& joint, const std::array<Pose, 2>& start, const Vector12& y)
{
  return evaluate_joint(joint, start, {Vector6(y.head<6>()), Vector6(y.tail<6>())});
}

/// Increments of two points that turn by `angle` (rad) about different axes.
Vector12 large_increments(const double angle)
{
  return both({increment({0.1, -0.2, 0.15}, angle * Vector3d(0.6, 0., -0.8)),
               increment({-0.05, 0.1, 0.2}, angle * Vector3d(-1., 2., 2.) / 3.)});
}

TEST(Joint, ForceAndTangentAreDerivativesOfTheEnergy)
{
  constexpr double h = 1e-5;
  for (const auto& [name, parameters] : every_joint())
    for (const double angle : {0., 0.1, 0.5, 1.3})
    {
      const Joint joint = joint_of(parameters);
      const auto start = turned_poses();
      const Vector12 y = large_increments(angle);
      const JointResponse response = response_at(joint, start, y);
      Vector12 force;
      Matrix12 tangent;
      for (int i = 0; i < 12; ++i)
      {
        const JointResponse ahead = response_at(joint, start, y + h * Vector12::Unit(i)),
                            behind = response_at(joint, start, y - h * Vector12::Unit(i));
        force[i] = (ahead.energy - behind.energy) / (2. * h);
        tangent.col(i) = (ahead.force - behind.force) / (2. * h);
      }
      ASSERT_GT(response.energy, 0.) << name;
      EXPECT_LT((response.force - force).norm(), 1e-6 * force.norm()) << name << ' ' << angle;
      EXPECT_LT((response.tangent - tangent).norm(), 1e-6 * tangent.norm()) << name << ' ' << angle;
      EXPECT_LT((response.tangent - response.tangent.transpose()).norm(), 1e-12 * tangent.norm()) << name;
    }
}

TEST(Joint, ActionIsReactionAlsoInMoments)
{
  for (const auto& [name, parameters] : every_joint())
  {
    const auto start = turned_poses();
    const Vector12 y = large_increments(0.7);
    const Vector12 force = response_at(joint_of(parameters), start, y).force;
    Vector6 sum = Vector6::Zero();
    for (int i = 0; i < 2; ++i)
    {
      const Vector6 own = y.segment<6>(6 * i);
      const Vector6 load = generalised_map(own).transpose().inverse() * force.segment<6>(6 * i);
      sum += load;
      sum.tail<3>() += start[i].moved(own).position.cross(load.head<3>());
    }
    EXPECT_NEAR(sum.norm(), 0., 1e-13 * force.norm()) << name;
  }
}

TEST(Joint, StartsRelaxedWhereItIsDrawn)
{
  SystemParameters lone, system;
  lone.points = {point_at({0., 0., 0.}, true)};
  system.points = {point_at({1., 2., 3.}, true), point_at({2., 2., 4.}, true)};
  system.joints = {ball({1.5, 2., 3.}, 1e3), hinge({1.5, 2., 3.}, 1e3, 1e3), rod({1., 2., 3.5}, {4., 2., 7.5}, 5., 1e3),
                   stop({1.5, 2., 3.}, {3., 2., 3.}, 30., 1e3)};
  system.offset = {10., 20., 30.};
  const RigidSystems systems = make_rigid_systems({lone, system}, 3);
  ASSERT_EQ(systems.joints.size(), 4u);
  for (const Joint& joint : systems.joints)
  {
    EXPECT_EQ(joint.points, (std::array<unsigned int, 2>{1, 2}));
    const JointResponse response =
        evaluate_joint(joint, {systems.points[1].pose, systems.points[2].pose}, {Vector6::Zero(), Vector6::Zero()});
    EXPECT_NEAR(response.force.norm(), 0., 1e-10);
  }
  EXPECT_NEAR((systems.points[2].pose.to_world(systems.joints[0].anchors[1]) - Vector3d(11.5, 22., 33.)).norm(), 0.,
              1e-13);
}

TEST(Joint, PlaneStrainReadsXAndZ)
{
  const Joint joint =
      make_joint(ball({1., 2., 0.}, 1e3), {point_at({0.5, 0.5, 0.}, true), point_at({0., 0., 0.}, true)}, 0, 2);
  EXPECT_NEAR((joint.anchors[0] - Vector3d(0.5, 0., 1.5)).norm(), 0., 1e-15);
}

/// Increment that turns a body of this pose about a point of the world.
Vector6 turn_about(const Pose& pose, const Vector3d& centre, const Vector3d& theta)
{
  return increment(centre + rotation_from_vector(theta) * (pose.position - centre) - pose.position, theta);
}

TEST(Hinge, TurnsFreelyAboutItsAxisOnly)
{
  const std::array<Pose, 2> start{};
  for (const double sense : {1., -1.})
  {
    JointParameters parameters = hinge({0.5, 0., 0.}, 1e9, 1e8);
    parameters.direction_2[1] = sense; // only the line of an axis counts
    const Joint joint = make_joint(parameters, {point_at({}, true), point_at({}, true)}, 0, 3);
    const auto energy = [&](const Vector3d& theta) {
      return evaluate_joint(joint, start, {Vector6::Zero(), turn_about(start[1], {0.5, 0., 0.}, theta)}).energy;
    };
    EXPECT_NEAR(energy({0., 1.2, 0.}), 0., 1e-6);
    EXPECT_NEAR(energy({0.02, 0., 0.}), 1e8 * (1. - std::cos(0.02)), 1.);
    EXPECT_NEAR(energy({0., 0., 0.02}), 1e8 * (1. - std::cos(0.02)), 1.);
  }
}

TEST(Rod, PullsAndPushesByItsStiffness)
{
  const Joint joint = make_joint(rod({0.5, 0., 0.}, {10., 0., 0.}, 9.5, 1.0526e9),
                                 {point_at({}, true), point_at({10., 0., 0.}, true)}, 0, 3);
  std::array<Pose, 2> start{};
  start[1].position = {10., 0., 0.};
  for (const double stretch : {1e-3, -1e-3})
  {
    const Vector12 force =
        evaluate_joint(joint, start, {Vector6::Zero(), increment({stretch, 0., 0.}, Vector3d::Zero())}).force;
    EXPECT_NEAR(force[0], -1.0526e9 * stretch, 1e-3);
    EXPECT_NEAR(force[6], 1.0526e9 * stretch, 1e-3);
  }
}

TEST(JointForce, TurnsIntoTheResistanceOfItsPoints)
{
  for (const auto& [name, parameters] : every_joint())
  {
    const Joint joint = joint_of(parameters);
    const auto start = turned_poses();
    const Vector12 y = large_increments(0.7);
    const std::array<Pose, 2> poses = {start[0].moved(y.head<6>()), start[1].moved(y.tail<6>())};
    const JointForce on_first = joint_force(joint, poses);
    const Vector12 resistance = response_at(joint, poses, Vector12::Zero()).force;
    for (int i = 0; i < 2; ++i)
    {
      const double sense = i == 0 ? -1. : 1.;
      const Vector3d arm = poses[i].direction_to_world(joint.anchors[i]);
      Vector6 expected;
      expected << sense * on_first.force, sense * (on_first.couple + arm.cross(on_first.force));
      EXPECT_NEAR((resistance.segment<6>(6 * i) - expected).norm(), 0., 1e-12 * resistance.norm()) << name;
    }
    EXPECT_EQ(on_first.couple.norm() > 1e-6 * on_first.force.norm(), joint.rotational_stiffness > 0.) << name;
  }
}

TEST(JointForce, HingeHoldsATurnAcrossItsAxis)
{
  const Joint joint = make_joint(hinge({0.5, 0., 0.}, 1e9, 1e8), {point_at({}, true), point_at({}, true)}, 0, 3);
  std::array<Pose, 2> poses{};
  poses[1] = poses[1].moved(turn_about(poses[1], {0.5, 0., 0.}, {0.02, 0., 0.}));
  const JointForce on_first = joint_force(joint, poses);
  EXPECT_NEAR((on_first.couple - Vector3d(1e8 * std::sin(0.02), 0., 0.)).norm(), 0., 1e-4);
  EXPECT_NEAR(on_first.force.norm(), 0., 1e-4);
}

/// The stop of an AC-14 anchor: arm 0.131 m, limit 35 degrees.
struct AnchorStop
{
  static constexpr double arm = 0.131, stiffness = 8.5814e9;
  const Vector3d centre{0.489, 0., 0.};
  std::array<Pose, 2> start{};
  Joint joint =
      make_joint(stop({0.489, 0., 0.}, {0.62, 0., 0.}, 35., stiffness), {point_at({}, true), point_at({}, true)}, 0, 3);

  /// Distance of the anchors when the hinge is open by an angle, m.
  static double chord(const double angle) { return 2. * arm * std::sin(std::abs(angle) / 2.); }
  JointResponse opened(const double angle) const
  {
    return evaluate_joint(joint, start, {Vector6::Zero(), turn_about(start[1], centre, {0., angle, 0.})});
  }
};

TEST(Stop, IsSlackUpToItsAngleOnEitherSide)
{
  const AnchorStop anchor;
  for (const double side : {1., -1.})
  {
    EXPECT_EQ(anchor.opened(side * 34.97 * degree).force.norm(), 0.);
    EXPECT_GT(anchor.opened(side * 35. * degree).force.norm(), 0.);
  }
  EXPECT_EQ(anchor.opened(0.).tangent.norm(), 0.);
}

TEST(Stop, PullsByItsStiffnessBeyondItsAngle)
{
  const AnchorStop anchor;
  for (const double side : {1., -1.})
  {
    const double angle = side * 36. * degree;
    const double stretch = AnchorStop::chord(angle) - AnchorStop::chord(35. * degree);
    EXPECT_NEAR(anchor.opened(angle).force.head<3>().norm(), AnchorStop::stiffness * stretch,
                1e-9 * AnchorStop::stiffness * stretch);
  }
}

TEST(Stop, StiffnessIsContinuousAtTheLimit)
{
  const AnchorStop anchor;
  const double from = 34.9 * degree, to = 35.1 * degree;
  constexpr int n = 4000;
  Matrix12 last = anchor.opened(from).tangent;
  double largest_jump = 0.;
  for (int i = 1; i <= n; ++i)
  {
    const Matrix12 next = anchor.opened(from + (to - from) * i / n).tangent;
    largest_jump = std::max(largest_jump, (next - last).norm());
    last = next;
  }
  EXPECT_LT(largest_jump, 0.01 * last.norm());
}

TEST(Stop, UnequalArmsEncloseTheLimit)
{
  JointParameters parameters = stop({0., 0., 0.}, {0.2, 0., 0.}, 50., 1e6);
  parameters.position_2 = {0.4, 0., 0.};
  const Joint joint = make_joint(parameters, {point_at({}, true), point_at({}, true)}, 0, 3);
  const auto force = [&](const double angle)
  {
    return evaluate_joint(joint, {}, {Vector6::Zero(), increment(Vector3d::Zero(), {0., angle * degree, 0.})})
        .force.norm();
  };
  EXPECT_EQ(force(49.9), 0.);
  EXPECT_GT(force(50.1), 0.);
}
} // namespace
} // namespace kedge
