// The only file of this room that includes CGAL: its headers are slow to compile.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <Eigen/Geometry>
#include <kedge/bodies/surface.h>
#include <limits>

namespace kedge
{
namespace
{
/// Where the edge a-b crosses the plane of the triangle, and how far outside the triangle (barycentric; 0: inside).
std::pair<Eigen::Vector3d, double> pierce(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                          const std::array<Eigen::Vector3d, 3>& triangle)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d u = triangle[1] - triangle[0], v = triangle[2] - triangle[0], normal = u.cross(v);
  const double ha = normal.dot(a - triangle[0]), hb = normal.dot(b - triangle[0]);
  if (!(ha * hb <= 0.) || ha == hb)
    return {a, infinity};
  const Eigen::Vector3d x = a + ha / (ha - hb) * (b - a), r = x - triangle[0];
  const double s = r.cross(v).dot(normal) / normal.squaredNorm(), t = u.cross(r).dot(normal) / normal.squaredNorm();
  return {x, std::max({0., -s, -t, s + t - 1.})};
}

/// A point common to two crossing triangles; the middle of their centroids where they only overlap in a plane.
Eigen::Vector3d common_point(const std::array<std::array<Eigen::Vector3d, 3>, 2>& triangles)
{
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (const auto& triangle : triangles)
    for (const Eigen::Vector3d& corner : triangle)
      best += corner / 6.;
  // A shared corner pierces trivially: take the piercing point that is farthest from the corners.
  double farthest = 0.;
  for (unsigned int side = 0; side < 2; ++side)
    for (unsigned int i = 0; i < 3; ++i)
    {
      const auto& edges = triangles[side];
      const auto& [x, outside] = pierce(edges[i], edges[(i + 1) % 3], triangles[1 - side]);
      if (outside > 1e-9)
        continue;
      double distance = std::numeric_limits<double>::max();
      for (const Eigen::Vector3d& corner : triangles[1 - side])
        distance = std::min(distance, (corner - x).norm());
      if (distance > farthest)
      {
        farthest = distance;
        best = x;
      }
    }
  return best;
}
} // namespace

std::optional<Crossing> find_crossing(const TriangleMesh& mesh)
{
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  using Face = Mesh::Face_index;

  Mesh copy;
  for (const Eigen::Vector3d& x : mesh.vertices)
    copy.add_vertex({x[0], x[1], x[2]});
  for (const auto& [a, b, c] : mesh.triangles)
    copy.add_face(Mesh::Vertex_index(a), Mesh::Vertex_index(b), Mesh::Vertex_index(c));

  std::vector<std::pair<Face, Face>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(faces(copy), copy, std::back_inserter(pairs),
                                                    CGAL::parameters::maximum_number(1));
  if (pairs.empty())
    return std::nullopt;

  Crossing crossing{{pairs[0].first.idx(), pairs[0].second.idx()}, {}};
  std::array<std::array<Eigen::Vector3d, 3>, 2> triangles;
  for (unsigned int side = 0; side < 2; ++side)
    for (unsigned int i = 0; i < 3; ++i)
      triangles[side][i] = mesh.vertices[mesh.triangles[crossing.triangles[side]][i]];
  crossing.position = common_point(triangles);
  return crossing;
}
} // namespace kedge
