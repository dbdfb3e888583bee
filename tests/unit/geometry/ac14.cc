#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/geometry/ac14.h>
#include <limits>
#include <set>

namespace kedge
{
namespace
{
using Eigen::Vector3d;

std::array<TriangleMesh, 2> parts(const PartMesh& mesh = {})
{
  return {make_ac14_fluke({}, mesh), make_ac14_shank({}, mesh)};
}

TEST(Ac14, MassAndCentroidAreThoseOfTheTutorial)
{
  const std::array<double, 2> mass{6583.2, 2116.7}, centroid{0.62, 1.7592};
  for (const double size : {0.04, 0.06, 0.1})
    for (unsigned int part = 0; part < 2; ++part)
    {
      const MassProperties p = mass_properties(parts({size, 4})[part]);
      EXPECT_NEAR(7850. * p.volume, mass[part], 1e-9 * mass[part]);
      EXPECT_NEAR((p.centroid - Vector3d(centroid[part], 0., 0.)).norm(), 0., 1e-12);
    }
}

TEST(Ac14, ExtentsAreThoseOfTheTutorial)
{
  const auto [fluke, shank] = parts();
  const auto [fluke_lower, fluke_upper] = bounds(fluke);
  EXPECT_NEAR(fluke_lower[0], 0., 1e-12);
  EXPECT_NEAR(fluke_upper[0], 1.7, 1e-12);
  EXPECT_NEAR(fluke_upper[1] - fluke_lower[1], 2.2, 1e-12);
  const auto [shank_lower, shank_upper] = bounds(shank);
  EXPECT_NEAR(shank_upper[0] - shank_lower[0], 3.3, 1e-12);
}

TEST(Ac14, SurfacesAreClosedForAnySizeOfTriangles)
{
  for (const double size : {0.04, 0.06, 0.1})
    for (const unsigned int segments : {2u, 4u, 8u})
      for (const TriangleMesh& part : parts({size, segments}))
        check_surface(part, "anchor");
}

TEST(Ac14, BothPlanesOfSymmetryAreExact)
{
  using Triangle = std::set<std::array<double, 3>>;
  for (const TriangleMesh& part : parts())
    for (const Vector3d& sign : {Vector3d(1., -1., 1.), Vector3d(1., 1., -1.)})
    {
      std::set<Triangle> own, mirrored;
      for (const auto& triangle : part.triangles)
      {
        Triangle corners, images;
        for (const unsigned int v : triangle)
        {
          const Vector3d x = part.vertices[v], image = x.cwiseProduct(sign);
          corners.insert({x[0], x[1], x[2]});
          images.insert({image[0], image[1], image[2]});
        }
        own.insert(corners);
        mirrored.insert(images);
      }
      EXPECT_EQ(own, mirrored);
    }
}

TEST(Ac14, BodiesCrossTheSymmetryPlane)
{
  const auto [fluke, shank] = parts();
  EXPECT_LT(Surface(fluke).closest_point({0.3, 0., 0.}).gap, -0.05);
  EXPECT_LT(Surface(shank).closest_point({2., 0., 0.}).gap, -0.05);
}

TEST(Ac14, EdgesAreRounderThanHalfAMaterialPoint)
{
  for (const double size : {0.04, 0.06, 0.1})
    for (const TriangleMesh& part : parts({size, 4}))
      EXPECT_GT(Surface(part).sharpest_edge_radius(), 0.025) << size;
}

TEST(Ac14, EyeIsAHole)
{
  const Vector3d eye(3.0294, 0., 0.);
  EXPECT_NEAR(Surface(make_ac14_shank({}, {})).closest_point(eye).gap, 0.06, 0.002);
  Ac14Shank blind;
  blind.eye_radius = 0.;
  const TriangleMesh shank = make_ac14_shank(blind, {});
  check_surface(shank, "shank");
  EXPECT_LT(Surface(shank).closest_point(eye).gap, -0.05);
}

/// x turned about the pivot from +x towards +z, degrees.
Vector3d turned(const Vector3d& x, double angle)
{
  const double c = std::cos(angle * M_PI / 180.), s = std::sin(angle * M_PI / 180.), u = x[0] - Ac14Shank().pivot;
  return {Ac14Shank().pivot + c * u - s * x[2], x[1], s * u + c * x[2]};
}

TEST(Ac14, ShankTurnsBetweenTheFlukes)
{
  // Nearer to the pivot than this the shank passes through the crown.
  constexpr double crown = 0.35, clearance = 0.1;
  const auto [fluke, shank] = parts();
  const Surface fluke_surface(fluke), shank_surface(shank);
  const auto ahead_of_crown = [](const Vector3d& x)
  { return x[0] > Ac14Shank().pivot && std::hypot(x[0] - Ac14Shank().pivot, x[2]) > crown; };
  for (double angle = -35.; angle <= 35.; angle += 5.)
  {
    double gap = std::numeric_limits<double>::infinity();
    for (const Vector3d& x : shank.vertices)
      if (ahead_of_crown(x))
        gap = std::min(gap, fluke_surface.closest_point(turned(x, angle)).gap);
    for (const Vector3d& x : fluke.vertices)
      if (ahead_of_crown(x))
        gap = std::min(gap, shank_surface.closest_point(turned(x, -angle)).gap);
    EXPECT_GT(gap, clearance) << angle;
  }
}

TEST(Ac14, ThicknessFollowsTheWidth)
{
  Ac14Fluke narrow;
  narrow.crown_width = 2.1;
  const TriangleMesh fluke = make_ac14_fluke(narrow, {});
  check_surface(fluke, "fluke");
  EXPECT_NEAR(7850. * mass_properties(fluke).volume, 6583.2, 1e-5);
  EXPECT_GT(bounds(fluke)[1][2], bounds(parts()[0])[1][2]);
}

TEST(Ac14, ImpossibleDimensionsAreRefused)
{
  Ac14Fluke fluke;
  fluke.centroid = 0.9; // needs a crown of negative thickness
  EXPECT_THROW(make_ac14_fluke(fluke, {}), InputError);
  fluke = {};
  fluke.mass = 1000.; // edges sharper than allowed
  EXPECT_THROW(make_ac14_fluke(fluke, {}), InputError);
  fluke = {};
  fluke.crown_width = 0.8; // fillets overlap
  EXPECT_THROW(make_ac14_fluke(fluke, {}), InputError);
  fluke = {};
  fluke.crown_width = 1e9; // triangles without end
  EXPECT_THROW(make_ac14_fluke(fluke, {}), InputError);
  fluke.crown_width = NAN;
  EXPECT_THROW(make_ac14_fluke(fluke, {}), InputError);
  Ac14Shank shank;
  shank.eye_radius = -1.;
  EXPECT_THROW(make_ac14_shank(shank, {}), InputError);
  shank.eye_radius = 0.15; // the rim of the hole meets that of the eye
  EXPECT_THROW(make_ac14_shank(shank, {}), InputError);
  EXPECT_THROW(make_ac14_shank({}, {0., 4}), InputError);
  EXPECT_THROW(make_ac14_shank({}, {0.06, 0}), InputError);
}
} // namespace
} // namespace kedge
