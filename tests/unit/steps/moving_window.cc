// Soil wakes ahead of a dragged body, waits or vanishes behind it, and is held at the planes of the window.
#include "../bodies/shapes.h"
#include "step_fixture.h"
#include <gtest/gtest.h>
#include <set>

using namespace kedge;

namespace
{
/// A smooth blade, hard enough for elastic soil not to give way to it.
ContactParameters stiff_contact()
{
  ContactParameters parameters;
  parameters.normal_penalty_factor = 50.;
  parameters.tangential_penalty_factor = 25.;
  return parameters;
}

/// Elastic soil of 12 (by 2) by 2 cells of 0.5 m under its initial stress, and a blade across it, almost down to
/// mid-depth and clear of the soil below and behind, that is dragged along x.
template <int dim> struct Drag : test::StepFixture<dim>
{
  static constexpr double cell = 0.5;
  using Position = std::array<double, dim>;
  using test::StepFixture<dim>::bodies;
  using test::StepFixture<dim>::mesh;
  using test::StepFixture<dim>::particles;
  using test::StepFixture<dim>::soil;
  using test::StepFixture<dim>::stage;

  Drag() : test::StepFixture<dim>(layout(), test::layers_of({test::elastic_layer(1.)}, 1. / 3.), 10., stiff_contact())
  {
    const FaceCondition free = FaceCondition::free, roller = FaceCondition::roller, fixed = FaceCondition::fixed;
    this->gravity = {{0., dim == 3 ? 0. : -10., dim == 3 ? -10. : 0.}};
    this->solver.ghost_factor = 0.;
    stage.rigid_bodies = true;
    stage.boundary_conditions.min.fill(roller);
    stage.boundary_conditions.max.fill(roller);
    stage.boundary_conditions.min[dim - 1] = fixed;
    stage.boundary_conditions.max[dim - 1] = free;

    bodies.points.emplace_back();
    bodies.surfaces.push_back(
        {Surface(dim == 3 ? test::box({-0.25, -5., 0.}, {0.25, 6., 1.})
                          : extrude_outline({{-0.25, 0.}, {0.25, 0.}, {0.25, 1.}, {-0.25, 1.}}, "blade")),
         0});
    place(2.25);
    particles.remove_if(
        [](const auto& particle)
        {
          const dealii::Point<dim> x = particle.get_location();
          return x[0] > 1.5 && x[0] < 2.5 && x[dim - 1] > 0.5;
        });
  }

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(2);
    cells[0] = 12;
    cells[dim - 1] = 4;
    return test::make_brick<dim>(cells, cell, 0.5);
  }

  /// Middle of the blade along x, m.
  void place(const double x) { bodies.points[0].pose.position = {x, 0., 0.6}; }

  void ask_for_planes(const double behind, const double ahead, const bool remove)
  {
    stage.track.min[0] = {FaceCondition::fixed, behind, Advance::positive, remove};
    stage.track.max[0] = {FaceCondition::fixed, ahead, Advance::positive, false};
  }

  /// Returns the number of particles deleted.
  long long place_planes()
  {
    const long long before = soil.n_deleted();
    soil.place_window(bodies, stage.track);
    return soil.n_deleted() - before;
  }

  /// As before a step; returns the number of particles deleted.
  long long follow()
  {
    const long long before = soil.n_deleted();
    soil.move_window(bodies, stage.track);
    return soil.n_deleted() - before;
  }

  /// One step of the blade along x (m); returns the force on it (N).
  double drag(const double increment)
  {
    follow();
    ImplicitStep<dim> step(this->context());
    StepLoad load;
    load.body_increments = {Vector6::Zero()};
    load.body_increments[0][0] = increment;
    report = step.solve(load);
    n_dofs = step.n_dofs();
    largest_at_plane = largest_displacement_across(step.soil_increments().particles);
    const double force = step.body_loads()[0][0];
    this->commit(step);
    return force;
  }

  /// m, of the displacements of all particles with their domains against a plane, over all of them.
  double largest_displacement_across(const ParticleIncrements& increments) const
  {
    const auto gradient = copy_to_host(increments.deformation_gradient);
    const auto u = copy_to_host(increments.displacement);
    double largest = 0.;
    for (std::size_t p = 0; p < particles.ids().size(); ++p)
    {
      const double half = particles.half_widths()[p][0], x = particles.positions()[p][0];
      for (const auto& [plane, side] :
           {std::make_pair(mesh.leaves().lower_end(0), -1.), std::make_pair(mesh.leaves().upper_end(0), 1.)})
        if (std::abs(x + side * half - plane) < 1e-3)
          for (unsigned int d = 0; d < dim; ++d) // to the plane by the particle's gradient
            largest = std::max(largest, std::abs(u(p, d) + (gradient(p, 3 * d) - (d == 0 ? 1. : 0.)) * (plane - x)));
    }
    return max_over_ranks(largest, MPI_COMM_WORLD);
  }

  std::vector<Position> active_positions() const { return gather_everywhere(particles.positions(), MPI_COMM_WORLD); }

  NewtonReport report;
  long long n_dofs = 0;
  double largest_at_plane = 0.;
};

template <typename Dimension> class MovingWindow : public testing::Test, public Drag<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;
  /// In a column of cells without the blade.
  static constexpr long long per_column = dim == 3 ? 32 : 8;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(MovingWindow, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(MovingWindow, IsActiveExactlyBetweenItsPlanes)
{
  this->ask_for_planes(0.6, 1.2, false); // 1 m and 4 m, around the blade from 2 m to 2.5 m
  this->place_planes();
  std::set<double> columns;
  for (const auto& x : this->active_positions())
    columns.insert(std::floor(x[0] / this->cell));
  EXPECT_EQ(columns, (std::set<double>{2., 3., 4., 5., 6., 7.}));
}

TYPED_TEST(MovingWindow, WakesSoilAheadAndLetsSoilBehindWait)
{
  this->ask_for_planes(0.6, 1.2, false);
  this->place_planes();
  const std::size_t before = this->active_positions().size();
  const long long all = this->particles.n_global();
  this->place(3.25); // two columns leave, two come
  EXPECT_EQ(this->follow(), 0);
  EXPECT_EQ(this->active_positions().size(), before + this->per_column / 2); // half of a column that left is empty
  EXPECT_EQ(this->mesh.leaves().window.lower[0], 4u);
  EXPECT_EQ(this->particles.n_global(), all);
}

TYPED_TEST(MovingWindow, DeletesWhatARemovingPlaneHasPassed)
{
  this->ask_for_planes(0.6, 1.2, true);
  const long long all = this->particles.n_global();
  EXPECT_EQ(this->place_planes(), 2 * this->per_column);
  this->place(2.75);
  EXPECT_EQ(this->follow(), this->per_column);
  EXPECT_EQ(this->follow(), 0);
  EXPECT_EQ(this->particles.n_global(), all - 3 * this->per_column);
}

TYPED_TEST(MovingWindow, HoldsTheSoilAtFixedPlanes)
{
  this->ask_for_planes(0.1, 0.1, false);
  this->place_planes();
  this->drag(1e-3);
  EXPECT_TRUE(this->report.converged) << this->report.failure;
  EXPECT_LT(this->largest_at_plane, 1e-9);
}

TYPED_TEST(MovingWindow, LetsSoilSlideAlongARoller)
{
  this->ask_for_planes(0.1, 0.1, false);
  this->stage.track.max[0].type = FaceCondition::roller;
  this->place_planes();
  this->drag(1e-3);
  EXPECT_TRUE(this->report.converged) << this->report.failure;
  EXPECT_GT(this->largest_at_plane, 1e-6);
}

TYPED_TEST(MovingWindow, GivesUnknownsToActiveNodesAlone)
{
  this->ask_for_planes(0.6, 1.2, false);
  this->place_planes();
  this->drag(1e-4);
  EXPECT_EQ(this->n_dofs,
            TypeParam::value == 3 ? 3 * 60 : 2 * 20); // one column of 7 (by 3) nodes is without soil on top
}

TYPED_TEST(MovingWindow, HardlyChangesTheReactionWhenItsPlanesAreFar)
{
  Drag<TypeParam::value> without;
  this->ask_for_planes(1.0005, 2.4995, true); // 0.5 m and 5 m of 6 m, after the first step 1 m and 5.5 m
  this->place_planes();
  double force = 0., expected = 0.;
  for (unsigned int step = 0; step < 2; ++step)
  {
    force = this->drag(1e-3);
    expected = without.drag(1e-3);
    ASSERT_TRUE(this->report.converged && without.report.converged);
  }
  EXPECT_EQ(this->mesh.leaves().window.upper[0], 11u);
  EXPECT_LT(expected, 0.);
  EXPECT_NEAR(force, expected, 0.01 * std::abs(expected));
}

TYPED_TEST(MovingWindow, GivesTheSameReactionOnAnyNumberOfRanksAsItMoves)
{
  this->ask_for_planes(0.502, 0.998, true); // both move by a cell after three steps
  this->place_planes();
  const auto first = this->mesh.leaves().window;
  double force = 0.;
  for (unsigned int step = 0; step < 5; ++step)
  {
    force = this->drag(1e-3);
    ASSERT_TRUE(this->report.converged) << this->report.failure;
  }
  EXPECT_EQ(this->mesh.leaves().window.lower[0], first.lower[0] + 1);
  EXPECT_EQ(this->mesh.leaves().window.upper[0], first.upper[0] + 1);
  constexpr double on_one_rank = -40924.676473986; // N, in 2-D per metre: the block of the 3-D case is 1 m wide
  EXPECT_NEAR(force, on_one_rank, 1e-6 * std::abs(on_one_rank));
}

TYPED_TEST(MovingWindow, ReactionOfElasticSoilDoesNotDependOnTheNumberOfSteps)
{
  // boxes stay as they are while the soil at the blade is compressed: where each step starts from their corners, the
  // force is 20 % off; the reference that fades while the blade moves leaves 12 %
  Drag<TypeParam::value> at_once;
  const double expected = at_once.drag(5e-3);
  double force = 0.;
  for (unsigned int step = 0; step < 5; ++step)
    force = this->drag(1e-3);
  ASSERT_LT(expected, 0.);
  EXPECT_NEAR(force, expected, 0.15 * std::abs(expected));
}

TYPED_TEST(MovingWindow, RefinesNoWaitingSoil)
{
  this->ask_for_planes(0., 0., false);
  this->place_planes();
  Adaptivity adaptivity;
  adaptivity.type = AdaptivityType::rigid_body_surface;
  adaptivity.element_size = adaptivity.element_size_in_region = 0.25;
  adaptivity.region = 2.;
  this->soil.adapt(this->bodies, adaptivity);
  const auto& table = this->mesh.leaves();
  long long fine = 0;
  for (const auto& leaf : table.leaves)
    if (leaf.owned && leaf.size < 0.3)
    {
      EXPECT_TRUE(table.in_window(leaf));
      ++fine;
    }
  EXPECT_GT(sum_over_ranks(fine, MPI_COMM_WORLD), 0);
}

TYPED_TEST(MovingWindow, KeepsTheCellsThatSmallWaitingParticlesNeed)
{
  Adaptivity adaptivity;
  adaptivity.type = AdaptivityType::rigid_body_surface;
  adaptivity.element_size = 0.25;
  const auto count_fine = [&]
  {
    long long n = 0;
    for (const auto& leaf : this->mesh.leaves().leaves)
      n += leaf.owned && leaf.size < 0.3 && leaf.lower[0] < 3.;
    return sum_over_ranks(n, MPI_COMM_WORLD);
  };
  this->soil.adapt(this->bodies, adaptivity);
  const long long before = count_fine();
  ASSERT_GT(before, 0);
  this->ask_for_planes(0., 0., false);
  this->place(5.);
  this->place_planes();
  this->soil.adapt(this->bodies, adaptivity);
  EXPECT_EQ(count_fine(), before);
}
