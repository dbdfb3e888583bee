// Explicit motion of rigid points: loads kick them, then they drift under their joints.
#include "rigid_fixtures.h"
#include <kedge/bodies/explicit_motion.h>

namespace kedge
{
namespace
{
using namespace test;
using Eigen::Vector3d;

const Vector3d down(0., 0., -gravity);

/// One step that consists of `n` small ones of length `dt`, under loads that depend on the positions of the points.
template <typename Loads>
void step_explicitly(RigidSystems& systems, const unsigned int n, const double dt, const Vector3d& weight,
                     const Loads& loads, const bool begins_stage = false)
{
  ExplicitMotion motion(systems, begins_stage);
  motion.kick(loads(motion.increments()), dt / 2.);
  for (unsigned int k = 1; k <= n; ++k)
  {
    ASSERT_EQ(motion.drift(weight, 1. / n, dt), "");
    motion.kick(loads(motion.increments()), k == n ? dt / 2. : dt);
  }
  motion.commit(systems, 1.);
}

BodyLoads none(const std::vector<Vector6>&) { return {}; }

TEST(ExplicitMotion, FallsAndSpinsExactly)
{
  RigidSystems systems = chain({point_at({1., 2., 3.}, true, 5., {1., 2., 3.})}, {});
  systems.points[0].velocity = increment({0.5, -1., 2.}, {0., 0., 7.}); // about the largest principal axis
  for (unsigned int i = 0; i < 10; ++i)
    step_explicitly(systems, 10, 0.01, down, none, i == 0);
  const RigidPoint& body = systems.points[0];
  EXPECT_NEAR((body.velocity.head<3>() - Vector3d(0.5, -1., 2. - gravity)).norm(), 0., 1e-11);
  EXPECT_NEAR((body.pose.position - Vector3d(1.5, 1., 5. - gravity / 2.)).norm(), 0., 1e-11);
  EXPECT_NEAR((body.reported_acceleration.head<3>() - down).norm(), 0., 1e-11);
  EXPECT_NEAR(body.pose.rotation.angularDistance(rotation_from_vector({0., 0., 7. - 2. * M_PI})), 0., 1e-10);
}

/// The accelerations before the stage must not matter.
TEST(ExplicitMotion, ATumblingBodyKeepsItsAngularMomentumFromTheFirstStepOn)
{
  RigidSystems systems = chain({point_at({}, true, 5., {1., 2., 3.})}, {});
  RigidPoint& body = systems.points[0];
  body.velocity = increment(Vector3d::Zero(), {0.4, 6., 0.3});
  body.acceleration = increment({1., 2., 3.}, {4., 5., 6.});
  const Vector6 before = momentum(body);
  step_explicitly(systems, 5, 0.02, Vector3d::Zero(), none, true);
  EXPECT_NEAR((momentum(body) - before).norm(), 0., 1e-9);
}

TEST(ExplicitMotion, PrescribedPointsMoveEvenlyAndAreNotKicked)
{
  RigidSystems systems = chain({point_at({}, false, 5.)}, {});
  systems.points[0].conditions[0] = {DofCondition::Kind::prescribed, 0.2};
  systems.points[0].conditions[5] = {DofCondition::Kind::prescribed, 0.3};
  const auto push = [](const std::vector<Vector6>&) { return BodyLoads{Vector6::Ones()}; };
  step_explicitly(systems, 4, 0.05, down, push);
  const RigidPoint& body = systems.points[0];
  EXPECT_NEAR((body.pose.position - Vector3d(0.2, 0., 0.)).norm(), 0., 1e-15);
  EXPECT_NEAR((vector_from_rotation(body.pose.rotation) - Vector3d(0., 0., 0.3)).norm(), 0., 1e-15);
  EXPECT_NEAR(body.velocity[0], 1., 1e-12);
  EXPECT_NEAR(body.last_increment[5], 0.3, 1e-12);
}

/// Velocity Verlet turns the phase of an oscillator by 2 asin(omega dt / 2) in a time step.
TEST(ExplicitMotion, ABodyOnASpringSwingsWithThePhaseOfVelocityVerlet)
{
  const double mass = 5., stiffness = 2000., omega = std::sqrt(stiffness / mass), dt = 1.2 / omega;
  RigidSystems systems = chain({point_at({0.1, 0., 0.}, true, mass)}, {});
  const unsigned int n_steps = 7, n = 3;
  for (unsigned int i = 0; i < n_steps; ++i)
  {
    const double x = systems.points[0].pose.position[0];
    const auto spring = [&](const std::vector<Vector6>& moved) {
      return BodyLoads{increment({-stiffness * (x + moved[0][0]), 0., 0.}, Vector3d::Zero())};
    };
    step_explicitly(systems, n, dt, Vector3d::Zero(), spring, i == 0);
  }
  const double phase = n_steps * n * 2. * std::asin(omega * dt / 2.);
  EXPECT_NEAR(systems.points[0].pose.position[0], 0.1 * std::cos(phase), 1e-10);
}

TEST(ExplicitMotion, ImpulsesTurnABodyAboutItsFreeAxesAlone)
{
  RigidSystems systems = chain({point_at({}, true, 2., {1., 2., 4.})}, {});
  RigidPoint& body = systems.points[0];
  body.pose.rotation = rotation_from_vector({0.3, -0.2, 0.4});
  const Vector6 before = momentum(body);
  const Vector6 impulse = increment({1., 2., 3.}, {0.1, -0.2, 0.3});
  apply_impulse(body, impulse);
  EXPECT_NEAR((momentum(body) - before - impulse).norm(), 0., 1e-14);

  body.velocity.setZero();
  body.conditions[3].kind = body.conditions[5].kind = DofCondition::Kind::fixed;
  apply_impulse(body, impulse);
  EXPECT_EQ(body.velocity[3], 0.);
  EXPECT_EQ(body.velocity[5], 0.);
  EXPECT_NEAR(body.velocity[4] * body.world_inertia()(1, 1), -0.2, 1e-15);
}

/// The hinge alone would allow time steps of 2e-3 s.
TEST(ExplicitMotion, APendulumSwingsOnAStiffHingeInLongSteps)
{
  const double mass = 2116.7, inertia = 1350., arm = 1.272, angle = 0.02, dt = 5e-3;
  const double period = 2. * M_PI * std::sqrt((inertia + mass * arm * arm) / (mass * gravity * arm));
  RigidSystems systems = chain({point_at({}, false, 0.), point_at({arm * std::sin(angle), 0., -arm * std::cos(angle)},
                                                                  true, mass, {inertia, inertia, inertia})},
                               {hinge({}, 1e9, 1e8)});
  std::vector<double> crossings;
  double last = systems.points[1].pose.position[0];
  for (unsigned int i = 0; i < 1500; ++i)
  {
    step_explicitly(systems, 1, dt, down, none, i == 0);
    const double x = systems.points[1].pose.position[0];
    if (last * x < 0.)
      crossings.push_back((i + 1) * dt - dt * x / (x - last));
    last = x;
  }
  ASSERT_GE(crossings.size(), 5u);
  const double measured = 2. * (crossings.back() - crossings.front()) / (crossings.size() - 1.);
  EXPECT_NEAR(measured, period, 5e-3 * period);
  const Vector3d pin = systems.points[1].pose.to_world({-arm * std::sin(angle), 0., arm * std::cos(angle)});
  EXPECT_LT(pin.norm(), 1e-3);
}

TEST(ExplicitMotion, OnlyTurningOnStiffJointsNeedsParts)
{
  const auto parts = [](const RigidSystems& systems, const double dt)
  { return ExplicitMotion(systems, false).count_parts(down, 1., dt); };
  RigidSystems hanging = chain({point_at({}, false), point_at({0., 0., -1.}, true, 2.)},
                               {rod({}, {0., 0., -1.}, 1. - 2. * gravity / 1e4, 1e4)});
  EXPECT_EQ(parts(hanging, 1e-3), 1u);
  hanging.points[1].velocity[2] = 1.; // along the rod
  EXPECT_EQ(parts(hanging, 1e-3), 1u);
  hanging.joints[0].stiffness = 1e9;
  hanging.joints[0].distance = 1.;
  hanging.points[1].velocity = increment({3., 0., 0.}, Vector3d::Zero());
  EXPECT_GT(parts(hanging, 1e-3), 4u);
  EXPECT_LT(parts(hanging, 1e-4), parts(hanging, 1e-3));
  hanging.points[1].conditions.fill({DofCondition::Kind::fixed, 0.});
  EXPECT_EQ(parts(hanging, 1e-3), 1u);
}

/// The rods alone would allow time steps of 3e-5 s. Without parts of drifts, or with kicks of gravity, the chain gains
/// thousands of times the energy that it has.
TEST(ExplicitMotion, AChainOfStiffRodsKeepsItsEnergyInLongSteps)
{
  constexpr unsigned int n = 4;
  std::vector<PointParameters> points{point_at({}, false)};
  std::vector<JointParameters> rods;
  for (unsigned int i = 0; i < n; ++i)
  {
    points.push_back(point_at({i + 1., 0., 0.}, true, 1., {1e-6, 1e-6, 1e-6}));
    rods.push_back(rod({i + 0., 0., 0.}, {i + 1., 0., 0.}, 1., 1e9));
  }
  RigidSystems systems = chain(points, rods);
  double lowest = 0.;
  for (unsigned int step = 0; step < 400; ++step)
  {
    step_explicitly(systems, 1, 5e-3, down, none, step == 0);
    double energy = 0., height = 0.;
    for (const RigidPoint& point : systems.points)
    {
      energy += 0.5 * momentum(point).dot(point.velocity) + point.mass * gravity * point.pose.position[2];
      height += point.pose.position[2];
    }
    lowest = std::min(lowest, height);
    EXPECT_NEAR(energy, 0., 1e-3 * n * gravity) << step;
  }
  EXPECT_LT(lowest, -n); // it has fallen
}
} // namespace
} // namespace kedge
