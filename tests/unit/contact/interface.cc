// Adhesion, bonded surfaces, and values that a surface has for itself.
#include "pressed_block.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
template <typename Dimension> class Interface : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Block = test::PressedBlock<dim>;

  /// A frictional interface with an adhesion of `adhesion` Pa.
  static InterfaceParameters adhesive(const double adhesion, const TangentialLimit limit, const bool bonded = false)
  {
    InterfaceParameters interface;
    interface.friction_coefficient = 0.5;
    interface.adhesion = adhesion;
    interface.tangential_limit = limit;
    interface.bonded = bonded;
    return interface;
  }

  /// The whole surface, which has the values of `interface` for itself.
  static void give(Block& block, const InterfaceParameters& interface)
  {
    block.bodies.surfaces[0].interface = interface;
    block.find_pairs(0.1);
  }

  /// Presses by what the block was made with, so that a bonded surface bonds.
  static void touch(Block& block)
  {
    block.evaluate_at_rest();
    block.contact.commit();
    block.find_pairs(0.1);
  }

  /// Soil that stays while the box is lifted by `height` beyond where it stands at first and moves along by `along`, m.
  static Vector6 lift(Block& block, const double height, const double along = 0.)
  {
    block.evaluate([](const auto&, unsigned int) { return 0.; }, test::translation(along, 0., height));
    return block.load();
  }

  /// Area that the corners under the box stand for, m2 (2-D: m).
  static double area() { return dim == 3 ? 100 * 0.25 * 0.25 * 0.25 : 10 * 0.5 * 0.25; }

  static void split(Block& block)
  {
    block.contact.inherit(split_particles(block.particles, block.mesh, 4), block.bodies);
    block.contact.follow_particles(block.particles.ids());
    block.find_pairs(0.1);
  }

  static double spring(const Block& block) { return block.n_corners() * block.normal_stiffness(); }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Interface, Dimensions, test::DimensionName);

constexpr double depth = 1e-3, far = 0.05;
} // namespace

TYPED_TEST(Interface, SlidesAtTheAdhesionTimesTheArea)
{
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller)); // 0.5 p = 50 kPa
  const double expected = 2e3 * this->area();
  EXPECT_NEAR(this->lift(block, 0., -far)[0], expected, 1e-9 * expected);
}

TYPED_TEST(Interface, SlidesAtTheFrictionBelowTheAdhesion)
{
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e5, TangentialLimit::smaller));
  const double expected = 0.5 * this->spring(block) * depth;
  EXPECT_NEAR(this->lift(block, 0., -far)[0], expected, 1e-9 * expected);
}

TYPED_TEST(Interface, SlidesAtTheSum)
{
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e5, TangentialLimit::sum));
  const double expected = 2e5 * this->area() + 0.5 * this->spring(block) * depth;
  EXPECT_NEAR(this->lift(block, 0., -far)[0], expected, 1e-9 * expected);
}

TYPED_TEST(Interface, AdhesionNeedsTouch)
{
  typename TestFixture::Block block(0.5, -1e-6);
  this->give(block, this->adhesive(2e5, TangentialLimit::sum));
  EXPECT_EQ(this->lift(block, 0., -far).norm(), 0.);
}

TYPED_TEST(Interface, IsThatOfAllSurfacesUnlessGiven)
{
  // values of "contact" for the whole box, then its own friction on top
  typename TestFixture::Block block(0.25, depth);
  InterfaceParameters none;
  this->give(block, none);
  const double pressure = this->spring(block) * depth;
  EXPECT_NEAR(this->lift(block, 0., -far)[0], 0.25 * pressure, 1e-9 * pressure);
  none.friction_coefficient = 0.1;
  this->give(block, none);
  EXPECT_NEAR(this->lift(block, 0., -far)[0], 0.1 * pressure, 1e-9 * pressure);
}

TYPED_TEST(Interface, DoesNotPullUnlessBonded)
{
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller));
  this->touch(block);
  EXPECT_EQ(this->lift(block, 3e-3).norm(), 0.);
}

TYPED_TEST(Interface, BondedSurfacePullsOnceItHasTouched)
{
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  EXPECT_EQ(this->lift(block, 3e-3).norm(), 0.); // it has never touched
  this->touch(block);
  const double expected = this->spring(block) * 2e-3;
  EXPECT_NEAR(this->lift(block, 3e-3)[2], -expected, 1e-9 * expected);
}

TYPED_TEST(Interface, BondedSurfaceSlidesAtTheAdhesionWhereItPulls)
{
  for (const TangentialLimit limit : {TangentialLimit::smaller, TangentialLimit::sum})
  {
    typename TestFixture::Block block(0.5, depth);
    this->give(block, this->adhesive(2e3, limit, true));
    this->touch(block);
    const double expected = 2e3 * std::pow(1.2, TypeParam::value - 1); // the face of the box, whatever corners carry
    EXPECT_NEAR(this->lift(block, 3e-3, -far)[0], expected, 1e-9 * expected);
  }
}

TYPED_TEST(Interface, BondedCornersKeepTheirNormalDuringAStep)
{
  // the ends of the box pass corners, which would be pulled askew
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  this->touch(block);
  const double expected = this->spring(block) * 2e-3;
  EXPECT_NEAR(this->lift(block, 3e-3, -0.2)[2], -expected, 1e-9 * expected);
}

TYPED_TEST(Interface, StaysBondedWhileItPulls)
{
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  this->touch(block);
  const Vector6 before = this->lift(block, 3e-3);
  block.contact.commit();
  block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::translation(0., 0., 3e-3));
  block.find_pairs(0.1);
  block.evaluate_at_rest();
  EXPECT_LT((block.load() - before).norm(), 1e-9 * before.norm());
}

TYPED_TEST(Interface, BuriedBoxIsBondedWhereItIs)
{
  // corners inside the box, and corners nearer than half a particle outside it
  for (const double first : {2e-2, -0.12})
  {
    typename TestFixture::Block block(0.5, first);
    this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
    block.contact.take_reference_gaps(block.bodies);
    EXPECT_EQ(this->lift(block, 0.).norm(), 0.);
    const double expected = this->spring(block) * 2e-3;
    EXPECT_NEAR(this->lift(block, 2e-3)[2], -expected, 1e-6 * expected);
    EXPECT_NEAR(this->lift(block, -2e-3)[2], expected, 1e-6 * expected);
  }
}

TYPED_TEST(Interface, BuriedBoxIsNotBondedFarther)
{
  typename TestFixture::Block block(0.5, -0.13);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  block.contact.take_reference_gaps(block.bodies);
  EXPECT_EQ(this->lift(block, 2e-3).norm(), 0.);
}

TYPED_TEST(Interface, BondOfABuriedBoxDoesNotFade)
{
  typename TestFixture::Block block(0.5, 2e-2);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  block.contact.take_reference_gaps(block.bodies);
  const Vector6 before = this->lift(block, 5e-3);
  block.contact.commit();
  block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::translation(0., 0., 5e-3));
  block.find_pairs(0.1);
  EXPECT_LT((this->lift(block, 0.) - before).norm(), 1e-9 * before.norm());
}

TYPED_TEST(Interface, SpringsTakeOverFromMultipliersOnceBonded)
{
  typename TestFixture::Block block(0.5, depth);
  ContactParameters parameters = TestFixture::Block::contact_parameters(0.);
  parameters.method = ContactMethod::augmented_lagrangian;
  parameters.interface.bonded = true;
  block.contact = std::decay_t<decltype(block.contact)>(parameters, MPI_COMM_WORLD);
  block.find_pairs(0.1);
  block.evaluate_at_rest();
  block.contact.augment(1.);
  this->touch(block); // with the force of two springs
  const double unit = this->spring(block) * depth;
  for (unsigned int round = 0; round < 2; ++round)
  {
    EXPECT_NEAR(this->lift(block, 0.)[2], 2. * unit, 1e-9 * unit);
    EXPECT_NEAR(this->lift(block, 4. * depth)[2], -2. * unit, 1e-9 * unit);
    EXPECT_EQ(block.contact.excess(), 0.);
    block.contact.augment(1.);
  }
}

TYPED_TEST(Interface, ActsOnTheSoilAsTheSoilActsOnABondedBox)
{
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e4, TangentialLimit::sum, true));
  this->touch(block);
  Vector6 step = test::translation(2e-3, dim == 3 ? 1e-3 : 0., 3e-3);
  step[4] = 1e-3; // one side pulls, the other presses
  block.evaluate([](const auto&, unsigned int) { return 0.; }, step);
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  const Eigen::Vector3d origin = block.bodies.points[0].pose.moved(step).position;
  for (const auto& touch : block.contact.touches())
  {
    force += touch.force;
    moment += (touch.position - origin).cross(touch.force);
  }
  Vector6 sum;
  sum << force, moment;
  for (int i = 0; i < 6; ++i)
    sum[i] = sum_over_ranks(sum[i], MPI_COMM_WORLD);
  const test::HostPointForces points(block.contact.points_of_last_evaluation());
  Eigen::Vector3d on_nodes = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.n_points(); ++i)
    for (unsigned int d = 0; d < dim; ++d)
      on_nodes[dim == 2 && d == 1 ? 2 : d] += points.force[3 * i + d];
  for (int d = 0; d < 3; ++d)
    on_nodes[d] = sum_over_ranks(on_nodes[d], MPI_COMM_WORLD);
  const Vector6 load = block.load();
  EXPECT_LT(load[2], 0.);
  EXPECT_LT((load + sum).norm(), 1e-10 * load.norm());
  EXPECT_LT((load.template head<3>() + on_nodes).norm(), 1e-10 * load.norm());
}

TYPED_TEST(Interface, BondGoesThroughPlainRecords)
{
  typename TestFixture::Block block(0.5, depth), other(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  this->touch(block);
  const Vector6 load = this->lift(block, 3e-3, 1e-4);
  std::vector<ContactRecord> records = gather_everywhere(block.contact.export_history(), MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) + 1 < size_of(MPI_COMM_WORLD)) // all records come from the last rank
    records.clear();
  other.contact.import_history(records, other.particles.ids());
  this->give(other, this->adhesive(2e3, TangentialLimit::smaller, true));
  EXPECT_LT(load[2], 0.);
  EXPECT_EQ(this->lift(other, 3e-3, 1e-4), load);
}

TYPED_TEST(Interface, BondSurvivesSplitting)
{
  // a box over the whole surface: every corner there is bonded before and after
  typename TestFixture::Block block(0.5, depth, 1.2);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  this->touch(block);
  this->lift(block, 3e-3);
  block.contact.commit();
  block.bodies.points[0].pose = block.bodies.points[0].pose.moved(test::translation(0., 0., 3e-3));
  this->split(block);
  block.evaluate_at_rest();
  EXPECT_EQ(block.contact.n_active(), TypeParam::value == 3 ? 4 * 16 * 16 : 2 * 16);
  for (const auto& touch : block.contact.touches())
  {
    EXPECT_NEAR(touch.position[2], 1., 1e-12); // none inside the parents
    EXPECT_GT(touch.force[2], 0.);
  }
}

TYPED_TEST(Interface, SplittingDoesNotBondBeyondTheBox)
{
  // its ends at 0.4 and 1.6 m lie between corners: those of the children beyond 0.5 and 1.5 m were never touched
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  this->touch(block);
  this->split(block);
  this->lift(block, 3e-3);
  EXPECT_GT(block.contact.n_active(), 0);
  for (const auto& touch : block.contact.touches())
    EXPECT_LT(std::abs(touch.position[0] - 1.), 0.5 + 1e-9);
}

TYPED_TEST(Interface, SplittingLeavesCornersThatAreNotBondedAtRest)
{
  // bonded at a distance: corners between bonded ones and free ones must not press there
  typename TestFixture::Block block(0.5, -0.12, 0.7);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  block.contact.take_reference_gaps(block.bodies);
  block.evaluate_at_rest();
  block.contact.commit();
  this->split(block);
  block.evaluate_at_rest();
  EXPECT_GT(block.contact.n_active(), 0);
  for (const auto& touch : block.contact.touches())
    EXPECT_LT(std::abs(touch.position[2] - 1.), 1e-12);
}

TYPED_TEST(Interface, SplittingDoesNotBondTheParentsCentre)
{
  // a parent with all its corners bonded
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0.5, depth);
  this->give(block, this->adhesive(2e3, TangentialLimit::smaller, true));
  std::vector<ContactRecord> records;
  if (!block.particles.ids().empty())
    for (std::uint32_t corner = 0; corner < 1u << dim; ++corner)
      records.push_back({block.particles.ids()[0], corner, 0, {0., 0., 0.}, 0., 0., 1});
  block.contact.import_history(records, block.particles.ids());
  block.contact.inherit(split_particles(block.particles, block.mesh, 4), block.bodies);
  constexpr std::uint32_t n = 1u << dim;
  long long bonded = 0;
  for (const ContactRecord& record : block.contact.export_history())
    bonded += record.bonded;
  const long long parents = sum_over_ranks(static_cast<long long>(!records.empty()), MPI_COMM_WORLD);
  EXPECT_EQ(sum_over_ranks(bonded, MPI_COMM_WORLD), parents * (n * n - n)); // one corner of each child lies there
}
