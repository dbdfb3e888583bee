// Bodies on joints, compared with known motions. Joints are as stiff as in the scenes: 1e9 N/m for masses of 1e3 kg.
#include "rigid_fixtures.h"

namespace kedge
{
namespace
{
using namespace test;
using Eigen::Vector3d;

/// A compound pendulum that swings about y through the origin.
struct Pendulum
{
  double mass, inertia, arm; ///< kg, kg m2 about the centre of mass, m

  double period() const { return 2. * M_PI * std::sqrt((inertia + mass * arm * arm) / (mass * gravity * arm)); }

  /// Hanging at `angle` (rad) from the vertical, on a held point.
  RigidSystems hung(const JointParameters& joint, const double angle, const unsigned int dim = 3) const
  {
    const double x = arm * std::sin(angle), z = -arm * std::cos(angle);
    return chain(
        {point_at({}, false, 0.), point_at(dim == 3 ? std::array<double, 3>{x, 0., z} : std::array<double, 3>{x, z, 0.},
                                           true, mass, {inertia, inertia, inertia})},
        {joint}, dim);
  }
};

const Pendulum shank{2116.7, 1350., 1.272}, fluke{6583.2, 1100., 0.131};
const JointParameters stiff_hinge = hinge({}, 1e9, 1e8);

/// Mean period over the crossings of the vertical in `n_steps`, s.
double measured_period(RigidSystems& systems, const RigidStep& step, const unsigned int n_steps)
{
  std::vector<double> crossings;
  double last = systems.points[1].pose.position[0];
  advance(systems, step, n_steps,
          [&](const double time)
          {
            const double x = systems.points[1].pose.position[0];
            if (last * x < 0.)
              crossings.push_back(time - step.dt * x / (x - last));
            last = x;
          });
  return 2. * (crossings.back() - crossings.front()) / (crossings.size() - 1.);
}

TEST(Pendulum, SwingsWithItsPeriod)
{
  EXPECT_NEAR(shank.period(), 2.6715, 1e-3);
  EXPECT_NEAR(fluke.period(), 2.3791, 1e-4);
  for (const Pendulum& pendulum : {shank, fluke})
    for (const double gamma : {0.5, 1.})
    {
      RigidSystems systems = pendulum.hung(stiff_hinge, 0.02);
      const RigidStep step = dynamic_step(0.02, gamma / 2., gamma);
      EXPECT_NEAR(measured_period(systems, step, 1000), pendulum.period(), 5e-3 * pendulum.period()) << gamma;
    }
}

TEST(Pendulum, SwingsInPlaneStrain)
{
  RigidSystems systems = shank.hung(ball({}, 1e9), 0.02, 2);
  EXPECT_EQ(free_dofs(systems).size(), 3u);
  EXPECT_NEAR(measured_period(systems, dynamic_step(0.02, 0.25, 0.5), 1000), shank.period(), 5e-3 * shank.period());
}

TEST(Pendulum, NeverGainsEnergy)
{
  RigidSystems systems = shank.hung(stiff_hinge, 1.5);
  const RigidStep step = dynamic_step(0.02, 0.5, 1.);
  const double start = energy(systems, step.gravity);
  double last = start;
  advance(systems, step, 500,
          [&](double)
          {
            const double now = energy(systems, step.gravity);
            EXPECT_LE(now, last + 1e-6 * std::abs(start));
            last = now;
          });
  EXPECT_LT(last, start);
}

TEST(Pendulum, NewtonNeedsFewIterations)
{
  // With gamma = 1/2, larger steps than these let the stiffest oscillation grow until it dominates.
  for (const auto& [gamma, dt] :
       {std::array{0.5, 0.005}, std::array{0.5, 0.02}, std::array{1., 0.005}, std::array{1., 0.08}})
  {
    RigidSystems systems = shank.hung(hinge({}, 1e10, 1e10), 1.5);
    EXPECT_LE(advance(systems, dynamic_step(dt, gamma / 2., gamma), std::lround(10. / dt)), 6u) << gamma << ' ' << dt;
  }
}

TEST(Pendulum, HangsStillAtEquilibrium)
{
  // Start where the relaxed hinge has no stiffness at all against a fall.
  for (const double angle : {0., 0.3, 1.5})
  {
    RigidSystems systems = shank.hung(stiff_hinge, angle);
    const RigidSolution solution = advance(systems, dynamic_step(0., 0.25, 0.5));
    EXPECT_NEAR(systems.points[1].pose.position[0], 0., 1e-7);
    EXPECT_NEAR(turned_about_y(systems.points[1]), angle, 1e-7);
    const double weight = shank.mass * gravity;
    EXPECT_NEAR(systems.points[1].pose.position[2], -shank.arm - weight / 1e9, 1e-9);
    const Vector6 reaction = rigid_reactions(systems, solution.balance, solution.increments)[0];
    EXPECT_NEAR((reaction - increment({0., 0., weight}, Vector3d::Zero())).norm(), 0., 1e-4 * weight);
  }
}

TEST(Pendulum, HangsFromAMovingPoint)
{
  RigidSystems systems = shank.hung(stiff_hinge, 0.);
  systems.points[0].conditions[0] = {DofCondition::Kind::prescribed, 0.1};
  systems.points[0].conditions[4] = {DofCondition::Kind::prescribed, 0.3}; // the hinge does not pass this on
  const RigidStep step = dynamic_step(0., 0.25, 0.5);
  Vector6 reaction;
  for (int i = 0; i < 10; ++i)
  {
    const RigidSolution solution = advance(systems, step);
    reaction = rigid_reactions(systems, solution.balance, solution.increments)[0];
  }
  EXPECT_NEAR(systems.points[1].pose.position[0], 1., 1e-7);
  EXPECT_NEAR(turned_about_y(systems.points[1]), 0., 1e-7);
  const double weight = shank.mass * gravity;
  EXPECT_NEAR((reaction - increment({0., 0., weight}, Vector3d::Zero())).norm(), 0., 1e-6 * weight);
}

TEST(Pendulum, HangsFromARodThatHoldsItByTensionAlone)
{
  // A relaxed rod is stiff along its own line only, and a taut one does not resist bodies that spin about it.
  RigidSystems systems =
      chain({point_at({}, false), point_at({0., 0., -1.}, true, 10.)}, {rod({}, {0., 0., -1.}, 1., 1e9)});
  const double x = 0.6; // of a length of 1: drawn upright, then moved aside
  systems.points[1].pose.position = {x, 0., -std::sqrt(1. - x * x)};
  systems.points[1].pose.rotation = rotation_from_vector({0., -std::asin(x), 0.});
  advance(systems, dynamic_step(0., 0.25, 0.5));
  // The error is at most the tolerance of the force over the stiffness, weight / length.
  EXPECT_NEAR((systems.points[1].pose.position - Vector3d(0., 0., -1. - 98.1e-9)).norm(), 0., 1e-7);
}

/// Angles and their rates of a plane double pendulum of compound bodies, by the classical Runge-Kutta method in
/// minimal coordinates (Lagrange's equations).
struct DoublePendulum
{
  Pendulum upper, lower;
  double length; ///< of the upper one, from pin to pin, m

  using State = Eigen::Vector4d; ///< angles from the vertical, rates
  State rate(const State& s) const
  {
    const double m1 = upper.mass, m2 = lower.mass, a1 = upper.arm, a2 = lower.arm, l = length;
    const double coupling = m2 * l * a2, c = std::cos(s[0] - s[1]), d = std::sin(s[0] - s[1]);
    Eigen::Matrix2d mass;
    mass << upper.inertia + m1 * a1 * a1 + m2 * l * l, coupling * c, coupling * c, lower.inertia + m2 * a2 * a2;
    const Eigen::Vector2d force(-coupling * d * s[3] * s[3] - (m1 * a1 + m2 * l) * gravity * std::sin(s[0]),
                                coupling * d * s[2] * s[2] - m2 * a2 * gravity * std::sin(s[1]));
    State result;
    result << s.tail<2>(), mass.inverse() * force;
    return result;
  }
  State integrate(State s, const double time, const unsigned int n_steps) const
  {
    const double h = time / n_steps;
    for (unsigned int i = 0; i < n_steps; ++i)
    {
      const State k1 = rate(s), k2 = rate(s + h / 2. * k1), k3 = rate(s + h / 2. * k2), k4 = rate(s + h * k3);
      s += h / 6. * (k1 + 2. * k2 + 2. * k3 + k4);
    }
    return s;
  }
};

/// Difference of the two angles (rad) from those of the reference after 2 s, in steps of dt.
double double_pendulum_error(const double dt)
{
  const DoublePendulum pendulum{shank, {800., 120., 0.6}, 2.};
  const DoublePendulum::State start(1., -0.5, 0., 0.);
  const DoublePendulum::State exact = pendulum.integrate(start, 2., 4000);

  const auto along = [](const double angle, const double length, const std::array<double, 3>& from) {
    return std::array<double, 3>{from[0] + length * std::sin(angle), 0., from[2] - length * std::cos(angle)};
  };
  const auto pin = along(start[0], pendulum.length, {});
  const double i1 = pendulum.upper.inertia, i2 = pendulum.lower.inertia;
  RigidSystems systems = chain(
      {point_at({}, false), point_at(along(start[0], pendulum.upper.arm, {}), true, pendulum.upper.mass, {i1, i1, i1}),
       point_at(along(start[1], pendulum.lower.arm, pin), true, pendulum.lower.mass, {i2, i2, i2})},
      {hinge({}, 1e9, 1e8), hinge(pin, 1e9, 1e8)});
  advance(systems, dynamic_step(dt, 0.25, 0.5), std::lround(2. / dt));
  // A turn about +y reduces the angle, which counts from -z towards +x.
  return std::hypot(start[0] - turned_about_y(systems.points[1]) - exact[0],
                    start[1] - turned_about_y(systems.points[2]) - exact[1]);
}

TEST(DoublePendulum, FollowsTheMinimalCoordinates)
{
  const double coarse = double_pendulum_error(0.01), fine = double_pendulum_error(0.005);
  EXPECT_LT(fine, 1e-3);
  EXPECT_NEAR(std::log2(coarse / fine), 2., 0.2);
}

TEST(Top, PrecessesByItsWeight)
{
  const double mass = 10., arm = 0.5, spin_inertia = 0.8, spin = 200.;
  PointParameters top = point_at({arm, 0., 0.}, true, mass, {spin_inertia, 0.5, 0.5});
  RigidSystems systems = chain({point_at({}, false), top}, {ball({}, 1e9)});
  // Steady precession of a top with a horizontal axis is exactly this fast.
  const double precession = mass * gravity * arm / (spin_inertia * spin);
  systems.points[1].velocity = increment({0., precession * arm, 0.}, {spin, 0., precession});
  RigidStep step = dynamic_step(5e-4, 0.5, 1.);
  advance(systems, step, 4000);
  const Vector3d axis = systems.points[1].pose.rotation * Vector3d::UnitX();
  EXPECT_NEAR(std::atan2(axis[1], axis[0]), 2. * precession, 0.01 * 2. * precession);
  EXPECT_NEAR(axis[2], 0., 0.01);
}

/// Two bodies that turn and fly apart on one joint; no weight.
RigidSystems tied_pair(const JointParameters& joint)
{
  RigidSystems systems = chain({point_at({-1., 0., 0.}, true, 1000., {300., 200., 100.}),
                                point_at({1., 0.2, 0.}, true, 500., {50., 100., 120.})},
                               {joint});
  systems.points[0].velocity = increment({0.3, 0.2, -0.5}, {0.5, 1., -0.3});
  systems.points[1].velocity = increment({-0.2, 0.4, 0.6}, {-0.8, 0.6, 0.4});
  return systems;
}

TEST(TiedBodies, KeepTheirMomentum)
{
  for (const JointParameters& joint :
       {ball({0., 0.1, 0.}, 1e5), hinge({0., 0.1, 0.}, 1e5, 1e5), rod({-0.5, 0., 0.2}, {0.7, 0., 0.}, 1.2, 1e5),
        stop({0., 0.1, 0.}, {0.4, 0.2, 0.}, 10., 1e5)})
  {
    const auto drift = [&](const double dt)
    {
      RigidSystems systems = tied_pair(joint);
      const Vector6 before = total_momentum(systems);
      advance(systems, dynamic_step(dt, 0.25, 0.5, 0.), std::lround(1. / dt));
      return Vector6(total_momentum(systems) - before);
    };
    const Vector6 coarse = drift(1e-3), fine = drift(5e-4);
    EXPECT_NEAR(coarse.head<3>().norm(), 0., 1e-9);
    // Newmark's method keeps the moment of the linear momenta about a fixed point only to its order.
    EXPECT_NEAR(std::log2(coarse.tail<3>().norm() / fine.tail<3>().norm()), 2., 0.2);
  }
}

/// Shank held, fluke free to swing on the hinge with its stop, as in an AC-14 anchor.
RigidSystems anchor()
{
  SystemParameters system;
  system.points = {point_at({1.7592, 0., 0.}, false, 1058.4),
                   point_at({0.62, 0., 0.}, true, 3291.6, {275., 275., 275.})};
  system.joints = {hinge({0.489, 0., 0.}, 1e9, 1e8), stop({0.489, 0., 0.}, {0.62, 0., 0.}, 35., 8.5814e9)};
  for (JointParameters& joint : system.joints)
    joint.points = {1, 2};
  return make_rigid_systems({system}, 3);
}

TEST(Anchor, FlukeFallsIntoItsStop)
{
  const double limit = 35. * M_PI / 180.;
  for (const double dt : {0.005, 0.04})
  {
    RigidSystems systems = anchor();
    double widest = 0.;
    const unsigned int iterations =
        advance(systems, dynamic_step(dt, 0.5, 1.), std::lround(8. / dt),
                [&](double) { widest = std::max(widest, turned_about_y(systems.points[1])); });
    EXPECT_LE(iterations, 8u);
    EXPECT_NEAR(turned_about_y(systems.points[1]), limit, 0.05 * M_PI / 180.);
    // Pin and stop act in series. They stretch at most until they hold the whole energy of the fall.
    const double fall = 3291.6 * gravity * 0.131 * std::sin(limit);
    const double stretch = std::sqrt(2. * fall * (1. / 1e9 + 1. / 8.5814e9));
    EXPECT_LT(widest, limit + stretch / (0.131 * std::cos(limit / 2.)));
  }
}

TEST(Anchor, FollowsThePullOfItsLine)
{
  using Kind = DofCondition::Kind;
  SystemParameters system;
  system.points = {point_at({0.62, 0., 0.}, true, 3291.6, {275., 275., 275.}),
                   point_at({1.7592, 0., 0.}, true, 1058.4, {337.5, 337.5, 337.5}),
                   point_at({12.5294, 0., 0.}, false, 1., {1e-6, 1e-6, 1e-6})};
  for (unsigned int point : {0, 1})
    for (unsigned int dof : {1, 3, 5}) // plane of symmetry
      system.points[point].conditions[dof].kind = Kind::fixed;
  system.points[2].conditions[0] = {Kind::prescribed, 0.008};
  system.joints = {hinge({0.489, 0., 0.}, 1e9, 1e8), stop({0.489, 0., 0.}, {0.62, 0., 0.}, 35., 8.5814e9),
                   rod({3.0294, 0., 0.}, {12.5294, 0., 0.}, 9.5, 1.0526e9)};
  system.joints[0].points = system.joints[1].points = {1, 2};
  system.joints[2].points = {2, 3};
  system.offset = {1., 0., 0.};
  RigidSystems systems = make_rigid_systems({system}, 3);
  systems.points[1].velocity[2] = 0.05; // a knock that turns line and hinge
  const double start = systems.points[0].pose.position[0], momentum_before = total_momentum(systems)[0];
  RigidStep step = dynamic_step(0.08, 0.5, 1.);
  step.gravity = {-gravity, 0., 0.}; // weight replaces the soil's resistance and keeps the line taut
  const double weight = (3291.6 + 1058.4 + 1.) * gravity;
  double impulse = 0.;
  for (int i = 0; i < 250; ++i)
  {
    const RigidSolution solution = solve_rigid_motion(systems, step);
    ASSERT_TRUE(solution.converged) << solution.failure;
    EXPECT_LE(solution.iterations, 8u);
    impulse += step.dt * (rigid_reactions(systems, solution.balance, solution.increments)[2][0] - weight);
    commit_increments(systems, step, solution.increments);
  }
  EXPECT_NEAR(systems.points[0].pose.position[0] - start, 250 * 0.008, 0.05);
  const double gained = total_momentum(systems)[0] - momentum_before;
  EXPECT_NEAR(impulse, gained, 1e-8 * weight * 250 * step.dt); // the solver's tolerance
}
} // namespace
} // namespace kedge
