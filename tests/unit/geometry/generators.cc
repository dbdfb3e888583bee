#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/geometry/generators.h>
#include <unistd.h>

namespace kedge
{
namespace
{
using Eigen::Vector3d;

void expect_extent(const TriangleMesh& mesh, const Vector3d& lower, const Vector3d& upper)
{
  const auto [l, u] = bounds(mesh);
  EXPECT_NEAR((l - lower).norm(), 0., 1e-15);
  EXPECT_NEAR((u - upper).norm(), 0., 1e-15);
}

/// Volume of a box rounded with radius r: the shrunk box, its faces' slabs, quarter cylinders and a sphere.
double rounded_box_volume(const Vector3d& size, double r)
{
  const Vector3d s = size - Vector3d::Constant(2. * r);
  return s.prod() + 2. * r * (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) + M_PI * r * r * s.sum() +
         4. / 3. * M_PI * r * r * r;
}

double rounded_box_area(const Vector3d& size, double r)
{
  const Vector3d s = size - Vector3d::Constant(2. * r);
  return 2. * (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) + 2. * M_PI * r * s.sum() + 4. * M_PI * r * r;
}

/// Area of a circle's inscribed polygon over that of the circle.
double polygon_share(unsigned int sides) { return sides / (2. * M_PI) * std::sin(2. * M_PI / sides); }

TEST(Box, SharpBoxIsExact)
{
  const TriangleMesh mesh = make_box({1., 2., 3.}, {});
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  check_surface(mesh, "box");
  const MassProperties p = mass_properties(mesh);
  EXPECT_NEAR(p.volume, 6., 1e-14);
  EXPECT_NEAR(p.area, 22., 1e-14);
  EXPECT_NEAR(p.centroid.norm(), 0., 1e-15);
  EXPECT_NEAR((p.inertia - 0.5 * Vector3d(13., 10., 5.).asDiagonal().toDenseMatrix()).norm(), 0., 1e-13);
}

TEST(Box, RoundingKeepsTheExtentAndTheSurfaceClosed)
{
  for (const unsigned int segments : {1u, 2u, 3u, 4u, 7u})
  {
    const TriangleMesh mesh = make_box({0.1, 0.2, 0.3}, {0.02, segments});
    check_surface(mesh, "box");
    expect_extent(mesh, {-0.05, -0.1, -0.15}, {0.05, 0.1, 0.15});
  }
}

TEST(Box, RoundedVolumeAndAreaConvergeWithTheSquareOfTheSegments)
{
  const Vector3d size(0.1, 0.2, 0.3);
  const auto error = [&](unsigned int segments)
  {
    const MassProperties p = mass_properties(make_box(size, {0.03, segments}));
    return std::array<double, 2>{rounded_box_volume(size, 0.03) - p.volume, rounded_box_area(size, 0.03) - p.area};
  };
  for (int quantity = 0; quantity < 2; ++quantity)
  {
    EXPECT_GT(error(16)[quantity], 0.);
    EXPECT_NEAR(error(8)[quantity] / error(16)[quantity], 4., 0.1);
  }
}

TEST(Box, VerticesLieOnTheRoundedSurface)
{
  const Vector3d inner(0.03, 0.08, 0.13);
  for (const Vector3d& x : make_box({0.1, 0.2, 0.3}, {0.02, 5}).vertices)
    EXPECT_NEAR((x.cwiseAbs() - inner).cwiseMax(0.).norm(), 0.02, 1e-16);
}

TEST(Box, EdgeRadiusIsRecognised)
{
  const auto radius = [](unsigned int segments) {
    return Surface(make_box({0.1, 0.2, 0.3}, {0.02, segments})).sharpest_edge_radius();
  };
  for (const unsigned int segments : {2u, 4u, 8u, 16u})
    EXPECT_NEAR(radius(segments), 0.02, 0.2 * 0.02) << segments;
  EXPECT_NEAR(radius(1), 0.02, 0.5 * 0.02); // a chamfer
}

TEST(Box, LargestRadiusMakesAClosedSurface)
{
  check_surface(make_box({0.1, 0.2, 0.3}, {0.05, 4}), "box"); // two faces vanish
  check_surface(make_box({0.1, 0.1, 0.3}, {0.05, 4}), "box"); // a capsule
}

TEST(Box, BadSizesAreRefused)
{
  EXPECT_THROW(make_box({0., 1., 1.}, {}), InputError);
  EXPECT_THROW(make_box({1., NAN, 1.}, {}), InputError);
  EXPECT_THROW(make_box({1., 1., 1.}, {0.51, 4}), InputError);
  EXPECT_THROW(make_box({1., 1., 1.}, {-0.1, 4}), InputError);
  EXPECT_THROW(make_box({1., 1., 1.}, {0.1, 0}), InputError);
}

TEST(Plate, ThicknessIsAlongX)
{
  expect_extent(make_plate(0.1, 0.01, {0.0025, 4}), {-0.005, -0.05, -0.05}, {0.005, 0.05, 0.05});
}

TEST(Plate, RefusalNamesTheParameter)
{
  try
  {
    make_plate(0.1, 0.01, {0.02, 4});
    FAIL();
  }
  catch (const InputError& error)
  {
    EXPECT_STREQ(error.what(), "edge radius: 0.02 m does not fit the body; use 0 to 0.005 m");
  }
}

TEST(Sphere, IsInscribedAndReachesTheRadiusAlongTheAxes)
{
  const TriangleMesh mesh = make_sphere(0.4, 12);
  check_surface(mesh, "sphere");
  EXPECT_EQ(mesh.triangles.size(), 8u * 12u * 12u);
  expect_extent(mesh, Vector3d::Constant(-0.4), Vector3d::Constant(0.4));
  for (const Vector3d& x : mesh.vertices)
    EXPECT_NEAR(x.norm(), 0.4, 1e-15);
}

TEST(Sphere, MassPropertiesConverge)
{
  const auto error = [](unsigned int segments)
  {
    const MassProperties p = mass_properties(make_sphere(1., segments));
    const double inertia = 8. * M_PI / 15.;
    EXPECT_NEAR(p.centroid.norm(), 0., 1e-14);
    EXPECT_NEAR(p.inertia(0, 1), 0., 1e-14);
    return std::array<double, 3>{4. / 3. * M_PI - p.volume, 4. * M_PI - p.area, inertia - p.inertia(2, 2)};
  };
  for (int quantity = 0; quantity < 3; ++quantity)
    EXPECT_NEAR(error(12)[quantity] / error(24)[quantity], 4., 0.1);
  EXPECT_LT(error(24)[0] / (4. / 3. * M_PI), 0.005);
}

TEST(Sphere, TrianglesAreCompact)
{
  const TriangleMesh mesh = make_sphere(1., 16);
  double smallest = 180.;
  for (const auto& triangle : mesh.triangles)
    for (unsigned int i = 0; i < 3; ++i)
    {
      const Vector3d u = mesh.vertices[triangle[(i + 1) % 3]] - mesh.vertices[triangle[i]],
                     v = mesh.vertices[triangle[(i + 2) % 3]] - mesh.vertices[triangle[i]];
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)) * 180. / M_PI);
    }
  EXPECT_GT(smallest, 30.);
}

TEST(Frustum, SharpFrustumIsExactForItsPolygon)
{
  const double D = 0.12, d = 0.05, L = 0.2;
  const TriangleMesh mesh = make_frustum(D, d, L, 48, {});
  check_surface(mesh, "frustum");
  expect_extent(mesh, {0., -D / 2., -D / 2.}, {L, D / 2., D / 2.});
  const MassProperties p = mass_properties(mesh);
  EXPECT_NEAR(p.volume, polygon_share(48) * M_PI * L / 12. * (D * D + D * d + d * d), 1e-15);
  EXPECT_NEAR(p.centroid[0], L / 4. * (D * D + 2. * D * d + 3. * d * d) / (D * D + D * d + d * d), 1e-15);
}

TEST(Frustum, WidensWhereTheSecondBaseIsLarger)
{
  const TriangleMesh mesh = make_frustum(0.05, 0.12, 0.2, 48, {0.004, 3});
  check_surface(mesh, "frustum");
  expect_extent(mesh, {0., -0.06, -0.06}, {0.2, 0.06, 0.06});
}

TEST(Frustum, RoundingKeepsLengthAndRadiusCylinder)
{
  // Equal diameters: both rims lie on the radius, so the extent is exact. Pappus gives the volume cut off.
  const double R = 0.05, L = 0.2, r = 0.01;
  const auto volume = [&](unsigned int segments)
  {
    const TriangleMesh mesh = make_frustum(2. * R, 2. * R, L, 64, {r, segments});
    check_surface(mesh, "frustum");
    expect_extent(mesh, {0., -R, -R}, {L, R, R});
    return mass_properties(mesh).volume / polygon_share(64);
  };
  const double area = r * r * (1. - M_PI / 4.), arm = R - r * (10. - 3. * M_PI) / (12. - 3. * M_PI);
  const double exact = M_PI * R * R * L - 2. * 2. * M_PI * arm * area;
  EXPECT_NEAR((exact - volume(8)) / (exact - volume(16)), 4., 0.1);
  EXPECT_NEAR(volume(32), exact, 1e-4 * exact);
}

TEST(Frustum, RoundedSlantedSideKeepsLengthAndLargestDiameter)
{
  for (const unsigned int segments : {1u, 2u, 3u, 4u})
  {
    const TriangleMesh mesh = make_frustum(0.12, 0.05, 0.2, 48, {0.01, segments});
    check_surface(mesh, "frustum");
    expect_extent(mesh, {0., -0.06, -0.06}, {0.2, 0.06, 0.06});
  }
}

TEST(Frustum, RoundingOfNearlyHalfTheLengthKeepsTheDiameter)
{
  for (const auto& [D, d, L, r] : std::vector<std::array<double, 4>>{
           {0.12, 0.05, 0.2, 0.0249}, {0.1, 0.08, 0.01, 0.0045}, {0.1, 0.1, 0.02, 0.01}, {0.1, 0.099, 0.02, 0.01}})
  {
    const TriangleMesh mesh = make_frustum(D, d, L, 48, {r, 4});
    check_surface(mesh, "frustum");
    expect_extent(mesh, {0., -D / 2., -D / 2.}, {L, D / 2., D / 2.});
  }
}

TEST(Frustum, RoundingsThatDoNotFitAreRefused)
{
  for (const auto& [D, d, L, r] : std::vector<std::array<double, 4>>{
           {0.1, 0.09, 0.02, 0.03}, {0.12, 0.05, 0.02, 1.}, {0.4, 0.2, 0.05, 0.025}, {0.12, 0.05, 0.2, INFINITY}})
    EXPECT_THROW(make_frustum(D, d, L, 48, {r, 4}), InputError) << D << " " << d << " " << L << " " << r;
}

TEST(Frustum, SmallRoundingTendsToTheSharpFrustum)
{
  const double sharp = mass_properties(make_frustum(0.12, 0.05, 0.2, 48, {})).volume;
  EXPECT_NEAR(mass_properties(make_frustum(0.12, 0.05, 0.2, 48, {1e-5, 4})).volume, sharp, 1e-3 * sharp);
}

TEST(Cone, SharpConeIsExactForItsPolygon)
{
  const double R = 0.018, L = 0.2, tip = R / std::tan(M_PI / 6.);
  const TriangleMesh mesh = make_cone(R, 60., L, 48, {});
  check_surface(mesh, "cone");
  expect_extent(mesh, {-R, -R, 0.}, {R, R, L});
  EXPECT_NEAR(mass_properties(mesh).volume, polygon_share(48) * M_PI * R * R * (tip / 3. + L - tip), 1e-16);
}

TEST(Cone, RoundedTipKeepsLengthRadiusAndAngle)
{
  const double R = 0.018, L = 0.2;
  const TriangleMesh mesh = make_cone(R, 60., L, 48, {0.003, 4});
  check_surface(mesh, "cone");
  expect_extent(mesh, {-R, -R, 0.}, {R, R, L});
  // Halfway up the tip the surface has the slope of the cone.
  const ClosestPoint flank = Surface(mesh).closest_point({0.012, 0., 0.01});
  EXPECT_NEAR(std::asin(-flank.normal[2]) * 180. / M_PI, 30., 1e-9);
}

TEST(Cone, TipRadiusIsRecognised)
{
  EXPECT_EQ(Surface(make_cone(0.018, 60., 0.2, 48, {})).sharpest_edge_radius(), 0.);
  EXPECT_NEAR(Surface(make_cone(0.018, 60., 0.2, 48, {0.003, 6})).sharpest_edge_radius(), 0.003, 0.0006);
}

TEST(Cone, LongShaftHasNoSlivers)
{
  const TriangleMesh mesh = make_cone(0.018, 60., 1., 48, {0.003, 4});
  double longest = 0.;
  for (const auto& [i, j, k] : mesh.triangles)
  {
    const Vector3d a = mesh.vertices[i], b = mesh.vertices[j], c = mesh.vertices[k];
    const double edge = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    longest = std::max(longest, edge * edge / (b - a).cross(c - a).norm());
  }
  EXPECT_LT(longest, 25.);
}

TEST(Cone, BadShapesAreRefused)
{
  EXPECT_THROW(make_cone(0.018, 60., 0.03, 48, {}), InputError);
  EXPECT_THROW(make_cone(0.018, 180., 0.3, 48, {}), InputError);
  EXPECT_THROW(make_cone(0.018, 60., 0.3, 2, {}), InputError);
  EXPECT_THROW(make_cone(0.018, 60., 0.3, 48, {0.02, 4}), InputError);
}

TEST(Generators, BodiesSurviveWritingAndReading)
{
  const std::string file =
      (std::filesystem::temp_directory_path() / fmt::format("kedge-generators-{}.stl", getpid())).string();
  const Rounding rounding{0.0025, 4};
  for (const TriangleMesh& mesh :
       {make_plate(0.1, 0.01, rounding), make_box({0.1, 0.2, 0.3}, rounding),
        make_frustum(0.12, 0.05, 0.2, 64, rounding), make_cone(0.018, 60., 1., 64, rounding), make_sphere(0.1, 24)})
  {
    write_stl(mesh, file);
    const TriangleMesh read = read_stl(file, "stl");
    EXPECT_EQ(read.vertices.size(), mesh.vertices.size());
    EXPECT_EQ(read.triangles.size(), mesh.triangles.size());
    EXPECT_NEAR(mass_properties(read).volume, mass_properties(mesh).volume, 1e-6 * mass_properties(mesh).volume);
  }
  std::filesystem::remove(file);
}
} // namespace
} // namespace kedge
