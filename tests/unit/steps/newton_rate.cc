// Newton's method keeps its rate through plasticity and frictional contact: every tangent is the exact one.
#include "../bodies/shapes.h"
#include "step_fixture.h"
#include <cmath>
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
/// Soil of 4 x 4 x 4 cells under its initial stress, and a box that is pushed into its surface in one step.
struct Footing : test::StepFixture<3>
{
  explicit Footing(const double friction, const MaterialParameters& material = sand())
      : test::StepFixture<3>(layout(), test::layers_of({{1., material}}, 0.5), 9.81, contact_parameters(friction))
  {
    gravity = {{0., 0., -9.81}};
    solver.tolerance = 1e-11; // of the weight; round-off is near 1e-12
    solver.ghost_factor = 0.;
    solver.linear_solver = LinearSolverChoice::direct;
    stage.rigid_bodies = true;
    const FaceCondition free = FaceCondition::free, roller = FaceCondition::roller, fixed = FaceCondition::fixed;
    stage.boundary_conditions.min = {{roller, roller, fixed}};
    stage.boundary_conditions.max = {{roller, roller, free}};

    bodies.points.emplace_back();
    bodies.points[0].pose.position = {0.5, 0.5, 1.};
    bodies.surfaces.push_back({Surface(test::box({-0.2, -0.2, 0.}, {0.2, 0.2, 1.})), 0});
  }

  static MaterialParameters sand()
  {
    MaterialParameters material;
    material.law = law_index<MohrCoulomb>;
    material.young = 1e7;
    material.poisson = 0.3;
    material.density = 2000.;
    // cohesion enough to keep away from the apex, whose tangent is stiffer than the exact one
    material.constants.values = {{"friction angle", 30.}, {"dilation angle", 10.}, {"cohesion", 1e4}};
    return material;
  }

  static GridLayout<3> layout()
  {
    GridLayout<3> grid;
    grid.base_size = grid.finest_size = 0.25;
    grid.base_cells = {{4, 4, 8}};
    grid.soil_extent = {{1., 1., 1.}};
    return grid;
  }

  static ContactParameters contact_parameters(const double friction)
  {
    ContactParameters parameters;
    parameters.interface.friction_coefficient = friction;
    parameters.normal_penalty_factor = 50.;
    parameters.tangential_penalty_factor = 25.;
    return parameters;
  }

  NewtonReport push(const Vector6& increment)
  {
    StepLoad load;
    load.body_increments = {increment};
    return ImplicitStep<3>(context()).solve(load);
  }

  long long count_yielding() const
  {
    const auto plastic = copy_to_host(particles.arrays().trial_plastic);
    long long n = 0;
    for (std::size_t p = 0; p < plastic.extent(0); ++p)
      n += plastic(p) > 1e-8;
    return n;
  }
};

Vector6 translation(const double x, const double y, const double z)
{
  Vector6 increment = Vector6::Zero();
  increment.head<3>() << x, y, z;
  return increment;
}

/// Once the sets of yielding particles and sliding corners have settled, each residual must be below a power of the
/// last, down to round-off.
void expect_quadratic(const NewtonReport& report)
{
  constexpr double settled = 1e-3, round_off = 1e-10;
  ASSERT_TRUE(report.converged) << report.failure;
  unsigned int compared = 0;
  for (std::size_t k = 0; k + 1 < report.residuals.size(); ++k)
    if (report.residuals[k] < settled)
    {
      ++compared;
      EXPECT_LT(report.residuals[k + 1], std::max(round_off, 10. * std::pow(report.residuals[k], 1.8))) << "step " << k;
    }
  EXPECT_GT(compared, 0u);
}
} // namespace

TEST(NewtonRate, IsQuadraticUnderASmoothFooting)
{
  Footing footing(0.);
  expect_quadratic(footing.push(translation(0., 0., -1e-2)));
  EXPECT_GT(footing.count_yielding(), 100);
  EXPECT_EQ(footing.contact.n_active(), 16);
}

TEST(NewtonRate, IsQuadraticUnderARoughFooting)
{
  Footing footing(0.3);
  expect_quadratic(footing.push(translation(0., 0., -1e-2)));
  EXPECT_GT(footing.count_yielding(), 100);
}

TEST(NewtonRate, IsQuadraticUnderAFootingThatDragsTheSoil)
{
  Footing footing(1.);
  expect_quadratic(footing.push(translation(1.5e-3, 5e-4, -3e-3)));
  EXPECT_GT(footing.count_yielding(), 20);
}

TEST(NewtonRate, IsQuadraticUnderAFootingThatSlides)
{
  Footing footing(0.3);
  expect_quadratic(footing.push(translation(1.5e-3, 5e-4, -3e-3)));
  EXPECT_GT(footing.count_yielding(), 20);
}

TEST(NewtonRate, IsQuadraticUnderAFreeFootingThatFallsAndTilts)
{
  MaterialParameters clay = Footing::sand();
  clay.law = law_index<VonMises>; // has no apex, which the impact would reach
  clay.constants.values = {{"yield stress", 3e4}};
  Footing footing(0.3, clay);
  RigidPoint& point = footing.bodies.points[0];
  point.mass = 2000.;
  point.inertia = {200., 300., 400.};
  point.conditions.fill({DofCondition::Kind::free, 0.});
  point.velocity << 0.15, 0.05, -1., 0.3, 0.2, 0.1;
  footing.stage.stepping.type = StageType::dynamic;
  footing.stage.stepping.dt = 0.01;
  StepLoad load;
  load.newmark = {footing.stage.stepping.beta, footing.stage.stepping.gamma, footing.stage.stepping.dt};
  load.body_increments = {Vector6::Zero()};
  ImplicitStep<3> step(footing.context());
  const NewtonReport report = step.solve(load);
  expect_quadratic(report);
  EXPECT_LT(step.rigid_increments()[0][2], -5e-3);
  EXPECT_GT(footing.count_yielding(), 20);
}
