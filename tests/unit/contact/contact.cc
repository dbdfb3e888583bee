#include "pressed_block.h"
#include <gtest/gtest.h>
#include <set>

using namespace kedge;

namespace
{
template <typename Dimension> class PressedBox : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Block = test::PressedBlock<dim>;

  /// Soil that moves and stretches at random, by millimetres.
  static double shaken(const std::array<double, dim>& x, const unsigned int d)
  {
    return 5e-3 * (test::noise_at(x, dim, d) - 0.5);
  }

  /// World vector of nodal components.
  static Eigen::Vector3d to_world(const double* x)
  {
    return dim == 3 ? Eigen::Vector3d(x[0], x[1], x[dim - 1]) : Eigen::Vector3d(x[0], 0., x[1]);
  }
};

/// Over all ranks, those that are `expected`.
long long count_gaps(const std::unordered_map<long long, double>& gaps, const double expected)
{
  const long long here =
      std::count_if(gaps.begin(), gaps.end(),
                    [&](const auto& particle_and_gap) { return std::abs(particle_and_gap.second - expected) < 1e-12; });
  return sum_over_ranks(here, MPI_COMM_WORLD);
}

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(PressedBox, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(PressedBox, CarriesPenaltyTimesGapTimesTheNumberOfCorners)
{
  typename TestFixture::Block block(0., 1e-3);
  block.find_pairs();
  block.evaluate_at_rest();
  const double expected = block.n_corners() * block.normal_stiffness() * 1e-3;
  EXPECT_EQ(block.contact.n_active(), block.n_corners());
  EXPECT_NEAR(block.load()[2], expected, 1e-10 * expected);
  EXPECT_NEAR(block.load().head(2).norm(), 0., 1e-10 * expected);
  EXPECT_NEAR(block.load().tail(3).norm(), 0., 1e-10 * expected);
  EXPECT_NEAR(block.contact.deepest_penetration(), 1e-3, 1e-12);
  for (const auto& touch : block.contact.touches())
    EXPECT_NEAR(touch.force[2], -block.normal_stiffness() * 1e-3, 1e-8 * expected);
}

TYPED_TEST(PressedBox, FeelsNothingAboveTheSurface)
{
  typename TestFixture::Block block(0.5, -1e-6);
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_EQ(block.contact.n_active(), 0);
  EXPECT_EQ(block.load().norm(), 0.);
}

TYPED_TEST(PressedBox, MeetsTheSoilDuringTheStep)
{
  typename TestFixture::Block block(0., -1e-2);
  block.find_pairs(0.1);
  block.evaluate([](const auto&, const unsigned int d) { return d == TypeParam::value - 1 ? 5e-3 : 0.; },
                 test::translation(0., 0., -6e-3));
  const double expected = block.n_corners() * block.normal_stiffness() * 1e-3;
  EXPECT_NEAR(block.load()[2], expected, 1e-8 * expected);
}

TYPED_TEST(PressedBox, ActsOnTheSoilAsTheSoilActsOnIt)
{
  // forces and moments about the origin, with nodes and box where the increments have put them
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0.3, 4e-3);
  block.find_pairs();
  Vector6 step = test::translation(2e-3, dim == 3 ? 1e-3 : 0., -1e-3);
  step[4] = 1e-3;
  const test::HostPointForces points = block.evaluate(this->shaken, step);
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.n_points(); ++i)
    for (unsigned int n = points.begin[i]; n < points.begin[i + 1]; ++n)
    {
      const Eigen::Vector3d f = points.weights[n] * this->to_world(&points.force[3 * i]);
      const Eigen::Vector3d x = this->to_world(block.node_position(points.nodes[n]).data()) +
                                this->to_world(&block.increment[dim * points.nodes[n]]);
      force += f;
      moment += x.cross(f);
    }
  for (int d = 0; d < 3; ++d)
  {
    force[d] = sum_over_ranks(force[d], MPI_COMM_WORLD);
    moment[d] = sum_over_ranks(moment[d], MPI_COMM_WORLD);
  }
  const Vector6 load = block.load();
  const Eigen::Vector3d arm = block.bodies.points[0].pose.moved(step).position;
  const double scale = load.head<3>().norm();
  EXPECT_GT(scale, 0.);
  EXPECT_LT((force + load.head<3>()).norm(), 1e-10 * scale);
  EXPECT_LT((moment + load.tail<3>() + arm.cross(load.head<3>())).norm(), 1e-10 * scale);
}

TYPED_TEST(PressedBox, CornersMoveWithTheSoilAroundThem)
{
  // a linear field displaces corners as it displaces their places
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0., 5e-3);
  block.find_pairs();
  block.evaluate([](const std::array<double, dim>& x, const unsigned int d) { return d == 0 ? 1e-3 * x[0] : 0.; });
  long long wrong = 0;
  for (const auto& touch : block.contact.touches())
  {
    const double x = touch.position[0] / 1.001 / 0.25;
    wrong += std::abs(x - std::round(x)) > 1e-10 || std::abs(touch.position[2] - 1.) > 1e-12;
  }
  EXPECT_EQ(sum_over_ranks(wrong, MPI_COMM_WORLD), 0);
}

TYPED_TEST(PressedBox, SticksThenSlides)
{
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0.5, 1e-3);
  block.find_pairs();
  const auto slide = [](const double u)
  { return [u](const std::array<double, dim>&, const unsigned int d) { return d == 0 ? u : 0.; }; };
  block.evaluate(slide(0.4e-3)); // the cone is reached at 0.5 kN / kT = 1 mm
  EXPECT_NEAR(block.load()[0], block.n_corners() * block.tangential_stiffness() * 0.4e-3, 1e-4);
  block.evaluate(slide(3e-3));
  EXPECT_NEAR(block.load()[0], 0.5 * block.load()[2], 1e-10 * block.load()[2]);
}

TYPED_TEST(PressedBox, RemembersItsFriction)
{
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0.5, 1e-3);
  block.find_pairs();
  block.evaluate([](const auto&, const unsigned int d) { return d == 0 ? 0.4e-3 : 0.; });
  const Vector6 before = block.load();
  block.contact.commit();
  std::array<double, dim> step{};
  step[0] = 0.4e-3;
  block.move_everything(step, Vector6::Zero());
  block.contact.follow_particles(block.particles.ids());
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_LT((block.load() - before).head(3).norm(), 1e-9 * before.norm());
}

TYPED_TEST(PressedBox, ForgetsATrialThatWasNotCommitted)
{
  typename TestFixture::Block block(0.5, 1e-3);
  block.find_pairs();
  block.evaluate([](const auto&, const unsigned int d) { return d == 0 ? 0.4e-3 : 0.; });
  block.evaluate_at_rest();
  EXPECT_EQ(block.load()[0], 0.);
}

TYPED_TEST(PressedBox, FrictionFollowsParticlesFromRankToRank)
{
  // most of a cell to the right: the soil at the interfaces of ranks changes hands
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0.5, 1e-3);
  block.find_pairs();
  std::array<double, dim> step{};
  step[0] = 0.2;
  const Vector6 box_step = test::translation(0.2 - 0.4e-3, 0., 0.);
  block.evaluate([](const auto&, const unsigned int d) { return d == 0 ? 0.2 : 0.; }, box_step);
  const Vector6 before = block.load();
  EXPECT_NEAR(before[0], 0.2 * before[2], 1e-6 * before[2]);
  block.contact.commit();
  block.move_everything(step, box_step);
  block.particles.balance_load(1000.);
  block.contact.follow_particles(block.particles.ids());
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_EQ(block.contact.n_active(), block.n_corners());
  EXPECT_LT((block.load() - before).norm(), 1e-9 * before.norm());
}

TYPED_TEST(PressedBox, HistoryGoesThroughPlainRecords)
{
  typename TestFixture::Block block(0.5, 1e-3), other(0.5, 1e-3);
  block.find_pairs();
  block.evaluate([](const auto&, const unsigned int d) { return d == 0 ? 0.4e-3 : 0.; });
  block.contact.commit();
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_GT(block.load()[0], 1.);

  // all records come from the last rank
  std::vector<ContactRecord> records = gather_everywhere(block.contact.export_history(), MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) + 1 < size_of(MPI_COMM_WORLD))
    records.clear();
  other.contact.import_history(records, other.particles.ids());
  other.find_pairs();
  other.evaluate_at_rest();
  EXPECT_EQ(other.load(), block.load());
}

TYPED_TEST(PressedBox, StartsFromTheForcesOfTheLastStep)
{
  // the soil is compressed and turns, its boxes are not: their corners end up elsewhere than the soil
  constexpr int dim = TypeParam::value;
  typename TestFixture::Block block(0.3, 4e-3);
  block.find_pairs();
  const auto field = [](const std::array<double, dim>& x, const unsigned int d)
  { return d == dim - 1 ? -3e-3 * x[d] + 2e-3 * (x[0] - 1.) : 1e-3 * x[0]; };
  block.evaluate(field);
  const Vector6 before = block.load();
  ASSERT_GT(before[2], 0.);
  block.contact.commit();
  std::map<long long, std::array<double, dim>> places;
  for (std::size_t p = 0; p < block.particles.ids().size(); ++p)
    places[block.particles.ids()[p]] = block.particles.positions()[p];
  block.move([&](const long long id, const unsigned int d) { return field(places[id], d); });
  block.contact.follow_particles(block.particles.ids());
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_LT((block.load() - before).template head<3>().norm(), 1e-9 * before.norm());
}

TYPED_TEST(PressedBox, RemembersParticlesThatWaitOutsideTheWindow)
{
  typename TestFixture::Block block(0.5, 1e-3);
  block.find_pairs();
  block.evaluate([](const auto&, const unsigned int d) { return d == 0 ? 0.4e-3 : 0.; });
  block.contact.commit();
  const auto keys = [&]
  {
    std::multiset<long long> of_particles;
    for (const ContactRecord& record : block.contact.export_history())
      of_particles.insert(record.particle);
    return of_particles;
  };
  const auto before = keys();
  Window<TypeParam::value> window = block.mesh.leaves().window;
  const auto whole = window;
  window.upper[0] = 2; // half of the soil waits
  block.mesh.set_window(window);
  block.find_pairs();
  block.evaluate_at_rest();
  block.contact.commit();
  std::vector<long long> all;
  for (const auto& particle : block.particles.handler())
    all.push_back(particle.get_id());
  block.contact.follow_particles(all);
  EXPECT_EQ(keys(), before);
  block.mesh.set_window(whole);
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_EQ(block.contact.n_active(), block.n_corners());
}

TEST(PressedBoxInSpace, FrictionTurnsWithTheBox)
{
  // soil and box turn together about the vertical axis through the box's point
  test::PressedBlock<3> block(0.5, 1e-3);
  block.find_pairs();
  block.evaluate([](const auto&, const unsigned int d) { return d == 0 ? 0.4e-3 : 0.; });
  const Vector6 before = block.load();
  block.contact.commit();
  block.move_everything({{0.4e-3, 0., 0.}}, Vector6::Zero());
  block.contact.follow_particles(block.particles.ids());
  block.find_pairs();
  const double angle = 0.3;
  Vector6 turn = Vector6::Zero();
  turn[5] = angle;
  const Eigen::Matrix3d rotation = rotation_from_vector(turn.tail<3>()).toRotationMatrix();
  const auto turned = [&](const std::array<double, 3>& x, const unsigned int d)
  {
    const Eigen::Vector3d arm(x[0] - 1., x[1] - 1., 0.);
    return (rotation * arm - arm)[d];
  };
  block.evaluate(turned, turn);
  const Vector6 after = block.load();
  EXPECT_LT((after.head<3>() - rotation * before.head<3>()).norm(), 1e-9 * before.norm());
}

TYPED_TEST(PressedBox, MultipliersGrowByWhatTheSpringsTakeTimesAFactor)
{
  constexpr double depth = 1e-3;
  typename TestFixture::Block block(0., depth);
  ContactParameters parameters = TestFixture::Block::contact_parameters(0.);
  parameters.method = ContactMethod::augmented_lagrangian;
  parameters.penetration_tolerance = 1e-2;
  block.contact = std::decay_t<decltype(block.contact)>(parameters, MPI_COMM_WORLD);
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_NEAR(block.contact.excess(), depth / (1e-2 * 0.25), 1e-9);
  const double spring = block.n_corners() * block.normal_stiffness() * depth;
  for (const auto& [factor, springs] : {std::pair{1., 2.}, std::pair{4., 6.}})
  {
    block.contact.augment(factor);
    block.evaluate_at_rest();
    EXPECT_NEAR(block.load()[2], springs * spring, 1e-9 * spring);
  }
  const auto rest = [](const auto&, unsigned int) { return 0.; };
  block.evaluate(rest, test::translation(0., 0., 2. * depth)); // off by the depth: 5 springs press less one
  block.contact.augment(100.);                                 // a multiplier never pulls
  block.evaluate_at_rest();
  EXPECT_NEAR(block.load()[2], spring, 1e-9 * spring);
}

TYPED_TEST(PressedBox, TellsEachParticlesSmallestGap)
{
  typename TestFixture::Block block(0., 1e-3);
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_EQ(count_gaps(block.contact.smallest_gaps(block.bodies), -1e-3), TypeParam::value == 3 ? 36 : 6);
}

TYPED_TEST(PressedBox, TellsGapsOfParticlesThatDoNotTouch)
{
  typename TestFixture::Block block(0., -1e-3);
  block.find_pairs();
  block.evaluate_at_rest();
  EXPECT_EQ(block.contact.n_active(), 0);
  EXPECT_EQ(count_gaps(block.contact.smallest_gaps(block.bodies), 1e-3), TypeParam::value == 3 ? 36 : 6);
}

TYPED_TEST(PressedBox, CornersHangOnActiveNodesOnly)
{
  // Boxes that reach into the next cells by hairs along all axes: the share of the outermost cell is too small to
  // activate its nodes, but the corner lies in it.
  constexpr int dim = TypeParam::value;
  for (const double hair : {1e-9, 1e-6, 1e-4, 1e-3})
  {
    typename TestFixture::Block block(0., 1e-2);
    std::array<double, dim> step;
    step.fill(hair);
    block.move_everything(step, Vector6::Zero());
    block.find_pairs();
    const test::HostPointForces points = block.evaluate_at_rest();
    for (const unsigned int node : points.nodes)
      ASSERT_LT(node, block.nodes.n_local()) << "hair " << hair;
    for (std::size_t i = 0; i < points.n_points(); ++i)
    {
      double sum = 0.;
      for (unsigned int n = points.begin[i]; n < points.begin[i + 1]; ++n)
        sum += points.weights[n];
      ASSERT_NEAR(sum, 1., 1e-12);
    }
  }
}
