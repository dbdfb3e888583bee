#include "pressed_block.h"
#include <gtest/gtest.h>

using namespace kedge;

/// Bodies that are in the soil from the start: their corners press only beyond where they began.
template <typename Dim> class BuriedBox : public testing::Test
{
};
using Dims = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(BuriedBox, Dims, test::DimensionName);

TYPED_TEST(BuriedBox, PushesOnlyBeyondItsFirstPlace)
{
  test::PressedBlock<TypeParam::value> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  block.evaluate_at_rest();
  EXPECT_EQ(block.load().norm(), 0.);
  EXPECT_EQ(block.contact.n_active(), 0);
  const auto rest = [](const auto&, unsigned int) { return 0.; };
  block.evaluate(rest, test::translation(0., 0., -1e-3));
  const double expected = block.n_corners() * block.normal_stiffness() * 1.25e-3; // the reference fades by a quarter
  EXPECT_NEAR(block.load()[2], expected, 1e-9 * expected);
}

TYPED_TEST(BuriedBox, FindsTheTrueSurfaceOnItsReturn)
{
  test::PressedBlock<TypeParam::value> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  const auto rest = [](const auto&, unsigned int) { return 0.; };
  for (const double lift : {1.5e-2, -0.5e-2}) // out to 5 mm of penetration, then back to 10 mm
  {
    block.evaluate(rest, test::translation(0., 0., lift));
    const double pressing = lift > 0. ? 0. : 1.25 * 5e-3; // the reference fades by a quarter of the distance
    const double expected = block.n_corners() * block.normal_stiffness() * pressing;
    EXPECT_NEAR(block.load()[2], expected, 1e-9 * block.n_corners() * block.normal_stiffness());
    block.contact.commit();
    block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::translation(0., 0., lift));
    block.find_pairs(0.1);
  }
}

/// Moves the box and the soil together.
template <int dim> void move_along(test::PressedBlock<dim>& block, const unsigned int axis, const double distance)
{
  Vector6 motion = Vector6::Zero();
  motion[world_axis(dim, axis)] = distance;
  block.evaluate([&](const auto&, const unsigned int d) { return d == axis ? distance : 0.; }, motion);
}

/// Else a shaft that slides along itself would squeeze the soil.
TYPED_TEST(BuriedBox, KeepsItsReferenceWhileItMovesAlongTheSurface)
{
  test::PressedBlock<TypeParam::value> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  move_along(block, 0, 1e-2);
  EXPECT_EQ(block.load().norm(), 0.);
}

TYPED_TEST(BuriedBox, MeetsTheSoilAsItMovesTowardsIt)
{
  constexpr int dim = TypeParam::value;
  test::PressedBlock<dim> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  move_along(block, dim - 1, -1e-2);
  const double expected = block.n_corners() * block.normal_stiffness() * 0.25 * 1e-2;
  EXPECT_NEAR(block.load()[2], expected, 1e-9 * expected);
  block.contact.commit();
  long long n_buried = 0;
  for (const ContactRecord& record : block.contact.export_history())
    if (record.reference_gap < 0.)
    {
      ++n_buried;
      EXPECT_NEAR(record.reference_gap, -2e-2 + 0.25 * 1e-2, 1e-9);
    }
  EXPECT_GT(sum_over_ranks(n_buried, MPI_COMM_WORLD), 0);
}

/// Else soil that springs back would drive a body that bounces.
TYPED_TEST(BuriedBox, DoesNotTakeBackOnItsReturnWhatHasFadedOnItsPath)
{
  test::PressedBlock<TypeParam::value> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  const double stiffness = block.n_corners() * block.normal_stiffness();
  const auto load_at = [&](const double lift)
  {
    block.evaluate([](const auto&, unsigned int) { return 0.; }, test::translation(0., 0., lift));
    block.contact.follow_path();
    return block.load()[2];
  };
  EXPECT_NEAR(load_at(-1e-3), 1.25e-3 * stiffness, 1e-12 * stiffness);
  EXPECT_NEAR(load_at(-0.5e-3), 0.75e-3 * stiffness, 1e-12 * stiffness);
  EXPECT_NEAR(load_at(-1e-3), 1.375e-3 * stiffness, 1e-12 * stiffness);
  block.contact.reset_multipliers();
  EXPECT_NEAR(load_at(-0.5e-3), 0.625e-3 * stiffness, 1e-12 * stiffness);
}

/// Else what its box does by chance takes the soil's support away, little by little.
TYPED_TEST(BuriedBox, ComesOffTheSurfaceAgainAsFarAsItHasBeen)
{
  constexpr int dim = TypeParam::value;
  test::PressedBlock<dim> block(0., -2e-2); // above the soil
  block.find_pairs(0.1);
  const double pressure = 1e-3 * block.normal_stiffness();
  for (const double farthest_off : {0., 1e-2, 5e-2})
  {
    std::vector<ContactRecord> records;
    for (const long long id : block.particles.ids())
      for (std::uint32_t corner = 0; corner < (1u << dim); ++corner)
        records.push_back({id, corner, 0, {0., 0., 0.}, 0., 0., 0, pressure, farthest_off});
    block.contact.import_history(records, block.particles.ids());
    block.find_pairs(0.1);
    block.evaluate_at_rest();
    // 20 mm off, less what presses; with nothing known hardly off
    const double expected = farthest_off > 2e-2 ? block.n_corners() * pressure : 0.;
    EXPECT_NEAR(block.load()[2], expected, 1e-9 * block.n_corners() * pressure) << farthest_off;
  }
  // it fades as the reference does
  move_along(block, dim - 1, -1e-3);
  block.contact.commit();
  for (const ContactRecord& record : block.contact.export_history())
    EXPECT_NEAR(record.farthest_off, 5e-2 - 0.25 * 1e-3, 1e-12);
}

/// Round-off must not choose which corners press at the start of a step: ranks would differ in it.
TYPED_TEST(BuriedBox, TouchesNothingWithinRoundOffOfItsReferences)
{
  test::PressedBlock<TypeParam::value> block(0.3, 4e-3);
  block.find_pairs();
  block.contact.take_reference_gaps(block.bodies);
  const auto active_after = [&](const double rise)
  {
    block.evaluate([&](const auto&, const unsigned int d) { return d == TypeParam::value - 1 ? rise : 0.; });
    return block.contact.n_active();
  };
  EXPECT_EQ(active_after(0.), 0);
  EXPECT_EQ(active_after(1e-13), 0);
  EXPECT_EQ(active_after(1e-8), block.n_corners());
}
