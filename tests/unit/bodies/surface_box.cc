#include "shapes.h"
#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/bodies/rigid_systems.h>
#include <random>

namespace kedge
{
namespace
{
using Eigen::Vector3d;

class RandomScenes
{
public:
  double number(const double lower, const double upper)
  {
    return std::uniform_real_distribution<double>(lower, upper)(engine);
  }
  Vector3d point(const double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Pose pose(const double size) { return {point(size), rotation_from_vector(point(2.))}; }
  OrientedBox box(const double size)
  {
    return {point(size), rotation_from_vector(point(2.)).toRotationMatrix(),
            Vector3d(number(0.05, 0.4), number(0.05, 0.4), number(0.05, 0.4))};
  }

private:
  std::mt19937 engine{3};
};

Surface one_triangle(const std::array<Vector3d, 3>& corners)
{
  return Surface(TriangleMesh{{corners[0], corners[1], corners[2]}, {{0, 1, 2}}});
}

/// Distance of a triangle from a box by alternating projections, which converge for convex sets (von Neumann).
double distance_by_projections(const Surface& triangle, const OrientedBox& box)
{
  Vector3d in_box = box.centre;
  double distance = 0.;
  for (int i = 0; i < 3000; ++i)
  {
    const Vector3d on_triangle = triangle.closest_point(in_box).point;
    const Vector3d local = box.axes.transpose() * (on_triangle - box.centre);
    in_box = box.centre + box.axes * local.cwiseMax(-box.half_width).cwiseMin(box.half_width);
    distance = (on_triangle - in_box).norm();
  }
  return distance;
}

TEST(SurfaceAndBox, CrossWhereClippingLeavesSomething)
{
  RandomScenes random;
  int crossing = 0;
  for (int i = 0; i < 5000; ++i)
  {
    const std::array<Vector3d, 3> corners{random.point(0.7), random.point(0.7), random.point(0.7)};
    const OrientedBox box = random.box(0.5);
    const bool expected = test::crosses_by_clipping({corners.begin(), corners.end()}, box);
    ASSERT_EQ(one_triangle(corners).comes_within(box, 0.), expected) << "scene " << i;
    crossing += expected;
  }
  EXPECT_GT(crossing, 1000); // otherwise the test would prove little
  EXPECT_LT(crossing, 4000);
}

TEST(SurfaceAndBox, AreAsFarApartAsTheirNearestPoints)
{
  RandomScenes random;
  constexpr double tolerance = 1e-3; // of the distance
  int apart = 0;
  for (int i = 0; i < 300; ++i)
  {
    const Surface triangle = one_triangle({random.point(0.7), random.point(0.7), random.point(0.7)});
    const OrientedBox box = random.box(1.);
    const double distance = distance_by_projections(triangle, box);
    if (distance < 0.01) // where projections converge slowly
      continue;
    ++apart;
    EXPECT_TRUE(triangle.comes_within(box, (1. + tolerance) * distance)) << "scene " << i;
    EXPECT_FALSE(triangle.comes_within(box, (1. - tolerance) * distance)) << "scene " << i;
  }
  EXPECT_GT(apart, 150);
}

TEST(SurfaceAndBox, TreeFindsWhatTryingAllTrianglesFinds)
{
  const TriangleMesh mesh = test::sphere(1., 3);
  const Surface surface(mesh);
  RandomScenes random;
  int near = 0;
  for (int i = 0; i < 400; ++i)
  {
    const OrientedBox box = random.box(1.2);
    bool any = false;
    for (const auto& [a, b, c] : mesh.triangles)
      any = any || one_triangle({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]}).comes_within(box, 0.1);
    ASSERT_EQ(surface.comes_within(box, 0.1), any);
    near += any;
  }
  EXPECT_GT(near, 50);
  EXPECT_LT(near, 350);
}

TEST(SurfaceAndBox, CrossWhereTheBoxHoldsTheWholeSurface)
{
  const Surface surface(test::sphere(0.1, 1));
  EXPECT_TRUE(surface.comes_within({{0.5, 0.3, 0.2}, Eigen::Matrix3d::Identity(), {1., 1., 1.}}, 0.));
}

TEST(SurfaceAndBox, AreApartWhereTheBoxLiesInsideTheBody)
{
  const Surface surface(test::unit_box());
  const OrientedBox box{{0.5, 0.5, 0.5}, Eigen::Matrix3d::Identity(), {0.2, 0.1, 0.1}};
  EXPECT_FALSE(surface.comes_within(box, 0.299));
  EXPECT_TRUE(surface.comes_within(box, 0.301));
}

TEST(SurfaceAndBox, MeetInWorldAxesWhateverThePoseOfTheBody)
{
  RandomScenes random;
  const TriangleMesh mesh = test::box({-0.5, -0.1, -0.3}, {0.5, 0.1, 0.3});
  int near = 0;
  for (int i = 0; i < 500; ++i)
  {
    RigidSystems systems;
    systems.points.emplace_back();
    systems.points[0].pose = random.pose(0.5);
    systems.surfaces.push_back({Surface(mesh), 0});
    TriangleMesh moved = mesh;
    for (Vector3d& vertex : moved.vertices)
      vertex = systems.points[0].pose.to_world(vertex);
    const Vector3d lower = random.point(0.6), size(0.3, 0.2, 0.4);
    const bool expected =
        Surface(moved).comes_within({lower + 0.5 * size, Eigen::Matrix3d::Identity(), 0.5 * size}, 0.2);
    ASSERT_EQ(surface_comes_within(systems, lower, lower + size, 0.2), expected) << "scene " << i;
    near += expected;
  }
  EXPECT_GT(near, 100);
  EXPECT_LT(near, 400);
}

/// In plane strain the box is a rectangle in the plane y = 0 and the body a prism.
class PlaneStrain : public testing::Test
{
public:
  PlaneStrain()
  {
    systems.points.emplace_back();
    systems.surfaces.push_back(
        {Surface(extrude_outline({{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}, "outline")), 0});
    systems.points[0].pose.rotation = rotation_from_vector({0., M_PI / 4., 0.});
  }
  bool near(const double x, const double z, const double size, const double distance) const
  {
    return surface_comes_within(systems, {x, 0., z}, {x + size, 0., z + size}, distance);
  }
  RigidSystems systems; ///< a square of side 1 that stands on its corner
};

TEST_F(PlaneStrain, RectangleIsAsFarAsTheOutline)
{
  const double corner = std::sqrt(0.5);
  EXPECT_TRUE(near(corner + 0.1, -0.1, 0.2, 0.1001));
  EXPECT_FALSE(near(corner + 0.1, -0.1, 0.2, 0.0999));
  const double aside = (0.6 + 0.5) / std::sqrt(2.) - 0.5; // of the corner [0.6, 0.5] from the side
  EXPECT_TRUE(near(0.6, 0.5, 0.3, 1.001 * aside));
  EXPECT_FALSE(near(0.6, 0.5, 0.3, 0.999 * aside));
}

TEST_F(PlaneStrain, EndsOfThePrismAreNeverNear)
{
  EXPECT_FALSE(near(-0.1, -0.1, 0.2, 0.5 - 0.2 / std::sqrt(2.) - 1e-3));
  EXPECT_TRUE(near(-0.1, -0.1, 0.2, 0.5 - 0.2 / std::sqrt(2.) + 1e-3));
}
} // namespace
} // namespace kedge
