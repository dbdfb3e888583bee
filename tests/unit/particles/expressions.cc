// Body force and initial velocity at the material points.
#include "soil_block.h"
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/particles/expressions.h>

using namespace kedge;
using test::SoilBlock;

TEST(BodyForces, FollowInitialAndPresentPlaceAndTime)
{
  SoilBlock<3> block;
  block.move([](long long id, unsigned int d) { return 0.01 * d + 1e-4 * (id % 7); });
  const BodyForce<3> force({{"X - x", "t * Y", "a * z"}, {{"a", "1 / (1 + t)"}}, "domain.body force"});
  EXPECT_TRUE(force.depends_on_time());
  const auto values = copy_to_host(force.evaluate(block.particles, 3., MPI_COMM_WORLD));
  const auto initial = block.particles.initial_positions();
  ASSERT_EQ(initial.size(), block.particles.ids().size());
  for (std::size_t p = 0; p < initial.size(); ++p)
  {
    EXPECT_NEAR(values(p, 0), -1e-4 * (block.particles.ids()[p] % 7), 1e-12);
    EXPECT_DOUBLE_EQ(values(p, 1), 3. * initial[p][1]);
    EXPECT_DOUBLE_EQ(values(p, 2), 0.25 * block.particles.positions()[p][2]);
  }
}

TEST(BodyForces, InThePlaneTheSecondComponentIsVertical)
{
  SoilBlock<2> block;
  const BodyForce<2> force({{"2 * X", "3 * Z + z"}, {}, "domain.body force"});
  EXPECT_FALSE(force.depends_on_time());
  const auto values = copy_to_host(force.evaluate(block.particles, 0., MPI_COMM_WORLD));
  const auto initial = block.particles.initial_positions();
  for (std::size_t p = 0; p < initial.size(); ++p)
  {
    EXPECT_DOUBLE_EQ(values(p, 0), 2. * initial[p][0]);
    EXPECT_DOUBLE_EQ(values(p, 1), 4. * initial[p][1]);
    EXPECT_EQ(values(p, 2), 0.);
  }
}

TEST(BodyForces, AllRanksHearOfAValueThatIsNotFinite)
{
  SoilBlock<2> block;
  const BodyForce<2> force({{"0", "X < 0.3 ? 1 / (t - t) : 0"}, {}, "domain.body force"});
  try
  {
    force.evaluate(block.particles, 0.5, MPI_COMM_WORLD);
    FAIL();
  }
  catch (const InputError& error)
  {
    EXPECT_EQ(error.path, "domain.body force.expression[1]");
    EXPECT_NE(std::string(error.what()).find("is inf at the material point that began at [0.125, "), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("t = 0.5"), std::string::npos);
  }
}

TEST(InitialVelocity, IsThatOfTheInitialPlace)
{
  SoilBlock<3> block;
  set_initial_velocity(block.particles, {{"X", "R", "-2 * Z"}, {{"R", "X + Y"}}, "v"}, MPI_COMM_WORLD);
  for (const auto& record : block.records())
  {
    const auto v = record.vector(field::velocity), X = record.vector(field::initial_position);
    EXPECT_LT((v - Eigen::Vector3d(X[0], X[0] + X[1], -2. * X[2])).norm(), 1e-14);
  }
  EXPECT_THROW(set_initial_velocity(block.particles, {{"1 / (X - X)", "0", "0"}, {}, "v"}, MPI_COMM_WORLD), InputError);
}
