#include "shapes.h"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <random>

namespace kedge
{
namespace
{
using Eigen::Vector3d;

/// Signed distance to the unit box.
double box_gap(const Vector3d& x)
{
  const Vector3d q = (x - Vector3d::Constant(0.5)).cwiseAbs() - Vector3d::Constant(0.5);
  return q.cwiseMax(0.).norm() + std::min(q.maxCoeff(), 0.);
}

/// Winding number of a closed mesh about a point: 1 inside, 0 outside (van Oosterom & Strackee 1983).
double winding_number(const TriangleMesh& mesh, const Vector3d& x)
{
  double angle = 0.;
  for (const auto& [i, j, k] : mesh.triangles)
  {
    const Vector3d a = mesh.vertices[i] - x, b = mesh.vertices[j] - x, c = mesh.vertices[k] - x;
    angle += 2. * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                    b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return angle / (4. * M_PI);
}

TEST(Surface, GapOfABoxIsExact)
{
  const Surface surface(test::unit_box());
  test::RandomPoints random(-1., 2.);
  for (int i = 0; i < 5000; ++i)
  {
    const Vector3d x = random();
    EXPECT_NEAR(surface.closest_point(x).gap, box_gap(x), 1e-14);
  }
}

TEST(Surface, SignOnAConcaveMeshFollowsTheWindingNumber)
{
  // Every second vertex pulled inwards: ridges, valleys and vertices of both signs.
  TriangleMesh mesh = test::sphere(1., 3);
  for (std::size_t v = 0; v < mesh.vertices.size(); v += 2)
    mesh.vertices[v] *= 0.8;
  const Surface surface(mesh);
  test::RandomPoints random(-1.1, 1.1);
  for (int i = 0; i < 5000; ++i)
  {
    const Vector3d x = random();
    EXPECT_EQ(surface.closest_point(x).gap<0., winding_number(mesh, x)> 0.5) << x.transpose();
  }
}

TEST(Surface, TreeFindsTheNearestOfAllTriangles)
{
  const TriangleMesh mesh = test::sphere(1., 4);
  const Surface surface(mesh);
  test::RandomPoints random(-1.5, 1.5);
  for (int i = 0; i < 300; ++i)
  {
    const Vector3d x = random();
    double nearest = 1e300;
    for (const auto& triangle : mesh.triangles) // one triangle is a tree with a single leaf
      nearest = std::min(nearest, (x - Surface({mesh.vertices, {triangle}}).closest_point(x).point).norm());
    EXPECT_NEAR(std::abs(surface.closest_point(x).gap), nearest, 1e-14);
  }
}

TEST(Surface, NormalIsTheGradientOfTheGap)
{
  const Surface surface(test::angle_section());
  test::RandomPoints random(-0.5, 2.5);
  constexpr double h = 1e-6;
  int smooth = 0;
  for (int i = 0; i < 2000; ++i)
  {
    const Vector3d x = random();
    const ClosestPoint closest = surface.closest_point(x);
    EXPECT_NEAR(closest.normal.norm(), 1., 1e-14);
    EXPECT_NEAR((closest.point + closest.gap * closest.normal - x).norm(), 0., 1e-13);
    Vector3d gradient;
    for (int d = 0; d < 3; ++d)
      gradient[d] = (surface.closest_point(x + h * Vector3d::Unit(d)).gap -
                     surface.closest_point(x - h * Vector3d::Unit(d)).gap) /
                    (2. * h);
    if (std::abs(gradient.norm() - 1.) > 1e-3)
      continue; // the gap has a kink where two faces are equally near
    ++smooth;
    EXPECT_NEAR((gradient - closest.normal).norm(), 0., 1e-5) << x.transpose();
  }
  EXPECT_GT(smooth, 1950);
}

TEST(Surface, FaceEdgeAndVertexAreToldApart)
{
  const Surface surface(test::unit_box());
  const ClosestPoint face = surface.closest_point({0.3, 0.6, 1.5});
  EXPECT_EQ(face.feature, Feature::face);
  EXPECT_NEAR((face.normal - Vector3d::UnitZ()).norm(), 0., 1e-15);
  EXPECT_EQ(face.tangent, Vector3d::Zero());

  const ClosestPoint edge = surface.closest_point({0.3, 1.3, 1.4});
  EXPECT_EQ(edge.feature, Feature::edge);
  EXPECT_NEAR(edge.gap, 0.5, 1e-15);
  EXPECT_NEAR((edge.normal - Vector3d(0., 0.6, 0.8)).norm(), 0., 1e-15);
  EXPECT_NEAR(std::abs(edge.tangent[0]), 1., 1e-15);

  const ClosestPoint vertex = surface.closest_point({2., 2., 2.});
  EXPECT_EQ(vertex.feature, Feature::vertex);
  EXPECT_NEAR(vertex.gap, std::sqrt(3.), 1e-15);
}

TEST(Surface, DiagonalOfAFlatFaceIsFace)
{
  const Surface surface(test::unit_box());
  const ClosestPoint closest = surface.closest_point({0.5, 0.5, 1.2});
  EXPECT_EQ(closest.feature, Feature::face);
  EXPECT_NEAR(closest.gap, 0.2, 1e-15);
}

TEST(Surface, VertexInsideAStraightEdgeIsEdge)
{
  const Surface surface(extrude_outline({{0., 0.}, {1., 0.}, {1., 1.}, {0., 1.}}, "outline"));
  TriangleMesh mesh = surface.mesh();
  // Split every side wall at y = 0 by hand. The vertices (., 0, .) then lie inside the long edges.
  TriangleMesh halves;
  for (const double y : {-4., 0., 4.})
    for (unsigned int i = 0; i < 4; ++i)
      halves.vertices.emplace_back(mesh.vertices[i][0], y, mesh.vertices[i][2]);
  for (unsigned int row = 0; row < 2; ++row)
    for (unsigned int i = 0; i < 4; ++i)
    {
      const unsigned int j = (i + 1) % 4, a = 4 * row + i, b = 4 * row + j;
      halves.triangles.insert(halves.triangles.end(), {{a, b + 4, b}, {a, a + 4, b + 4}});
    }
  halves.triangles.insert(halves.triangles.end(), {{0, 1, 2}, {0, 2, 3}, {8, 10, 9}, {8, 11, 10}});
  check_surface(halves, "halves");
  const ClosestPoint closest = Surface(halves).closest_point({1.3, 0., 1.4});
  EXPECT_EQ(closest.feature, Feature::edge);
  EXPECT_NEAR(closest.gap, 0.5, 1e-15);
  EXPECT_NEAR(std::abs(closest.tangent[1]), 1., 1e-15);
}

TEST(Surface, PointOnAFaceHasItsNormal)
{
  const Surface surface(test::unit_box());
  for (const double noise : {-1e-16, 0., 1e-16, 1e-17})
  {
    const ClosestPoint closest = surface.closest_point({0.25, 0.6, 1. + noise});
    EXPECT_NEAR(closest.gap, 0., 1e-15);
    EXPECT_EQ(closest.normal, Vector3d::UnitZ());
  }
}

TEST(Surface, PointOnAnEdgeOrVertexHasThePseudoNormal)
{
  const Surface surface(test::unit_box());
  const Vector3d noise(1e-16, -1e-16, 1e-16);
  const ClosestPoint edge = surface.closest_point(Vector3d(0.3, 1., 1.) + noise);
  EXPECT_NEAR(edge.gap, 0., 1e-15);
  EXPECT_GT(edge.normal.dot(Vector3d(0., 1., 1.).normalized()), 0.7); // one of the faces' normals or between them
  EXPECT_NEAR(edge.normal.norm(), 1., 1e-15);
  // The three faces at this corner have 1, 1 and 2 triangles; weights by angle must make this irrelevant.
  const ClosestPoint vertex = surface.closest_point({1., 0., 0.});
  EXPECT_EQ(vertex.gap, 0.);
  EXPECT_NEAR((vertex.normal - Vector3d(1., -1., -1.).normalized()).norm(), 0., 1e-15);
}

TEST(Surface, PartsEquallyNearFromInsideShareTheNormal)
{
  const Surface box(test::unit_box());
  for (const double shift : {-1e-12, 0., 1e-12}) // round-off does not choose
  {
    const ClosestPoint edge = box.closest_point({0.25 + shift, 0.25, 0.5}), corner = box.closest_point({0.8, 0.2, 0.8});
    EXPECT_NEAR(edge.gap, -0.25, 1e-11);
    EXPECT_NEAR((edge.normal - Vector3d(-1., -1., 0.).normalized()).norm(), 0., 1e-14);
    EXPECT_NEAR((corner.normal - Vector3d(1., -1., 1.).normalized()).norm(), 0., 1e-14);
    EXPECT_NEAR((box.closest_point({0.25 + 1e-4, 0.25, 0.5}).normal + Vector3d::UnitY()).norm(), 0., 1e-14);
  }
  const Surface plate(test::box({0., 0., 0.}, {1., 1., 0.2}));
  const Vector3d first = plate.closest_point({0.3, 0.6, 0.1}).normal; // half way through a plate either face will do
  EXPECT_EQ(std::abs(first[2]), 1.);
  for (const double shift : {-1e-12, 1e-12})
    EXPECT_EQ(plate.closest_point({0.3, 0.6, 0.1 + shift}).normal, first);
}

TEST(Surface, BoundedQueryAgreesWithTheFullOne)
{
  const Surface surface(test::angle_section());
  test::RandomPoints random(-1., 3.);
  for (int i = 0; i < 5000; ++i)
  {
    const Vector3d x = random();
    const double gap = surface.closest_point(x).gap;
    const std::optional<ClosestPoint> near = surface.closest_point_within(x, 0.1);
    EXPECT_EQ(near.has_value(), gap <= 0.1) << x.transpose();
    EXPECT_EQ(surface.is_within(x, 0.1), gap <= 0.1) << x.transpose();
    EXPECT_EQ(surface.is_within(x, 0.), gap <= 0.) << x.transpose();
    EXPECT_EQ(near ? near->gap : gap, gap);
    EXPECT_TRUE(gap > 0.1 || !(surface.least_gap(x) > 0.1));
  }
}

TEST(Surface, AKnownDistanceDoesNotChangeTheResultForAMovedPoint)
{
  // Steps of all sizes lead in and out of a body with faces, edges, corners and nearly flat facets.
  for (const TriangleMesh& mesh : {test::unit_box(), test::sphere(0.5, 3)})
  {
    const Surface surface(mesh);
    test::RandomPoints random(-0.6, 0.6);
    KnownDistance known;
    Vector3d x = random();
    for (int i = 0; i < 3000; ++i)
    {
      x = i % 10 == 0 ? random() : Vector3d(x + std::pow(10., -i % 7) * random());
      const double distance = i % 3 == 0 ? 0.1 : 0.;
      const auto afresh = surface.closest_point_within(x, distance);
      const auto followed = surface.closest_point_within(x, distance, known);
      ASSERT_EQ(afresh.has_value(), followed.has_value()) << x.transpose();
      if (!afresh)
        continue;
      ASSERT_EQ(afresh->gap, followed->gap);
      ASSERT_EQ(afresh->normal, followed->normal);
      ASSERT_EQ(afresh->triangle, followed->triangle);
    }
  }
}

TEST(Surface, HoldsThePointsOfItsFaces)
{
  const Surface surface(test::unit_box());
  test::RandomPoints random(0., 1.);
  for (int i = 0; i < 600; ++i)
  {
    Vector3d x = random();
    x[i % 3] = i % 2;
    ASSERT_TRUE(surface.closest_point_within(x, 0.)) << x.transpose();
    ASSERT_TRUE(surface.is_within(x, 0.)) << x.transpose();
  }
}

TEST(Surface, GapOfPointsThatAreNotFiniteIsNotANumber)
{
  const Surface surface(test::unit_box());
  EXPECT_TRUE(std::isnan(surface.closest_point({NAN, 0., 0.}).gap));
  EXPECT_FALSE(surface.closest_point_within({NAN, 0., 0.}, 1.));
  EXPECT_FALSE(surface.is_within({NAN, 0., 0.}, 1.));
}

TEST(Surface, BoundsHoldTheMesh)
{
  const Surface surface(test::box({-1., 2., 3.}, {4., 5., 6.}));
  EXPECT_EQ(surface.bounds()[0], Vector3d(-1., 2., 3.));
  EXPECT_EQ(surface.bounds()[1], Vector3d(4., 5., 6.));
}

TEST(Surface, SharpBoxHasNoEdgeRadius) { EXPECT_EQ(Surface(test::unit_box()).sharpest_edge_radius(), 0.); }

TEST(Surface, EdgeRadiusOfASphereIsItsRadius)
{
  EXPECT_NEAR(Surface(test::sphere(2., 3)).sharpest_edge_radius(), 2., 0.2);
}

TEST(Surface, EdgeRadiusOfAPolygonalCylinderIsItsRadius)
{
  std::vector<std::array<double, 2>> circle;
  for (int i = 0; i < 32; ++i)
    circle.push_back({0.1 * std::cos(M_PI * i / 16.), 0.1 * std::sin(M_PI * i / 16.)});
  EXPECT_NEAR(sharpest_corner_radius(circle), 0.1, 1e-3);
  std::reverse(circle.begin(), circle.end());
  EXPECT_NEAR(sharpest_corner_radius(circle), 0.1, 1e-3);
  // with its end caps the prism is sharp
  EXPECT_EQ(Surface(extrude_outline(circle, "outline")).sharpest_edge_radius(), 0.);
}

TEST(Surface, SharpCornerOfAnOutlineHasNoRadius)
{
  EXPECT_EQ(sharpest_corner_radius({{0., 0.}, {1., 0.}, {1., 1.}, {0., 1.}}), 0.);
}

TEST(MassProperties, BoxAwayFromTheOriginIsExact)
{
  const MassProperties p = mass_properties(test::box({100., 200., 300.}, {101., 202., 303.}));
  EXPECT_NEAR(p.volume, 6., 1e-12);
  EXPECT_NEAR(p.area, 22., 1e-12);
  EXPECT_NEAR((p.centroid - Vector3d(100.5, 201., 301.5)).norm(), 0., 1e-12);
  const Eigen::Matrix3d exact = 6. / 12. * Vector3d(4. + 9., 1. + 9., 1. + 4.).asDiagonal().toDenseMatrix();
  EXPECT_NEAR((p.inertia - exact).norm(), 0., 1e-12);
}
} // namespace
} // namespace kedge
