#include "pressed_block.h"
#include <gtest/gtest.h>

using namespace kedge;

/// Bodies that are in the soil from the start: their corners press only beyond where they began.
template <typename Dim> class BuriedBox : public testing::Test
{
};
using Dims = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(BuriedBox, Dims, test::DimensionName);

/// What a body that has come so far towards the soil, m, takes off the reference gaps that its burial has left.
double faded(const double approach)
{
  constexpr double slow = 0.1 * test::PressedBlock<3>::spacing;
  return 0.25 * (approach < slow ? 0.5 * approach * approach / slow : approach - 0.5 * slow);
}

/// Force on a box whose corners press by so much, N.
template <int dim> double force_of(const double pressing)
{
  using Block = test::PressedBlock<dim>;
  return Block::n_corners() * Block::normal_stiffness() * pressing;
}

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
  const double expected = force_of<TypeParam::value>(1e-3 + faded(1e-3));
  EXPECT_NEAR(block.load()[2], expected, 1e-9 * expected);
}

/// Else whatever trembles would press the soil harder and harder.
TYPED_TEST(BuriedBox, ComesBackToThePlaceThatItHasLeft)
{
  test::PressedBlock<TypeParam::value> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  const auto rest = [](const auto&, unsigned int) { return 0.; };
  struct Move
  {
    double lift, beyond; ///< m: of the first place
  };
  for (const auto& [lift, beyond] : {Move{1.5e-2, 0.}, Move{-1.6e-2, 1e-3}, Move{2.2e-2, 0.}, Move{-2.3e-2, 2e-3}})
  {
    block.evaluate(rest, test::translation(0., 0., lift));
    const double expected = force_of<TypeParam::value>(beyond + faded(beyond));
    EXPECT_NEAR(block.load()[2], expected, 1e-9 * force_of<TypeParam::value>(1.));
    block.contact.commit();
    block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::translation(0., 0., lift));
    block.find_pairs(0.1);
  }
}

TYPED_TEST(BuriedBox, FindsTheTrueSurfaceOnceItHasLeftItsPlaceFarBehind)
{
  test::PressedBlock<TypeParam::value> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  const auto rest = [](const auto&, unsigned int) { return 0.; };
  const double far = 0.11 * block.spacing;
  block.evaluate(rest, test::translation(0., 0., far));
  EXPECT_EQ(block.load().norm(), 0.);
  block.contact.commit();
  EXPECT_TRUE(block.contact.export_history().empty());
  block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::translation(0., 0., far));
  block.find_pairs(0.1);
  block.evaluate(rest, test::translation(0., 0., -far + 1.5e-2));
  EXPECT_NEAR(block.load()[2], force_of<TypeParam::value>(5e-3), 1e-9 * force_of<TypeParam::value>(1.));
}

/// Else corners deep inside would press as soon as they are a little less so.
TYPED_TEST(BuriedBox, StartsFromItsPlaceInsideOnceItHasLeftTheFirst)
{
  const double spacing = test::PressedBlock<TypeParam::value>::spacing;
  test::PressedBlock<TypeParam::value> block(0., 0.45 * spacing);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  const Vector6 lift = test::translation(0., 0., 0.12 * spacing);
  block.evaluate([](const auto&, unsigned int) { return 0.; }, lift);
  block.contact.commit();
  block.bodies.points[0].pose = block.bodies.points[0].pose.moved(lift);
  block.find_pairs(0.1);
  block.evaluate_at_rest();
  EXPECT_EQ(block.load().norm(), 0.);
  EXPECT_EQ(block.contact.n_active(), 0);
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
  const double expected = force_of<dim>(faded(1e-2));
  EXPECT_NEAR(block.load()[2], expected, 1e-9 * expected);
  block.contact.commit();
  long long n_buried = 0;
  for (const ContactRecord& record : block.contact.export_history())
    if (record.reference_gap < 0.)
    {
      ++n_buried;
      EXPECT_NEAR(record.reference_gap, -2e-2 + faded(1e-2), 1e-9);
    }
  EXPECT_GT(sum_over_ranks(n_buried, MPI_COMM_WORLD), 0);
}

/// Else each cycle of a body would press the soil harder.
TYPED_TEST(BuriedBox, FadesOnlyWhereItHasNotBeen)
{
  constexpr int dim = TypeParam::value;
  test::PressedBlock<dim> block(0., 2e-2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  double most = 0.;
  const auto load_at = [&](const double depth)
  {
    block.evaluate([](const auto&, unsigned int) { return 0.; }, test::translation(0., 0., -depth));
    block.contact.follow_path();
    most = std::max(most, depth);
    EXPECT_NEAR(block.load()[2], force_of<dim>(depth + faded(most)), 1e-9 * force_of<dim>(1e-3)) << depth;
  };
  for (const double depth : {1e-3, 5e-4, 1e-3, 5e-4, 2e-3, 5e-4})
    load_at(depth);
  // a step that is tried again knows nothing of the path, and the next one what has become of it
  block.contact.reset_multipliers();
  most = 0.;
  load_at(5e-4);
  load_at(2e-3);
  block.contact.commit();
  block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::translation(0., 0., -2e-3));
  for (const ContactRecord& record : block.contact.export_history())
    if (record.memory.farthest_in > 0.)
    {
      EXPECT_NEAR(record.memory.approach.now, 2e-3, 1e-12);
      EXPECT_NEAR(record.memory.farthest_in, 2e-2 - faded(2e-3), 1e-12);
    }
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
        records.push_back({id, corner, 0, {0., 0., 0.}, 0., 0., 0, pressure, {farthest_off}});
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
  {
    const BodyApproach& approach = record.memory.approach; // beside edges all motion counts alike
    EXPECT_NEAR(approach.most + approach.beside_edges, 1e-3, 1e-12);
    EXPECT_NEAR(record.memory.farthest_off, 5e-2 - faded(approach.most) - 0.25 * approach.beside_edges, 1e-12);
  }
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
