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
    block.contact.inherit(split_particles(block.particles, block.mesh, 2u << times));
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
  EXPECT_NEAR(block.contact.deepest_penetration(), 1e-3, 1e-12);
}
