// Soil that is refined before its first step: every piece of a split point begins with what belongs to its own place.
#include "../bodies/shapes.h"
#include "../soil_fixture.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
constexpr double base = 0.5, height = 2., interface = 1.1, gravity = 10., K0 = 0.6;
constexpr double density[] = {1800., 2000.}; // above and below the interface

MaterialPointParameters layered_soil()
{
  Layer above = test::elastic_layer(height - interface, density[0]), below = test::elastic_layer(interface, density[1]);
  below.material.overburden = Overburden{1e5, 0.5};
  MaterialPointParameters parameters = test::layers_of({above, below}, K0);
  parameters.initial_velocity.path = "initial velocity";
  parameters.initial_velocity.components = {"X", "3 * Z"};
  return parameters;
}

struct RefinedAtTheStart : testing::Test, test::SoilFixture<2>
{
  RefinedAtTheStart() : test::SoilFixture<2>(layout(), layered_soil(), gravity)
  {
    bodies.points.resize(1);
    bodies.points[0].pose.position = {1.1, 0., 1.2};
    bodies.surfaces.push_back(
        {Surface(extrude_outline({{-0.2, -0.2}, {0.2, -0.2}, {0.2, 0.2}, {-0.2, 0.2}}, "box")), 0});
    adaptivity.type = AdaptivityType::rigid_body_surface;
    adaptivity.element_size = 0.25 * base;
  }

  static GridLayout<2> layout()
  {
    GridLayout<2> grid = test::make_brick<2>({4, 5}, base, 1.);
    grid.soil_extent = {{4 * base, height}};
    grid.finest_size = 0.25 * base;
    return grid;
  }

  RigidSystems bodies;
  Adaptivity adaptivity;
};
} // namespace

TEST_F(RefinedAtTheStart, HasTheStateOfEachPlace)
{
  const auto before = particles.n_global();
  ASSERT_TRUE(soil.adapt(bodies, adaptivity));
  ASSERT_GT(particles.n_global(), before);
  for (const auto& particle : particles.handler())
  {
    const auto data = particle.get_properties();
    const double x = particle.get_location()[0], z = particle.get_location()[1];
    const bool is_above = z > interface;
    const double vertical = gravity * (is_above ? density[0] * (height - z)
                                                : density[0] * (height - interface) + density[1] * (interface - z));
    EXPECT_NEAR(data[field::stress + 1], -vertical, 1e-9 * vertical);
    EXPECT_NEAR(data[field::stress + 0], -K0 * vertical, 1e-9 * vertical);
    EXPECT_NEAR(data[field::stress + 2], -K0 * vertical, 1e-9 * vertical);
    const double young = 1e7 * (is_above ? 1. : std::sqrt(vertical / 1e5));
    EXPECT_NEAR(data[field::young], young, 1e-9 * young);
    EXPECT_NEAR(data[field::elastic_strain + 1], -vertical * (1. - 2. * 0.25 * K0) / young, 1e-12);
    EXPECT_NEAR(data[field::velocity + 0], x, 1e-12);
    EXPECT_NEAR(data[field::velocity + 1], 3. * z, 1e-12);
  }
}

TEST_F(RefinedAtTheStart, KeepsWhatAStepHasMadeOfIt)
{
  SoilIncrements nothing;
  nothing.particles = test::increments_of(
      particles, [](const long long, const unsigned int) { return 0.; }, 1.01);
  soil.commit(nothing, nullptr);
  std::vector<double> stiffness;
  for (const auto& particle : particles.handler())
    stiffness.push_back(particle.get_properties()[field::young]);
  ASSERT_TRUE(soil.adapt(bodies, adaptivity));
  for (const auto& particle : particles.handler())
  {
    const auto data = particle.get_properties();
    EXPECT_GT(std::count(stiffness.begin(), stiffness.end(), data[field::young]), 0);
    EXPECT_EQ(data[field::velocity + 0], 0.);
    EXPECT_EQ(data[field::velocity + 1], 0.);
  }
}
