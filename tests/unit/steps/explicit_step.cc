// Explicit dynamics: momentum, energy, and where the time step becomes unstable.
#include "../bodies/shapes.h"
#include "free_block.h"
#include <kedge/steps/explicit_step.h>

using namespace kedge;

namespace
{
/// The free block in explicit basis steps of 2 ms.
struct Block : test::FreeBlock
{
  explicit Block(const double gravity) : FreeBlock(1e8, gravity, {0.25, 0.5, 0.})
  {
    stage.stepping.type = StageType::explicit_;
    stage.stepping.final_time = 1.;
    stage.stepping.basis_step = 2e-3;
  }

  NewtonReport advance()
  {
    ExplicitStep<3> problem(context());
    const NewtonReport report = problem.solve(load);
    reactions = problem.reactions();
    commit(problem);
    return report;
  }

  double kinetic_energy() const
  {
    return sum([](double m, const auto&, const auto& v, const auto&)
               { return Eigen::Vector3d(0.5 * m * v.squaredNorm(), 0., 0.); })[0];
  }

  std::vector<Vector6> reactions;
};

/// Velocities that stretch the block along x, bend it and turn it.
Eigen::Vector3d lively(const Eigen::Vector3d& x) { return {std::sin(3. * x[0]) + x[2], 0.5 * x[0] * x[0], 0.3 - x[0]}; }
} // namespace

TEST(Explicit, FreeFallIsExact)
{
  Block block(-9.81);
  const double start = block.centre()[2];
  const unsigned int n_steps = 20;
  for (unsigned int step = 0; step < n_steps; ++step)
    ASSERT_GT(block.advance().iterations, 1u);
  const double t = 2e-3 * n_steps;
  EXPECT_NEAR(block.momentum()[2] / block.mass(), -9.81 * t, 1e-12);
  EXPECT_NEAR(block.centre()[2] - start, -0.5 * 9.81 * t * t, 1e-12);
  for (const auto& particle : block.soil.particles().handler())
    ASSERT_NEAR(particle.get_properties()[field::acceleration + 2], -9.81, 1e-10);
}

TEST(Explicit, InternalForcesKeepMomentum)
{
  Block block(-9.81);
  block.load.gravity_factor = 0.;
  block.set_velocities(lively);
  const Eigen::Vector3d p = block.momentum();
  const double energy = block.kinetic_energy();
  for (unsigned int step = 0; step < 20; ++step)
    ASSERT_TRUE(block.advance().converged);
  EXPECT_LT((block.momentum() - p).norm(), 1e-12 * p.norm());
  EXPECT_LT(block.kinetic_energy(), energy); // some of it is elastic by now, some lost in the projection
  EXPECT_GT(block.kinetic_energy(), 0.1 * energy);
}

TEST(Explicit, MomentumIsTheImpulseOfContactAndWeight)
{
  Block block(-9.81);
  block.stage.rigid_bodies = true;
  block.bodies.points.emplace_back();
  block.bodies.points[0].pose.position = {1., 1., 1.};
  block.bodies.points[0].conditions.fill({DofCondition::Kind::fixed, 0.});
  block.bodies.points[0].conditions[2] = {DofCondition::Kind::prescribed, -1e-3};
  block.bodies.surfaces.push_back({Surface(test::box({-0.3, -0.3, 0.}, {0.3, 0.3, 0.5})), 0});
  for (unsigned int step = 0; step < 2; ++step)
    ASSERT_TRUE(block.advance().converged);
  const Eigen::Vector3d before = block.momentum();
  block.advance();
  const Eigen::Vector3d weight(0., 0., -9.81 * block.mass());
  ASSERT_GT(std::abs(block.reactions[0][2]), 10.);
  const Eigen::Vector3d impulse = 2e-3 * (block.reactions[0].head<3>() + weight);
  EXPECT_LT((block.momentum() - before - impulse).norm(), 1e-12 * impulse.norm());
}

/// Twice the mass, and the stable step grows by the root of two; a basis of boxes has a finite one wherever they are.
TEST(Explicit, StableStepGrowsWithMassAndHoldsForAnyPlaceOfTheBoxes)
{
  Block block(-9.81);
  const double at_rest = ExplicitStep<3>(block.context()).stable_step().all;
  block.stage.stepping.mass_scaling = 2.;
  EXPECT_NEAR(ExplicitStep<3>(block.context()).stable_step().all, std::sqrt(2.) * at_rest, 1e-12 * at_rest);
  block.stage.stepping.mass_scaling = 1.;

  double least = at_rest;
  for (unsigned int shift = 0; shift < 10; ++shift)
  {
    for (auto& particle : block.particles.edit())
    {
      auto x = particle.get_location();
      x[0] += 0.0113;
      particle.set_location(x);
    }
    block.particles.edit().sort_particles_into_subdomains_and_cells();
    least = std::min(least, ExplicitStep<3>(block.context()).stable_step().all);
  }
  EXPECT_GT(least, 0.7 * at_rest);
}

TEST(Explicit, ABodyOutOfReachLeavesTheStableStep)
{
  Block block(-9.81);
  const double alone = ExplicitStep<3>(block.context()).stable_step().all;
  block.stage.rigid_bodies = true;
  block.bodies.points.emplace_back();
  block.bodies.points[0].pose.position = {10., 10., 10.};
  block.bodies.points[0].conditions.fill({DofCondition::Kind::fixed, 0.});
  block.bodies.surfaces.push_back({Surface(test::box({-0.3, -0.3, 0.}, {0.3, 0.3, 0.5})), 0});
  EXPECT_DOUBLE_EQ(ExplicitStep<3>(block.context()).stable_step().all, alone);
}

/// Where many time steps follow, the stable one is found: it is safe, and gives away less than a tenth.
TEST(Explicit, StableStepIsWhereTheoryPutsIt)
{
  const auto grows = [](const double share, const double damping)
  {
    Block block(-9.81);
    block.stage.stepping.damping = damping;
    block.load.gravity_factor = 0.;
    block.set_velocities([](const Eigen::Vector3d& x) { return Eigen::Vector3d(1e-6 * lively(50. * x)); });
    block.stage.stepping.basis_step = 1.;
    ExplicitStep<3> step(block.context());
    block.stage.stepping.cfl = share; // a given "dt" would be cut to the critical one
    block.stage.stepping.basis_step = 600. * share * step.stable_step().all;
    const double energy = block.kinetic_energy();
    const NewtonReport report = step.solve(block.load);
    if (!report.converged)
      return true;
    block.commit(step);
    return block.kinetic_energy() > 1.5 * energy;
  };
  EXPECT_FALSE(grows(0.99, 0.));
  EXPECT_TRUE(grows(1.1, 0.));
  EXPECT_FALSE(grows(0.99, 0.8));
  EXPECT_TRUE(grows(1.1, 0.8));
}

TEST(Explicit, AGivenTimeStepAboveTheCriticalOneIsCut)
{
  Block block(-9.81);
  ExplicitStep<3> step(block.context());
  block.stage.stepping.basis_step = 10. * step.stable_step().all;
  for (const double dt_over_critical : {0.5, 5.})
  {
    block.stage.stepping.dt = dt_over_critical * step.stable_step().all;
    const NewtonReport report = step.solve(block.load);
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.iterations, dt_over_critical < 1. ? 20u : 10u);
  }
}

/// Neighbours that go opposite ways: no node sees it, no force acts on it, and it would last for good.
TEST(Explicit, VelocitiesThatNoNodeSeesFade)
{
  Block block(0.);
  const auto wave = [](const double x) { return std::sin(8. * M_PI * x); }; // +-1 at points 1/8 m apart
  block.set_velocities([&](const Eigen::Vector3d& x)
                       { return Eigen::Vector3d(0.01 * wave(x[0]) * wave(x[1]) * wave(x[2]), 0., 0.); });
  const double energy = block.kinetic_energy(), time_step = ExplicitStep<3>(block.context()).stable_step().all;
  const auto advance = [&](const double time_steps, const unsigned int basis_steps)
  {
    block.stage.stepping.basis_step = block.stage.stepping.cfl * time_step * time_steps;
    for (unsigned int step = 0; step < basis_steps; ++step)
      EXPECT_TRUE(block.advance().converged);
    return block.kinetic_energy();
  };
  const double later = advance(10., 10); // a hundred time steps take some tenth of the velocity
  EXPECT_GT(later, 0.7 * energy);
  EXPECT_LT(later, 0.9 * energy);
  const double at_last = advance(100., 9);
  EXPECT_GT(at_last, 0.05 * energy);
  EXPECT_LT(at_last, 0.25 * energy);
  EXPECT_LT(block.momentum().norm(), 1e-9 * std::sqrt(energy * block.mass()));
}

/// A stretch of soft soil, at its free edges too: no force acts to speak of, and each basis step sees the motion anew.
TEST(Explicit, LinearMotionLasts)
{
  Block block(0.);
  for (auto& particle : block.particles.edit())
    particle.get_properties()[field::young] = 1.;
  block.set_velocities([](const Eigen::Vector3d& x) { return Eigen::Vector3d(1e-3 * x[0], 0., 1e-3 * x[1]); });
  const double energy = block.kinetic_energy();
  block.stage.stepping.dt = block.stage.stepping.basis_step / 100.;
  for (unsigned int step = 0; step < 20; ++step)
    ASSERT_TRUE(block.advance().converged);
  EXPECT_NEAR(block.kinetic_energy(), energy, 1e-6 * energy);
}

TEST(Explicit, AStepThatGoesTooFarFails)
{
  Block block(-9.81);
  block.set_velocities([](const Eigen::Vector3d&) { return Eigen::Vector3d(120., 0., 0.); });
  const NewtonReport report = ExplicitStep<3>(block.context()).solve(block.load);
  EXPECT_FALSE(report.converged);
  EXPECT_NE(report.failure.find("of a cell"), std::string::npos) << report.failure;
}
