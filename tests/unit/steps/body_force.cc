// A body force acts as gravity of its size does, and its impulse is the integral of the input's function.
#include "free_block.h"
#include <kedge/base/exceptions.h>
#include <kedge/steps/explicit_step.h>

using namespace kedge;

namespace
{
constexpr double dt = 2e-3;

/// The free block under a body force, with or without gravity.
struct PulledBlock : test::FreeBlock
{
  PulledBlock(const StageType type, const std::vector<std::string>& components, const double vertical_gravity = 0.)
      : FreeBlock(1e7, vertical_gravity, {0.25, 0.5, type == StageType::dynamic ? dt : 0.}),
        force({components, {}, "domain.body force"})
  {
    stage.stepping.type = type;
    stage.stepping.final_time = 1.;
    stage.stepping.basis_step = stage.stepping.dt = dt;
    load.begins_stage = true;
    if (type == StageType::explicit_)
      stage.stepping.dt = 0.;
  }

  void advance(const unsigned int n_steps)
  {
    for (unsigned int i = 0; i < n_steps; ++i)
    {
      load.start_time = load.end_time;
      load.end_time += dt;
      StepContext<3> with_force = context();
      with_force.body_force = &force;
      const std::unique_ptr<TrialStep<3>> step = make(with_force);
      const NewtonReport report = step->solve(load);
      ASSERT_TRUE(report.converged) << report.failure;
      commit(*step);
    }
  }

  std::unique_ptr<TrialStep<3>> make(const StepContext<3>& with_force) const
  {
    if (stage.stepping.type == StageType::explicit_)
      return std::make_unique<ExplicitStep<3>>(with_force);
    return std::make_unique<ImplicitStep<3>>(with_force);
  }

  BodyForce<3> force;
};

class DynamicsOfBodyForces : public testing::TestWithParam<StageType>
{
};
} // namespace

TEST_P(DynamicsOfBodyForces, ConstantOnesAreGravity)
{
  PulledBlock pulled(GetParam(), {"1", "0", "-4"}), heavy(GetParam(), {"1", "0", "0"}, -4.);
  pulled.advance(8);
  heavy.advance(8);
  const double t = 8. * dt;
  const Eigen::Vector3d velocity = pulled.momentum() / pulled.mass();
  EXPECT_LT((velocity - t * Eigen::Vector3d(1., 0., -4.)).norm(), 1e-9 * t);
  EXPECT_LT((pulled.momentum() - heavy.momentum()).norm(), 1e-9 * pulled.momentum().norm());
  EXPECT_LT((pulled.centre() - heavy.centre()).norm(), 1e-9 * t * t);
}

TEST_P(DynamicsOfBodyForces, TheirImpulseIsTheIntegral)
{
  PulledBlock block(GetParam(), {"5e3 * t * X", "15e3 * t * X * Z", "-1e4 * t"});
  const Eigen::Vector3d rate =
      block.sum([](double m, const Eigen::Vector3d& x, const auto&, const auto&)
                { return Eigen::Vector3d(5e3 * m * Eigen::Vector3d(x[0], 3. * x[0] * x[2], -2.)); });
  block.advance(6);
  const double t = 6. * dt;
  EXPECT_LT((block.momentum() - 0.5 * t * t * rate).norm(), 1e-8 * 0.5 * t * t * rate.norm());
}

INSTANTIATE_TEST_SUITE_P(Dynamics, DynamicsOfBodyForces, testing::Values(StageType::dynamic, StageType::explicit_));

TEST(DynamicsOfBodyForce, StepsConvergeWhereItPassesThroughZeroAndAfterItHasEnded)
{
  // zero at the ends of the second and of all later steps
  PulledBlock block(StageType::dynamic, {"t < 0.0041 ? 1e3 * sin(pi * t / 0.004) : 0", "0", "0"});
  block.advance(4);
  EXPECT_GT(block.momentum()[0], 0.);
}

TEST(DynamicsOfBodyForce, ItPullsInFullWhereGravityIsRamped)
{
  PulledBlock block(StageType::explicit_, {"0", "0", "-1"}, -9.81);
  block.load.gravity_factor = 0.5;
  block.advance(4);
  EXPECT_NEAR(block.momentum()[2] / block.mass(), -(1. + 0.5 * 9.81) * 4. * dt, 1e-12);
}

TEST(DynamicsOfBodyForce, StaticStepsWithoutAnyLoadAreRefused)
{
  PulledBlock block(StageType::static_, {"0", "t - t", "0"});
  block.load.end_time = 1.;
  StepContext<3> context = block.context();
  context.body_force = &block.force;
  EXPECT_THROW(ImplicitStep<3>(context).solve(block.load), SolverError);
}

TEST(DynamicsOfBodyForce, StaticStepsBalanceIt)
{
  // A layer held at its base and its sides: the body force of gravity's size gives the settlement of gravity.
  const auto settle = [](const double vertical_gravity, const std::string& component)
  {
    test::StepFixture<3> layer(test::FreeBlock::layout(), test::layers_of({test::elastic_layer(1.)}), 10.);
    layer.gravity = {{0., 0., vertical_gravity}};
    layer.solver.tolerance = 1e-10;
    layer.solver.linear_solver = LinearSolverChoice::direct;
    layer.stage.stepping.type = StageType::static_;
    const FaceCondition roller = FaceCondition::roller;
    layer.stage.boundary_conditions.min = layer.stage.boundary_conditions.max = {{roller, roller, roller}};
    const BodyForce<3> force({{"0", "0", component}, {}, "domain.body force"});
    StepContext<3> context = layer.context();
    context.body_force = &force;
    StepLoad load;
    load.end_time = 0.5;
    ImplicitStep<3> step(context);
    EXPECT_TRUE(step.solve(load).converged);
    layer.commit(step);
    double sum = 0.;
    for (const auto& particle : layer.particles.handler())
      sum += particle.get_location()[2] - particle.get_properties()[field::initial_position + 2];
    return sum_over_ranks(sum, MPI_COMM_WORLD);
  };
  const double settlement = settle(-10., "0");
  EXPECT_LT(settlement, -1e-3);
  EXPECT_NEAR(settle(0., "-20 * t"), settlement, 1e-9 * std::abs(settlement));
}
