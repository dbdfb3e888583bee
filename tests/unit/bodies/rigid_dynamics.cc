// Free bodies, tangents and reactions: all tests of the time integration that need no pendulum.
#include "rigid_fixtures.h"

namespace kedge
{
namespace
{
using namespace test;
using Eigen::Vector3d;

/// Newmark's parameters: average acceleration, those of the anchor scenes, and a pair off beta = gamma / 2.
const std::vector<std::array<double, 2>> newmark = {{0.25, 0.5}, {0.5, 1.}, {0.3025, 0.6}};

RigidSystems lone_body(const std::array<double, 3>& inertia, const Vector6& velocity)
{
  RigidSystems systems = chain({point_at({1., 2., 3.}, true, 5., inertia)}, {});
  systems.points[0].velocity = velocity;
  return systems;
}

TEST(RigidMotion, FreeFallIsExact)
{
  for (const auto& [beta, gamma] : newmark)
  {
    RigidSystems systems = lone_body({1., 2., 3.}, increment({0.5, -1., 2.}, Vector3d::Zero()));
    systems.points[0].acceleration[2] = -gravity;
    const RigidStep step = dynamic_step(0.01, beta, gamma);
    for (int i = 0; i < 100; ++i)
      advance(systems, step);
    EXPECT_NEAR((systems.points[0].velocity.head<3>() - Vector3d(0.5, -1., 2. - gravity)).norm(), 0., 1e-12);
    EXPECT_NEAR((systems.points[0].pose.position - Vector3d(1.5, 1., 5. - gravity / 2.)).norm(), 0., 1e-12) << beta;
  }
}

TEST(RigidMotion, SpinAboutAPrincipalAxisIsExact)
{
  for (const auto& [beta, gamma] : newmark)
  {
    RigidSystems systems = lone_body({1., 2., 3.}, Vector6::Zero());
    RigidPoint& body = systems.points[0];
    body.pose.rotation = rotation_from_vector({0.3, -0.4, 0.5});
    const Vector3d spin =
        body.pose.rotation * Vector3d(0., 0., 7.); // not about the middle axis, where the spin is unstable
    body.velocity.tail<3>() = spin;
    const Eigen::Quaterniond start = body.pose.rotation;
    for (int i = 0; i < 1000; ++i)
      advance(systems, dynamic_step(0.1, beta, gamma, 0.)); // 40 degrees a step, 111 turns
    EXPECT_NEAR(
        body.pose.rotation.angularDistance(rotation_from_vector(std::fmod(700., 2. * M_PI) / 7. * spin) * start), 0.,
        700. * 1e-11); // round-off of a thousand steps
    EXPECT_NEAR((body.velocity.tail<3>() - spin).norm(), 0., 1e-10);
  }
}

/// Orientation of a torque-free asymmetric body after 1 s, turning near its middle axis.
RigidPoint tumbled(const unsigned int n_steps, const double beta, const double gamma)
{
  const Vector3d spin(0.4, 6., 0.3);
  RigidSystems systems = lone_body({1., 2., 3.}, increment(Vector3d::Zero(), spin));
  RigidPoint& body = systems.points[0];
  // the acceleration that belongs to the spin
  const Vector3d own = body.inertia.cwiseProduct(spin);
  body.acceleration.tail<3>() = -spin.cross(own).cwiseQuotient(body.inertia);
  for (unsigned int i = 0; i < n_steps; ++i)
    advance(systems, dynamic_step(1. / n_steps, beta, gamma, 0.));
  return body;
}

TEST(RigidMotion, TumblingKeepsMomentumAndEnergy)
{
  const Vector3d momentum_before(0.4, 12., 0.9);
  const double energy_before = 0.5 * (0.4 * 0.4 + 2. * 36. + 3. * 0.09);
  for (const auto& [beta, gamma] : newmark)
  {
    const RigidPoint body = tumbled(50, beta, gamma);
    EXPECT_NEAR((momentum(body).tail<3>() - momentum_before).norm(), 0., 1e-7) << gamma; // the solver's tolerance
    if (beta == gamma / 2.)
    {
      EXPECT_NEAR(kinetic_energy(body), energy_before, 1e-7) << gamma;
    }
  }
}

TEST(RigidMotion, TumblingConvergesWithSecondOrder)
{
  for (const auto& [beta, gamma] : {newmark[0], newmark[1]})
  {
    const Eigen::Quaterniond exact = tumbled(3200, beta, gamma).pose.rotation;
    const double coarse = tumbled(100, beta, gamma).pose.rotation.angularDistance(exact),
                 fine = tumbled(200, beta, gamma).pose.rotation.angularDistance(exact);
    EXPECT_NEAR(std::log2(coarse / fine), 2., 0.05) << gamma;
  }
}

/// Three points with every kind of joint, moving, partly held, the last one driven.
RigidSystems mechanism()
{
  using Kind = DofCondition::Kind;
  std::vector<PointParameters> points = {point_at({0., 0., 0.}, true, 3., {1., 2., 3.}),
                                         point_at({1., 0.2, 0.1}, true, 2., {0.5, 0.3, 0.8}),
                                         point_at({2.5, 0., 0.4}, true, 1., {0.2, 0.2, 0.1})};
  points[0].conditions[3].kind = Kind::fixed;
  points[2].conditions[1] = {Kind::prescribed, 0.05};
  points[2].conditions[4] = {Kind::prescribed, -0.3};
  SystemParameters system;
  system.points = points;
  system.joints = {hinge({0.4, 0.1, 0.}, 1e3, 4e2), stop({0.4, 0.1, 0.}, {0.9, 0.3, 0.2}, 5., 6e2),
                   rod({1.3, 0., 0.}, {2.2, 0.1, 0.3}, 0.9, 8e2), ball({2., 0., 0.2}, 5e2)};
  system.joints[2].points = system.joints[3].points = {2, 3};
  RigidSystems systems = make_rigid_systems({system}, 3);
  for (unsigned int i = 0; i < 3; ++i)
  {
    RigidPoint& point = systems.points[i];
    point.pose.rotation = rotation_from_vector({0.1 * i, -0.2, 0.3});
    point.velocity = increment({0.5, -0.2, 0.1 * i}, {1., -2., 0.5});
    point.acceleration = increment({1., 2., -3.}, {0.4 * i, 2., 1.});
  }
  return systems;
}

TEST(RigidBalance, TangentIsTheDerivative)
{
  constexpr double h = 1e-5;
  const RigidSystems systems = mechanism();
  const std::vector<FreeDof> dofs = free_dofs(systems);
  ASSERT_EQ(dofs.size(), 15u);
  const BodyLoads loads(3, increment({1., 2., -3.}, {5., -4., 3.}));
  for (const double dt : {0., 0.1})
  {
    RigidStep step = dynamic_step(dt, 0.3, 0.7);
    std::vector<Vector6> increments = start_increments(systems, step);
    for (unsigned int i = 0; i < 3; ++i)
      increments[i] += increment({0.1, -0.05 * i, 0.2}, 0.5 * Vector3d(0.6, i == 1 ? 0.8 : 0., i == 1 ? 0. : 0.8));
    const RigidBalance balance = rigid_balance(systems, step, increments, loads);
    Eigen::MatrixXd differences(15, 15);
    for (unsigned int j = 0; j < dofs.size(); ++j)
    {
      std::vector<Vector6> ahead = increments, behind = increments;
      ahead[dofs[j].point][dofs[j].dof] += h;
      behind[dofs[j].point][dofs[j].dof] -= h;
      differences.col(j) =
          (rigid_balance(systems, step, ahead, loads).residual - rigid_balance(systems, step, behind, loads).residual) /
          (2. * h);
    }
    // Compare column by column, so that stiff joints do not hide the inertia of other bodies.
    for (unsigned int j = 0; j < dofs.size(); ++j)
      EXPECT_LT((balance.tangent.col(j) - differences.col(j)).norm(), 1e-6 * differences.col(j).norm())
          << j << ' ' << dt;
  }
}

TEST(RigidBalance, InertiaTangentOfALoneBodyIsTheDerivative)
{
  constexpr double h = 1e-5;
  RigidSystems systems = lone_body({1., 2., 3.}, increment({0.5, -1., 2.}, {3., -2., 1.}));
  systems.points[0].conditions[4].kind = DofCondition::Kind::fixed; // held and free rotations have different rates
  const RigidStep step = dynamic_step(0.1, 0.3, 0.7);
  for (const double angle : {0., 0.5, 1.2})
  {
    const Vector6 y = increment({0.1, 0.2, 0.3}, angle * Vector3d(0.6, 0., -0.8));
    const EndOfStep end = end_of_step(systems.points[0], step, y);
    Eigen::Matrix<double, 6, 6> differences;
    for (int i = 0; i < 6; ++i)
      differences.col(i) = (end_of_step(systems.points[0], step, y + h * Vector6::Unit(i)).momentum_rate -
                            end_of_step(systems.points[0], step, y - h * Vector6::Unit(i)).momentum_rate) /
                           (2. * h);
    EXPECT_LT((end.rate_tangent - differences).norm(), 1e-6 * differences.norm()) << angle;
  }
}

TEST(RigidBalance, LoadsActAboutTheMovedPoint)
{
  // A moment given in world axes turns a body about that axis, whatever the rotation of the step.
  RigidSystems systems = lone_body({2., 2., 2.}, increment(Vector3d::Zero(), {1., 0., 0.}));
  const BodyLoads loads = {increment({3., 0., 0.}, {0., 0.8, 0.})};
  const RigidStep step = dynamic_step(0.01, 0.5, 1., 0.);
  for (int i = 0; i < 100; ++i)
    advance(systems, step, loads);
  EXPECT_NEAR((momentum(systems.points[0]) - increment({3., 0., 0.}, {2., 0.8, 0.})).norm(), 0., 1e-9);
}

TEST(RigidBalance, ReactionsBalanceLoadsAndWeight)
{
  const RigidSystems systems = chain({point_at({}, false, 2.)}, {});
  RigidStep step = dynamic_step(0., 0.25, 0.5);
  const Vector6 load = increment({1., 2., 3.}, {4., 5., 6.});
  // The same if the point turns in the step: moments stay about world axes.
  const std::vector<Vector6> increments = {increment(Vector3d::Zero(), {0.5, -0.3, 0.8})};
  const Vector6 reaction = rigid_reactions(systems, rigid_balance(systems, step, increments, {load}), increments)[0];
  EXPECT_NEAR((reaction - increment({-1., -2., 2. * gravity - 3.}, {-4., -5., -6.})).norm(), 0., 1e-12);
}

TEST(RigidMotion, PrescribedMotionHasItsMeanVelocity)
{
  for (const auto& [beta, gamma] : newmark)
  {
    PointParameters parameters = point_at({}, false, 1000., {50., 50., 50.});
    parameters.conditions[0] = {DofCondition::Kind::prescribed, 0.008};
    parameters.conditions[4] = {DofCondition::Kind::prescribed, 0.016};
    RigidSystems systems = chain({parameters}, {});
    const RigidStep step = dynamic_step(0.08, beta, gamma, 0.);
    Vector6 reaction;
    for (int i = 0; i < 3; ++i)
    {
      const RigidSolution solution = solve_rigid_motion(systems, step);
      reaction = rigid_reactions(systems, solution.balance, solution.increments)[0];
      commit_increments(systems, step, solution.increments);
      EXPECT_NEAR((systems.points[0].velocity - increment({0.1, 0., 0.}, {0., 0.2, 0.})).norm(), 0., 1e-14);
    }
    EXPECT_NEAR(reaction.norm(), 0., 1e-9);
  }
}

TEST(RigidMotion, UnsupportedDofIsNamed)
{
  RigidStep step = dynamic_step(0., 0.25, 0.5);
  PointParameters slider = point_at({1., 0., 0.}, false);
  slider.conditions[1].kind = DofCondition::Kind::free;
  SystemParameters first, second;
  first.points = {point_at({}, false)};
  second.points = {point_at({}, false), slider};
  const RigidSystems loose = make_rigid_systems({first, second}, 3);
  const RigidSolution solution = solve_rigid_motion(loose, step, BodyLoads(3, Vector6::Ones()));
  EXPECT_FALSE(solution.converged);
  EXPECT_NE(solution.failure.find("point 2 of system 2, along y"), std::string::npos) << solution.failure;

  // A mechanism: the hinge lets the weightless body turn about y, although each of its dofs alone has stiffness.
  const RigidSystems hinged = chain({point_at({}, false), point_at({0.2, 0., 0.}, true, 0.)}, {hinge({}, 1e9, 1e8)});
  EXPECT_EQ(unsupported_dof(hinged, rigid_balance(hinged, step, start_increments(hinged, step))),
            "point 2 of system 1, about y");
}
} // namespace
} // namespace kedge
