#include "shapes.h"
#include <Eigen/Geometry>
#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/bodies/surface.h>
#include <random>

namespace kedge
{
namespace
{
/// Whether the segment a-b passes through the inside of a triangle: the signs of five volumes.
bool pierces(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const std::array<Eigen::Vector3d, 3>& corners)
{
  const auto volume = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r,
                         const Eigen::Vector3d& s) { return (q - p).cross(r - p).dot(s - p); };
  const auto& [x, y, z] = corners;
  const bool is_above = volume(x, y, z, a) > 0.;
  if (is_above == (volume(x, y, z, b) > 0.))
    return false;
  const bool turn = volume(a, b, x, y) > 0.;
  return turn == (volume(a, b, y, z) > 0.) && turn == (volume(a, b, z, x) > 0.);
}

/// Every edge against every triangle that holds none of its ends: enough where no four vertices lie in a plane.
bool crosses_by_edges(const TriangleMesh& mesh)
{
  for (const auto& edges : mesh.triangles)
    for (unsigned int i = 0; i < 3; ++i)
      for (const auto& triangle : mesh.triangles)
      {
        const unsigned int a = edges[i], b = edges[(i + 1) % 3];
        const auto holds = [&triangle](const unsigned int vertex)
        { return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end(); };
        if (!holds(a) && !holds(b) &&
            pierces(mesh.vertices[a], mesh.vertices[b],
                    {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]]}))
          return true;
      }
  return false;
}

TEST(SurfaceCrossing, AgreesWithEveryEdgeAgainstEveryTriangle)
{
  std::mt19937 random(7);
  unsigned int crossing = 0;
  constexpr unsigned int n = 400;
  for (unsigned int k = 0; k < n; ++k)
  {
    TriangleMesh mesh = test::sphere(1., k % 2 + 1);
    const double shift = (k % 2 ? 0.3 : 0.8) * (k % 20) / 20. + 0.05;
    std::uniform_real_distribution<double> uniform(-shift, shift);
    for (Eigen::Vector3d& x : mesh.vertices)
      x += Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
    const bool expected = crosses_by_edges(mesh);
    EXPECT_EQ(find_crossing(mesh).has_value(), expected) << "mesh " << k;
    crossing += expected;
  }
  EXPECT_GT(crossing, n / 5); // otherwise the test would prove little
  EXPECT_LT(crossing, n - n / 5);
}

TEST(SurfaceCrossing, NamesTrianglesThatHoldThePoint)
{
  TriangleMesh mesh = test::sphere(1., 2);
  mesh.vertices[0] = {-1.5, 0.1, 0.2};
  const std::optional<Crossing> crossing = find_crossing(mesh);
  ASSERT_TRUE(crossing);
  for (const unsigned int t : crossing->triangles)
  {
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3d u = mesh.vertices[b] - mesh.vertices[a], v = mesh.vertices[c] - mesh.vertices[a];
    EXPECT_NEAR(u.cross(v).normalized().dot(crossing->position - mesh.vertices[a]), 0., 1e-12);
  }
}

TEST(SurfaceCrossing, TriangleFoldedOntoItsNeighbourCounts)
{
  // A tetrahedron pressed flat: each face lies on another one across an edge.
  const TriangleMesh flat{{{0., 0., 0.}, {1., 0., 0.}, {0., 1., 0.}, {0.2, 0.2, 0.}},
                          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  EXPECT_TRUE(find_crossing(flat));
}

TEST(SurfaceCrossing, NeighboursInOnePlaneDoNotCount)
{
  EXPECT_FALSE(find_crossing(test::unit_box()));
  EXPECT_FALSE(find_crossing(test::angle_section()));
}
} // namespace
} // namespace kedge
