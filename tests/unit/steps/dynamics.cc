// Implicit dynamics of the soil: free motion is exact, momentum is kept, energy does not grow.
#include "../bodies/shapes.h"
#include "free_block.h"

using namespace kedge;
using test::FreeBlock;

namespace
{
class FreeFall : public testing::TestWithParam<std::tuple<bool, double, double>>
{
};
} // namespace

TEST_P(FreeFall, IsExact)
{
  const auto [lumped, beta, gamma] = GetParam();
  FreeBlock block(1e6, 9.81, {beta, gamma, 0.01}, lumped);
  block.load.begins_stage = true;
  const double start = block.centre()[2];
  const unsigned int n_steps = 12;
  for (unsigned int step = 0; step < n_steps; ++step)
    block.step();
  const double t = 0.01 * n_steps;
  EXPECT_NEAR(block.momentum()[2] / block.mass(), 9.81 * t, 1e-9 * 9.81 * t);
  EXPECT_NEAR(block.centre()[2] - start, 0.5 * 9.81 * t * t, 1e-9);
  const Eigen::Vector3d sideways = block.momentum() / block.mass();
  EXPECT_NEAR(sideways.head<2>().norm(), 0., 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Dynamics, FreeFall,
                         testing::Values(std::make_tuple(false, 0.25, 0.5), std::make_tuple(true, 0.25, 0.5),
                                         std::make_tuple(false, 0.5, 1.0)));

TEST(Dynamics, RigidMotionKeepsMomentumAndSpin)
{
  FreeBlock block(1e7, -9.81, {0.25, 0.5, 2e-3});
  block.load.begins_stage = true;
  const Eigen::Vector3d spin(0., 2., 0.), drift(1., 0., 0.5), pivot = block.centre();
  block.set_velocities([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(drift + spin.cross(x - pivot)); });
  const Eigen::Vector3d p = block.momentum(), l = block.angular_momentum();
  const unsigned int n_steps = 20;
  for (unsigned int step = 0; step < n_steps; ++step)
    block.step();
  const Eigen::Vector3d fallen(0., 0., -9.81 * block.mass() * n_steps * block.load.newmark.dt);
  EXPECT_LT((block.momentum() - p - fallen).norm(), 1e-8 * p.norm());
  const Eigen::Vector3d of_centre = block.centre().cross(block.momentum()) - pivot.cross(p);
  EXPECT_LT((block.angular_momentum() - of_centre - l).norm(), 1e-4 * (l - pivot.cross(p)).norm());
}

TEST(Dynamics, FreeBodiesFallExactlyFromTheirFirstStep)
{
  FreeBlock block(1e6, -9.81, {0.25, 0.5, 0.01});
  block.stage.stepping.beta = 0.25;
  block.stage.stepping.gamma = 0.5;
  block.stage.stepping.dt = 0.01;
  block.stage.rigid_bodies = true;
  block.bodies.points.emplace_back();
  RigidPoint& body = block.bodies.points[0];
  body.mass = 5.;
  body.conditions[2].kind = DofCondition::Kind::free;
  block.load.body_increments = {Vector6::Zero()};
  block.load.begins_stage = true;
  const unsigned int n_steps = 12;
  for (unsigned int step = 0; step < n_steps; ++step)
    block.step();
  const double t = 0.01 * n_steps;
  EXPECT_NEAR(body.velocity[2], -9.81 * t, 1e-9 * 9.81 * t);
  EXPECT_NEAR(body.pose.position[2], -0.5 * 9.81 * t * t, 1e-9);
}

TEST(Dynamics, MomentumBalancesContactAndWeight)
{
  FreeBlock block(1e6, -9.81, {0.25, 0.5, 1e-3});
  block.stage.rigid_bodies = true;
  block.bodies.points.emplace_back();
  block.bodies.points[0].pose.position = {1., 1., 1.};
  block.bodies.surfaces.push_back({Surface(test::box({-0.3, -0.3, 0.}, {0.3, 0.3, 0.5})), 0});
  Vector6 push = Vector6::Zero();
  push[2] = -2e-3;
  block.load.body_increments = {push};
  block.load.begins_stage = true;
  const double dt = block.load.newmark.dt, gamma = block.load.newmark.gamma;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (unsigned int step = 0; step < 3; ++step)
  {
    const Eigen::Vector3d start = block.momentum();
    block.step();
    const Eigen::Vector3d force = -block.loads[0].head<3>() + block.mass() * Eigen::Vector3d(0., 0., -9.81);
    ASSERT_GT(block.loads[0].head<3>().norm(), 1e2);
    const Eigen::Vector3d ma =
        block.sum([](double m, const auto&, const auto&, const auto& a) { return Eigen::Vector3d(m * a); });
    EXPECT_LT((ma - force).norm(), 1e-8 * force.norm()) << "step " << step;
    if (step > 0)
    {
      const Eigen::Vector3d impulse = dt * ((1. - gamma) * before + gamma * force);
      EXPECT_LT((block.momentum() - start - impulse).norm(), 1e-8 * impulse.norm()) << "step " << step;
    }
    before = force;
  }
}
