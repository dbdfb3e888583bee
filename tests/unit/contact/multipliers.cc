// Contact with multipliers at edges and vertices, and friction along a path.
#include "pressed_block.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
template <typename Dimension> class Multipliers : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  using Block = test::PressedBlock<dim>;

  /// A box whose lower edges are at a distance from the corners at (0.5, 1) m, off along a diagonal, with a multiplier
  /// at every corner that presses across the gap with 1 kN and more.
  struct BesideEdge : Block
  {
    BesideEdge(const double gap, const double friction)
        : Block(friction, -gap / std::sqrt(2.), 0.5 - gap / std::sqrt(2.))
    {
      ContactParameters parameters = Block::contact_parameters(friction);
      parameters.method = ContactMethod::augmented_lagrangian;
      this->contact = Contact<dim>(parameters, MPI_COMM_WORLD);
      std::vector<ContactRecord> records;
      for (const long long id : this->particles.ids())
        for (std::uint32_t corner = 0; corner < (1u << dim); ++corner)
          records.push_back({id, corner, 0, {0., 0., 0.}, 0., 1e3 + 2. * Block::normal_stiffness() * gap, 0});
      this->contact.import_history(records, this->particles.ids());
      this->find_pairs(0.1);
    }
  };

  /// Largest entry of any point's tangent over the normal stiffness.
  static double largest_tangent(const test::HostPointForces& points)
  {
    double largest = 0.;
    for (const double entry : points.tangent)
      largest = std::max(largest, std::abs(entry));
    return max_over_ranks(largest, MPI_COMM_WORLD) / Block::normal_stiffness();
  }

  static double wave(const std::array<double, dim>& x, const unsigned int d)
  {
    return std::sin(3. * x[0] + 2. * x[dim - 1] + d);
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Multipliers, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Multipliers, TangentsStayBoundedAtEdges)
{
  for (const double friction : {0., 0.5})
    for (const double gap : {1e-3, 1e-5, 1e-7, 1e-9})
    {
      typename TestFixture::BesideEdge block(gap, friction);
      const test::HostPointForces points = block.evaluate_at_rest();
      EXPECT_GT(block.contact.n_active(), 0) << gap;
      EXPECT_LE(this->largest_tangent(points), 1.5) << gap; // pressure/(stiffness gap) where the normal turns
    }
}

TYPED_TEST(Multipliers, TangentsAreThoseOfTheForcesBesideEdges)
{
  constexpr int dim = TypeParam::value;
  for (const double friction : {0., 0.5})
  {
    typename TestFixture::BesideEdge block(1e-7, friction);
    const test::HostPointForces first =
        block.evaluate([&](const auto& x, const unsigned int d) { return 1e-9 * this->wave(x, d); });
    constexpr double h = 1e-11;
    const test::HostPointForces second =
        block.evaluate([&](const auto& x, const unsigned int d) { return (1e-9 + h) * this->wave(x, d); });
    double worst = 0.;
    for (std::size_t i = 0; i < first.n_points(); ++i)
    {
      std::array<double, dim> u{};
      for (unsigned int v = first.begin[i]; v < first.begin[i + 1]; ++v)
        for (unsigned int d = 0; d < dim; ++d)
          u[d] += first.weights[v] * h * this->wave(block.node_position(first.nodes[v]), d);
      for (unsigned int d = 0; d < dim; ++d)
      {
        double expected = 0.;
        for (unsigned int e = 0; e < dim; ++e)
          expected += first.tangent[9 * i + 3 * d + e] * u[e];
        worst = std::max(worst, std::abs(second.force[3 * i + d] - first.force[3 * i + d] - expected));
      }
    }
    EXPECT_LT(worst, 1e-4 * h * block.normal_stiffness());
  }
}

TYPED_TEST(Multipliers, NewcomersKeepTheirForceAsThePlaneReplacesTheSurface)
{
  typename TestFixture::BesideEdge block(1e-3, 0.);
  block.contact.import_history({}, block.particles.ids());
  block.find_pairs(0.1);
  const auto press = [](const auto& x, const unsigned int d) { return d == TypeParam::value - 1 ? 3e-3 : 0.; };
  const test::HostPointForces springs = block.evaluate(press);
  block.contact.augment(1.);
  const test::HostPointForces doubled = block.evaluate(press);
  for (std::size_t i = 0; i < springs.force.size(); ++i)
    ASSERT_NEAR(doubled.force[i], 2. * springs.force[i], 1e-9 * block.normal_stiffness());
  block.contact.reset_multipliers();
  EXPECT_EQ(block.evaluate(press).force, springs.force);
}

TYPED_TEST(Multipliers, FrictionFollowsThePathWithinAStep)
{
  constexpr double depth = 1e-3, friction = 0.5;
  test::PressedBlock<TypeParam::value> block(friction, depth);
  block.find_pairs(0.1);
  const double limit = friction * block.n_corners() * block.normal_stiffness() * depth;
  const double elastic = friction * depth * block.normal_stiffness() / block.tangential_stiffness();
  const auto slide = [&](const double distance)
  {
    block.evaluate([&](const auto&, const unsigned int d) { return d == 0 ? distance : 0.; });
    block.contact.follow_path();
    return block.load()[0] / limit; // on the box
  };
  // the box drags on the soil against its motion, and the soil takes the box along
  EXPECT_NEAR(slide(0.5 * elastic), 0.5, 1e-6);
  EXPECT_NEAR(slide(4. * elastic), 1., 1e-6);
  EXPECT_NEAR(slide(3. * elastic), 0., 1e-6);
  EXPECT_NEAR(slide(0.), -1., 1e-6); // back where it began, and not as it began
  block.contact.reset_multipliers();
  EXPECT_NEAR(slide(0.5 * elastic), 0.5, 1e-6);
}
