#include "pressed_block.h"
#include <gtest/gtest.h>

using namespace kedge;

template <typename Dim> class RepeatedContact : public testing::Test
{
};
using Dims = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(RepeatedContact, Dims, test::DimensionName);

/// Pairs that an evaluation leaves alone answer as if it had looked at them.
TYPED_TEST(RepeatedContact, ForgetsEarlierEvaluationsOfTheStep)
{
  constexpr int dim = TypeParam::value;
  test::PressedBlock<dim> block(0.3, -3e-2);
  block.find_pairs(0.3);
  struct Motion
  {
    double soil, box, turn;
  };
  // at rest, near, pressed at one end, far off, pressed everywhere, farther off, near again and pressed again
  for (const Motion motion : {Motion{0., 0., 0.},
                              {0., -0.02, 0.},
                              {0., -0.02, 0.04},
                              {-0.2, 0.1, 0.},
                              {0.01, -0.03, -0.02},
                              {-1., 3., 1.},
                              {0., -0.025, 0.},
                              {0., -0.035, 0.01}})
  {
    Vector6 step = test::translation(2e-3, 0., motion.box);
    step[4] = motion.turn;
    const auto field = [&](const auto& x, const unsigned int d)
    { return 1e-3 * std::sin(3. * x[0] + 5. * d) + (d == dim - 1 ? motion.soil : 0.); };
    test::PressedBlock<dim> fresh(0.3, -3e-2);
    fresh.find_pairs(0.3);
    const test::HostPointForces expected = fresh.evaluate(field, step);
    const test::HostPointForces points = block.evaluate(field, step);
    EXPECT_EQ(points.force, expected.force);
    EXPECT_EQ(points.tangent, expected.tangent);
    EXPECT_EQ(block.contact.n_active(), fresh.contact.n_active());
    RigidSystems moved = std::move(fresh.bodies);
    moved.points[0].pose = moved.points[0].pose.moved(step);
    EXPECT_EQ(block.contact.smallest_gaps(moved), fresh.contact.smallest_gaps(moved));
  }
  EXPECT_GT(block.contact.n_active(), 0);
}
