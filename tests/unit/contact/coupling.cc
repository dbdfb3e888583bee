// Derivatives of contact forces and loads with respect to the bodies' motion, against central differences.
#include "pressed_block.h"
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/base/communication.h>
#include <tuple>

using namespace kedge;

namespace
{
template <typename Dimension> struct ContactCouplings : testing::Test
{
};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(ContactCouplings, Dimensions, test::DimensionName);

/// Some corners stick and others slide under this motion of the box, which tilts as it goes down.
template <int dim> Vector6 motion()
{
  Vector6 increment;
  increment << 2e-3, dim == 3 ? 1e-3 : 0., -4e-3, dim == 3 ? 1e-3 : 0., 2e-3, dim == 3 ? 3e-3 : 0.;
  return increment;
}

double wave(const unsigned int axis, const double x) { return 1e-3 * std::sin(3. * x + axis); }

template <int dim> struct Forces
{
  std::vector<double> on_soil; ///< by local dof
  Vector6 on_body;
};

template <int dim> Forces<dim> forces_at(test::PressedBlock<dim>& block, const Vector6& increment)
{
  const test::HostPointForces points =
      block.evaluate([](const auto& x, unsigned int d) { return wave(d, x[0]); }, increment);
  std::vector<double> on_soil(block.increment.size(), 0.);
  for (std::size_t i = 0; i < points.n_points(); ++i)
    for (unsigned int v = points.begin[i]; v < points.begin[i + 1]; ++v)
      for (unsigned int d = 0; d < dim; ++d)
        on_soil[dim * points.nodes[v] + d] += points.weights[v] * points.force[3 * i + d];
  return {on_soil, block.load()};
}

/// Gives the box a lower face that bends upwards about y, with a radius of twelve particles.
template <int dim> void bend_lower_face(test::PressedBlock<dim>& block)
{
  constexpr int n = 120;
  std::vector<std::array<double, 2>> outline;
  for (int i = 0; i <= n; ++i)
  {
    const double x = -0.6 + 1.2 * i / n;
    outline.push_back({x, x * x / 6.});
  }
  outline.push_back({0.6, 1.});
  outline.push_back({-0.6, 1.});
  block.bodies.surfaces[0].surface = Surface(extrude_outline(outline, "outline"));
}

/// By local dof, for a rate of the box.
struct Coupling
{
  std::vector<double> by_body, by_soil;
};

template <int dim> Coupling coupling_with(const test::PressedBlock<dim>& block, const Vector6& direction)
{
  const kedge::View<double*> by_body("by body", block.increment.size()), by_soil("by soil", block.increment.size());
  add_contact_coupling(dim, block.contact.arrays_of_last_evaluation(), block.contact.motions_of_last_evaluation(), 0,
                       direction, 1., by_body, by_soil);
  return {download(by_body), download(by_soil)};
}

/// A bonded box that has touched the soil and now tilts as it rises: one side pulls, the other presses.
template <int dim> Vector6 bond(test::PressedBlock<dim>& block, const TangentialLimit limit)
{
  InterfaceParameters& interface = block.bodies.surfaces[0].interface;
  interface.bonded = true;
  interface.adhesion = 2e4;
  interface.tangential_limit = limit;
  block.find_pairs(0.1);
  block.evaluate_at_rest();
  block.contact.commit();
  block.find_pairs(0.1);
  Vector6 rise = motion<dim>();
  rise[2] = 0.01;
  return rise;
}

template <int dim> void compare_by_the_body(test::PressedBlock<dim>& block, const Vector6& at)
{
  // rates of the increments are velocity and, through the tangent of the exponential map, spin
  Eigen::Matrix<double, 6, 6> map = Eigen::Matrix<double, 6, 6>::Identity();
  map.bottomRightCorner<3, 3>() = rotation_tangent(at.tail<3>());

  constexpr double h = 1e-7;
  for (unsigned int j = 0; j < 6; ++j)
  {
    if (dim == 2 && (j == 1 || j == 3 || j == 5))
      continue;
    Vector6 up = at, down = at;
    up[j] += h;
    down[j] -= h;
    const Forces<dim> high = forces_at<dim>(block, up), low = forces_at<dim>(block, down);
    forces_at<dim>(block, at);
    const std::vector<double> exact = coupling_with<dim>(block, map.col(j)).by_body;
    double size = 0., error = 0.;
    for (std::size_t i = 0; i < exact.size(); ++i)
    {
      const double difference = (high.on_soil[i] - low.on_soil[i]) / (2. * h);
      size = std::max(size, std::abs(difference));
      error = std::max(error, std::abs(difference - exact[i]));
    }
    EXPECT_LT(error, 1e-6 * std::max(size, 1.)) << "force, dof " << j;
    const Vector6 difference = (high.on_body - low.on_body) / (2. * h);
    EXPECT_LT((difference - (block.contact.load_tangents()[0] * map).col(j)).norm(), 1e-6 * difference.norm())
        << "dof " << j;
  }
}

template <int dim> void compare_by_the_soil(test::PressedBlock<dim>& block, const Vector6& at)
{
  const auto load_at = [&](const double share, const unsigned int axis)
  {
    block.evaluate(
        [&](const auto& x, unsigned int d) { return wave(d, x[0]) + (d == axis ? share * (1. + x[0]) : 0.); }, at);
    return block.load();
  };
  constexpr double h = 1e-7;
  for (unsigned int axis = 0; axis < dim; ++axis)
  {
    const Vector6 difference = (load_at(h, axis) - load_at(-h, axis)) / (2. * h);
    load_at(0., axis);
    Vector6 exact;
    for (unsigned int i = 0; i < 6; ++i)
    {
      const std::vector<double> row = coupling_with<dim>(block, Vector6::Unit(i)).by_soil;
      exact[i] = 0.;
      for (unsigned int v = 0; v < block.nodes.n_local(); ++v)
        exact[i] += row[dim * v + axis] * (1. + block.node_position(v)[0]);
      exact[i] = sum_over_ranks(exact[i], MPI_COMM_WORLD);
    }
    EXPECT_LT((difference - exact).norm(), 1e-6 * difference.norm()) << "axis " << axis;
  }
}
} // namespace

TYPED_TEST(ContactCouplings, AreTheDerivativesByTheBody)
{
  test::PressedBlock<TypeParam::value> block(0.4, 0.01);
  block.find_pairs(0.1);
  compare_by_the_body(block, motion<TypeParam::value>());
}

TYPED_TEST(ContactCouplings, AreTheDerivativesByTheBodyWhileReferencesFade)
{
  // below and above the surface, towards the soil and away from it; in the end with a surface that bends
  for (const auto& [compressed, share, bends] :
       {std::tuple(5e-3, 1., false), {2e-2, 1., false}, {2e-2, -0.2, false}, {2e-2, 1., true}})
  {
    const Vector6 at = share * motion<TypeParam::value>();
    test::PressedBlock<TypeParam::value> block(0.4, 0.01);
    if (bends)
      bend_lower_face(block);
    std::vector<ContactRecord> records;
    block.find_pairs(0.1);
    block.evaluate_at_rest();
    block.contact.commit();
    for (ContactRecord record : block.contact.export_history())
    {
      record.pressure = compressed * block.normal_stiffness();
      records.push_back(record);
    }
    block.contact.import_history(records, block.particles.ids());
    block.find_pairs(0.1);
    compare_by_the_body(block, at);
    compare_by_the_soil(block, at);
  }
}

TYPED_TEST(ContactCouplings, AreTheDerivativesByTheSoil)
{
  test::PressedBlock<TypeParam::value> block(0.4, 0.01);
  block.find_pairs(0.1);
  compare_by_the_soil(block, motion<TypeParam::value>());
}

TYPED_TEST(ContactCouplings, OfABondedBoxAreTheDerivatives)
{
  for (const auto& [limit, bends] :
       {std::pair(TangentialLimit::smaller, false), {TangentialLimit::sum, false}, {TangentialLimit::smaller, true}})
  {
    test::PressedBlock<TypeParam::value> block(0.4, bends ? 0.05 : 0.01);
    if (bends)
      bend_lower_face(block);
    Vector6 rise = bond(block, limit);
    rise[2] += bends ? 0.02 : 0.;
    compare_by_the_body(block, rise);
    compare_by_the_soil(block, rise);
    long long pulls = 0, presses = 0;
    for (const auto& touch : block.contact.touches())
      (touch.force[2] > 0. ? pulls : presses) += 1;
    EXPECT_GT(sum_over_ranks(pulls, MPI_COMM_WORLD), 0);
    EXPECT_GT(sum_over_ranks(presses, MPI_COMM_WORLD), 0);
  }
}
