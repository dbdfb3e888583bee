// Laws with memory in soil: a block that is compressed answers as one material point, whatever the size of its cells,
// and goes on so after its points are split, merged or handed to other ranks.
#include "../bodies/shapes.h"
#include "step_fixture.h"
#include <gtest/gtest.h>
#include <kedge/base/communication.h>
#include <kedge/particles/splitting.h>

using namespace kedge;

namespace
{
/// Remoulded slowly enough for fine cells not to find a band of slip, which they do with half of this remoulding
/// strain.
MaterialParameters clay()
{
  MaterialParameters material;
  material.law = law_index<Clay>;
  material.young = 1e6;
  material.poisson = 0.3;
  material.density = 2000.;
  material.constants.values = {
      {"undrained strength", 1e4}, {"strength gradient", 0.}, {"remoulded ratio", 0.4}, {"remoulding strain", 0.8}};
  return material;
}

MaterialParameters sand()
{
  MaterialParameters material;
  material.law = law_index<MohrCoulomb>;
  material.young = 2e6;
  material.poisson = 0.2;
  material.density = 2000.;
  material.constants.values = {
      {"friction angle", 38.},          {"dilation angle", 8.},          {"cohesion", 5e3},
      {"critical friction angle", 30.}, {"critical dilation angle", 0.}, {"softening strain", 0.1},
      {"shear band width", 0.1}};
  return material;
}

/// Weightless soil, half as wide as its grid and 1 m high, between a smooth base, a plane of symmetry and a smooth
/// plate that comes down; nothing holds its other side.
struct Compression : test::StepFixture<2>
{
  static constexpr double width = 1.;

  Compression(const MaterialParameters& material, const double cell)
      : test::StepFixture<2>(layout(cell), stretching(material), 0., stiff_contact())
  {
    solver.tolerance = 1e-5;
    solver.ghost_factor = 1e-3;
    solver.linear_solver = LinearSolverChoice::direct;
    stage.rigid_bodies = true;
    gravity = {{0., -1e-2, 0.}}; // residuals are measured by the weight
    stage.boundary_conditions.min = {{FaceCondition::roller, FaceCondition::roller, FaceCondition::free}};
    particles.remove_if([](const auto& particle) { return particle.get_location()[0] > width; });
    bodies.points.emplace_back();
    bodies.points[0].pose.position = {0., 0., 1.};
    bodies.surfaces.push_back({Surface(extrude_outline({{-1., 0.}, {3., 0.}, {3., 1.}, {-1., 1.}}, "plate")), 0});
  }

  /// Domains that stay as high as at first would keep the surface higher than the soil.
  static MaterialPointParameters stretching(const MaterialParameters& material)
  {
    MaterialPointParameters parameters = test::layers_of({{1., material}});
    parameters.domain_update = DomainUpdate::stretch;
    return parameters;
  }

  static GridLayout<2> layout(const double cell)
  {
    const auto n = static_cast<unsigned int>(std::lround(2. / cell));
    return test::make_brick<2>({n, n}, cell, 0.5);
  }

  static ContactParameters stiff_contact()
  {
    ContactParameters parameters;
    parameters.normal_penalty_factor = 200.;
    return parameters;
  }

  /// One step of the plate (m down); returns the pressure on it, Pa.
  double press(const double increment)
  {
    ImplicitStep<2> step(context());
    StepLoad load;
    load.body_increments = {Vector6::Zero()};
    load.body_increments[0][2] = -increment;
    const NewtonReport report = step.solve(load);
    EXPECT_TRUE(report.converged) << report.failure;
    const double force = step.body_loads()[0][2];
    commit(step);
    return force;
  }
};

/// The same compression of one material point in a cell of that size, free of stress sideways: axial force per width.
class Element
{
public:
  Element(const MaterialParameters& parameters, const double cell)
      : material(make_material(parameters)), young(parameters.young), cell_size(cell)
  {
    initialise_state(material, {0.5, 0.}, state.data());
  }

  /// The sideways stretch that leaves no sideways stress is found by bisection.
  double press(const double height_before, const double height_after)
  {
    const double stretch = height_after / height_before;
    double low = 0.9, high = 1.2;
    StressUpdate update;
    std::array<double, Laws::max_state> next{};
    for (unsigned int i = 0; i < 100; ++i)
    {
      const double sideways = 0.5 * (low + high);
      Eigen::Matrix3d dF = Eigen::Matrix3d::Identity();
      dF(0, 0) = sideways;
      dF(1, 1) = stretch; // stored axes are x, z, y
      next = state;
      SymmetricTensor b = left_cauchy_green(strain);
      update = update_stress(dF, b, {young, cell_size, state.data()}, material, next.data());
      (update.stress[0] > 0. ? high : low) = sideways;
    }
    width *= 0.5 * (low + high);
    volume *= 0.5 * (low + high) * stretch;
    state = next;
    strain = update.elastic_strain;
    return -update.stress[1] / volume * width;
  }

private:
  Material material;
  double young, cell_size, width = 1., volume = 1.;
  SymmetricTensor strain = SymmetricTensor::Zero();
  std::array<double, Laws::max_state> state{};
};

void expect_the_answer_of_an_element(const MaterialParameters& material, const double cell, const bool splits)
{
  Compression soil(material, cell);
  Element element(material, cell);
  double height = 1., force = 0., expected = 0., peak = 0.;
  for (unsigned int step = 0; step < 30; ++step)
  {
    if (splits && step == 15)
    {
      const std::size_t before = soil.particles.ids().size();
      split_particles(soil.particles, soil.mesh, 4);
      ASSERT_GT(soil.particles.ids().size(), 3 * before);
    }
    force = soil.press(2e-3);
    expected = element.press(height, height - 2e-3);
    height -= 2e-3;
    peak = std::max(peak, expected);
    ASSERT_NEAR(force, expected, 0.01 * peak) << "step " << step << ", cells of " << cell << " m";
  }
  EXPECT_LT(expected, 0.95 * peak); // it has softened
}
} // namespace

TEST(Memory, RemouldedClayAnswersAsOnePointInCellsOfAnySize)
{
  for (const double cell : {0.5, 0.25, 0.125})
    expect_the_answer_of_an_element(clay(), cell, false);
}

TEST(Memory, SofteningSandAnswersAsOnePointInCellsOfAnySize)
{
  for (const double cell : {0.5, 0.25, 0.125})
    expect_the_answer_of_an_element(sand(), cell, false);
}

TEST(Memory, SplitPointsGoOnWithTheStateOfTheirParents) { expect_the_answer_of_an_element(clay(), 0.5, true); }
