#include "pressed_block.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
/// A box that covers the whole surface has dragged the soil along, which sticks to it; then the particles are split.
template <typename Dimension> class SplitContact : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Block = test::PressedBlock<dim>;

  /// Splits every particle of the block, `times` over.
  static void split(Block& block, const unsigned int times = 1)
  {
    block.contact.commit();
    block.contact.inherit(split_particles(block.particles, block.mesh, 2u << times), block.bodies);
    block.contact.follow_particles(block.particles.ids());
    block.find_pairs();
    block.evaluate_at_rest();
  }

  /// Slip along x that grows along x, m.
  static double growing(const std::array<double, dim>& x, const unsigned int d) { return d == 0 ? 1e-4 * x[0] : 0.; }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(SplitContact, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(SplitContact, KeepsTheTangentialForceInSum)
{
  typename TestFixture::Block block(0.5, 1e-3, 1.2);
  block.find_pairs();
  block.evaluate(TestFixture::growing);
  const double before = block.load()[0];
  ASSERT_GT(before, 0.);
  TestFixture::split(block, 2);
  EXPECT_NEAR(block.load()[0], before, 1e-12 * before);
}

TYPED_TEST(SplitContact, KeepsALinearTractionAtEveryCorner)
{
  typename TestFixture::Block block(0.5, 1e-3, 1.2);
  block.find_pairs();
  block.evaluate(TestFixture::growing);
  TestFixture::split(block);
  const double force = block.tangential_stiffness() * 1e-4 / (TypeParam::value == 3 ? 4. : 2.); // per m of x
  ASSERT_EQ(block.contact.n_active(), TypeParam::value == 3 ? 4 * 16 * 16 : 2 * 16);
  for (const auto& touch : block.contact.touches())
    ASSERT_NEAR(touch.force[0], -force * touch.position[0], 1e-12 * force);
}

TYPED_TEST(SplitContact, KeepsABuriedBoxFromPushing)
{
  typename TestFixture::Block block(0., 2e-2, 0.7); // its ends press on children of corners that it does not reach
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  block.evaluate_at_rest();
  TestFixture::split(block);
  EXPECT_EQ(block.contact.n_active(), 0);
}

TYPED_TEST(SplitContact, DoesNotScaleReferenceGaps)
{
  typename TestFixture::Block block(0., 2e-2, 1.2);
  block.find_pairs(0.1);
  block.contact.take_reference_gaps(block.bodies);
  block.evaluate_at_rest();
  TestFixture::split(block);
  block.evaluate([](const auto&, unsigned int) { return 0.; }, test::translation(0., 0., -1e-3));
  EXPECT_NEAR(block.contact.deepest_penetration(), 1.25e-3, 1e-12); // it fades by a quarter of the distance
}

TYPED_TEST(SplitContact, HandsOnWhatReferencesGoBy)
{
  typename TestFixture::Block block(0., 1e-3, 1.2);
  block.find_pairs();
  block.evaluate_at_rest();
  block.contact.commit();
  std::vector<ContactRecord> records = block.contact.export_history();
  for (ContactRecord& record : records)
    record.memory = {7e-3, 6e-3, 0., {1e-3, 2e-3, -1e-3, 5e-3}};
  block.contact.import_history(records, block.particles.ids());
  block.find_pairs();
  block.evaluate_at_rest();
  TestFixture::split(block);
  long long n_pressing = 0;
  for (const ContactRecord& record : block.contact.export_history())
    if (record.pressure > 0.)
    {
      EXPECT_NEAR(record.memory.farthest_off, 7e-3, 1e-12);
      EXPECT_NEAR(record.memory.farthest_in, 6e-3, 1e-12);
      EXPECT_NEAR(record.memory.approach.now, 1e-3, 1e-12);
      EXPECT_NEAR(record.memory.approach.most, 2e-3, 1e-12);
      EXPECT_NEAR(record.memory.approach.least, -1e-3, 1e-12);
      EXPECT_NEAR(record.memory.approach.beside_edges, 5e-3, 1e-12);
      ++n_pressing;
    }
  EXPECT_GT(sum_over_ranks(n_pressing, MPI_COMM_WORLD), 0);
}

TYPED_TEST(SplitContact, KeepsTheNormalForceAndItsMoment)
{
  // a box that covers the surface, one whose ends lie between corners, a turned one
  for (const double half_length : {1.2, 0.6, 0.7})
    for (const unsigned int times : {1u, 2u})
    {
      typename TestFixture::Block block(0.5, 1e-3, half_length);
      if (half_length == 0.7)
        block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::tilt(1e-3));
      block.find_pairs();
      block.evaluate_at_rest();
      const Vector6 before = block.load();
      ASSERT_GT(before[2], 0.);
      TestFixture::split(block, times);
      EXPECT_NEAR(block.load()[2], before[2], 1e-12 * before[2]);
      EXPECT_LT((block.load() - before).norm(), (half_length == 0.7 ? 1e-2 : 1e-12) * before.norm());
    }
}

TYPED_TEST(SplitContact, KeepsMultipliersInSum)
{
  typename TestFixture::Block block(0., 1e-3, 1.2);
  ContactParameters parameters = TestFixture::Block::contact_parameters(0.);
  parameters.method = ContactMethod::augmented_lagrangian;
  block.contact = std::decay_t<decltype(block.contact)>(parameters, MPI_COMM_WORLD);
  block.find_pairs();
  block.evaluate_at_rest();
  block.contact.augment(1.);
  block.evaluate_at_rest();
  const double before = block.load()[2];
  TestFixture::split(block);
  EXPECT_NEAR(block.load()[2], before, 1e-12 * before);
}

TYPED_TEST(SplitContact, KeepsTheForceOfABondThatPulls)
{
  typename TestFixture::Block block(0.5, 1e-3, 1.2);
  block.bodies.surfaces[0].interface.bonded = true;
  block.find_pairs();
  block.evaluate_at_rest();
  block.contact.commit();
  block.find_pairs();
  const Vector6 rise = test::translation(0., 0., 3e-3);
  block.evaluate([](const auto&, unsigned int) { return 0.; }, rise);
  const double before = block.load()[2];
  ASSERT_LT(before, 0.);
  block.contact.commit();
  block.bodies.points[0].pose = block.bodies.points[0].pose.moved(rise);
  block.contact.inherit(split_particles(block.particles, block.mesh, 4), block.bodies);
  block.contact.follow_particles(block.particles.ids());
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_NEAR(block.load()[2], before, -1e-12 * before);
}

TYPED_TEST(SplitContact, LetsASharpBodyInsideAParticlePushNothingAtOnce)
{
  // a blade of 0.1 m between the corners of the parents, which lie 0.25 m apart, but over those of their children
  typename TestFixture::Block block(0., 0.01, 0.05);
  block.bodies.points[0].pose.position[0] = 1.125;
  block.find_pairs();
  block.evaluate_at_rest();
  ASSERT_EQ(block.contact.n_active(), 0);
  TestFixture::split(block);
  EXPECT_EQ(block.contact.n_active(), 0);
}

/// As without a split, soil in which a body begins is pressed out of it, by springs of half the size.
TYPED_TEST(SplitContact, BeforeTheFirstSearchTakesNoForceFromSoilInABody)
{
  typename TestFixture::Block whole(0., 0.01, 1.2), block(0., 0.01, 1.2);
  whole.find_pairs();
  whole.evaluate_at_rest();
  TestFixture::split(block);
  EXPECT_NEAR(block.load()[2], 2. * whole.load()[2], 1e-12 * whole.load()[2]);
}
