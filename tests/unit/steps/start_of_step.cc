// How a step starts: what it looks at, what it takes over, what it leaves.
#include "../bodies/shapes.h"
#include "free_block.h"
#include <kedge/base/exceptions.h>
#include <kedge/steps/step_basis.h>

using namespace kedge;

namespace
{
/// Soil of 10 by 6 cells of 0.2 m under its initial stress, with a block of 0.8 by 0.4 m wished in place in its middle.
struct BuriedBlock : test::StepFixture<2>
{
  BuriedBlock() : test::StepFixture<2>(layout(), test::layers_of({test::elastic_layer(1.2)}, 0.5))
  {
    const FaceCondition free = FaceCondition::free, roller = FaceCondition::roller, fixed = FaceCondition::fixed;
    gravity = {{0., -10., 0.}};
    solver.ghost_factor = 0.;
    solver.tolerance = 1e-9;
    stage.stepping.load = GravityLoad::full;
    stage.rigid_bodies = true;
    stage.boundary_conditions.min = {{roller, fixed}};
    stage.boundary_conditions.max = {{roller, free}};
    bodies.points.emplace_back();
    bodies.points[0].pose.position = {1., 0., 0.6};
    bodies.surfaces.push_back({Surface(test::box({-0.4, -50., -0.2}, {0.4, 50., 0.2})), 0});
    load.body_increments = {Vector6::Zero()};
  }

  static GridLayout<2> layout()
  {
    GridLayout<2> grid;
    grid.base_size = grid.finest_size = 0.2;
    grid.base_cells = {{10, 12}};
    grid.soil_extent = {{2., 1.2}};
    return grid;
  }

  /// Residuals of a step at rest, over the soil's weight.
  std::vector<double> rest(const bool replaces_soil)
  {
    StepContext<2> given = context();
    given.replaces_soil = replaces_soil;
    ImplicitStep<2> step(given);
    const NewtonReport report = step.solve(load);
    EXPECT_TRUE(report.converged) << report.failure;
    loads = step.body_loads();
    commit(step);
    return report.residuals;
  }

  StepLoad load;
  BodyLoads loads;
};
} // namespace

TEST(WishedInPlace, BodyCarriesWhatTheSoilHasCarriedThatItReplaces)
{
  BuriedBlock taken, empty;
  for (BuriedBlock* scene : {&taken, &empty})
    ASSERT_GT(scene->soil.remove_buried(scene->bodies), 0);
  const double without = empty.rest(false).front(), with = taken.rest(true).front();
  EXPECT_GT(without, 0.05);
  EXPECT_LT(with, 0.02 * without);
  // the weight of the soil replaced, 0.8 m x 0.4 m x 20 kN/m3, which holds the block down no more
  EXPECT_NEAR(taken.loads[0][2], 0.8 * 0.4 * 2e4, 0.02 * 0.8 * 0.4 * 2e4);
}

TEST(Guess, IsTakenWithoutALookAtRestWhereItIsMuchBetter)
{
  BuriedBlock block;
  block.solver.ghost_factor = SolverParameters().ghost_factor; // holds nodes with little soil, which the guess has too
  ASSERT_GT(block.soil.remove_buried(block.bodies), 0);
  block.rest(true);
  block.load.body_increments[0][2] = 1e-4;
  ImplicitStep<2> first(block.context());
  ASSERT_TRUE(first.solve(block.load).converged);
  const SoilIncrements solution = first.soil_increments(); // with the guess of the next step
  first.move_bodies(block.bodies);
  block.soil.commit(solution, &block.bodies);
  ImplicitStep<2> step(block.context());
  const NewtonReport looked = step.solve(block.load);
  const double at_guess = looked.residuals.front();
  ASSERT_LT(at_guess, looked.history.at_rest);

  block.load.history.at_rest = 20. * at_guess;
  const NewtonReport trusted = step.solve(block.load);
  EXPECT_EQ(trusted.residuals.front(), at_guess);
  EXPECT_DOUBLE_EQ(trusted.history.at_rest, 0.8 * block.load.history.at_rest); // what is remembered fades

  block.load.history.at_rest = 5. * at_guess;
  const NewtonReport doubted = step.solve(block.load);
  EXPECT_EQ(doubted.residuals.front(), at_guess);
  EXPECT_DOUBLE_EQ(doubted.history.at_rest, looked.history.at_rest);
}

TEST(StepBasis, RefusesAParticleWhoseCentreHasLeftTheGrid)
{
  BuriedBlock block; // whose box still reaches in
  for (auto& particle : block.particles.edit())
    if (dealii::Point<2> x = particle.get_location(); x[0] < 2. * particle.get_properties()[field::half_width])
    {
      x[0] = -0.1 * particle.get_properties()[field::half_width];
      particle.set_location(x);
    }
  StepContext<2> given = block.context();
  for (const Basis basis : {Basis::gimp, Basis::mpm})
  {
    given.basis = basis;
    EXPECT_THROW(make_step_basis(given, ghost_factors(given.solver), true), SolverError);
  }
}

TEST(Balance, IsReachedInParts)
{
  BuriedBlock block;
  block.stage.rigid_bodies = false;
  for (auto& particle : block.particles.edit())
    for (unsigned int i = 0; i < 6; ++i)
    {
      particle.get_properties()[field::stress + i] *= 1.01;
      particle.get_properties()[field::elastic_strain + i] *= 1.01;
    }
  block.load.share_balanced = 0.25;
  const double first = block.rest(false).front() / 0.25; // a quarter of what is out of balance counts
  block.load.share_balanced = 1.;
  EXPECT_NEAR(block.rest(false).front(), 0.75 * first, 0.01 * first);
  EXPECT_LT(block.rest(false).front(), 0.01 * first);
}

TEST(ContactSearch, KnowsThatTheSoilMoves)
{
  // a plate 0.4 m below a block that falls by 0.5 m in the step; particles of 0.125 m
  for (const double velocity : {0., -5.})
  {
    test::FreeBlock block(1e6, 0., {0.25, 0.5, 0.1});
    block.stage.stepping.dt = 0.1;
    block.stage.rigid_bodies = true;
    block.bodies.points.emplace_back();
    block.bodies.points[0].pose.position = {1., 1., 0.1};
    block.bodies.surfaces.push_back({Surface(test::box({-0.8, -0.8, -0.05}, {0.8, 0.8, 0.})), 0});
    block.set_velocities([&](const Eigen::Vector3d&) { return Eigen::Vector3d(0., 0., velocity); });
    ImplicitStep<3> step(block.context());
    EXPECT_EQ(block.contact.points_of_last_evaluation().n() > 0, velocity < 0.);
  }
}
