#include "surface_crossing.h"

#include "overlapping_boxes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace kedge
{
namespace
{
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const TriangleMesh& mesh, const unsigned int vertex)
{
  const Eigen::Vector3d& x = mesh.vertices[vertex];
  return {x[0], x[1], x[2]};
}

/// Whether the triangles have more in common than a vertex or an edge of the mesh.
bool cross(const TriangleMesh& mesh, const std::array<unsigned int, 3>& first,
           const std::array<unsigned int, 3>& second)
{
  // Vertices of both come first in the order, so that the rest of each lies opposite to them.
  std::array<unsigned int, 3> a = first, b = second;
  const auto is_in = [](const std::array<unsigned int, 3>& triangle)
  {
    return [&triangle](const unsigned int v)
    { return std::find(triangle.begin(), triangle.end(), v) != triangle.end(); };
  };
  const auto n_common = std::stable_partition(a.begin(), a.end(), is_in(second)) - a.begin();
  std::stable_partition(b.begin(), b.end(), is_in(first));

  std::array<Kernel::Point_3, 3> p, q;
  for (unsigned int i = 0; i < 3; ++i)
  {
    p[i] = point(mesh, a[i]);
    q[i] = point(mesh, b[i]);
  }
  if (n_common == 3)
    return true;
  // Across an edge they overlap only where one is folded back onto the other.
  if (n_common == 2)
    return CGAL::coplanar(p[0], p[1], p[2], q[2]) &&
           CGAL::coplanar_orientation(p[0], p[1], p[2], q[2]) == CGAL::POSITIVE;
  const Kernel::Triangle_3 s(p[0], p[1], p[2]), t(q[0], q[1], q[2]);
  if (n_common == 1)
    return CGAL::do_intersect(s, Kernel::Segment_3(q[1], q[2])) || CGAL::do_intersect(t, Kernel::Segment_3(p[1], p[2]));
  return CGAL::do_intersect(s, t);
}

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
/// The first pair of overlapping boxes that fulfils a condition.
std::optional<std::array<unsigned int, 2>> first_pair(const std::vector<Eigen::AlignedBox3d>& boxes,
                                                      const std::function<bool(unsigned int, unsigned int)>& condition)
{
  struct Found
  {
    std::array<unsigned int, 2> pair;
  };
  try
  {
    for_overlapping_pairs(boxes,
                          [&condition](const unsigned int i, const unsigned int j)
                          {
                            if (condition(i, j))
                              throw Found{{i, j}};
                          });
  }
  catch (const Found& found)
  {
    return found.pair;
  }
  return std::nullopt;
}
} // namespace

std::optional<Crossing> find_crossing(const TriangleMesh& mesh)
{
  std::vector<Eigen::AlignedBox3d> boxes(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const unsigned int vertex : mesh.triangles[t])
      boxes[t].extend(mesh.vertices[vertex]);

  const auto found = first_pair(boxes, [&mesh](const unsigned int s, const unsigned int t)
                                { return cross(mesh, mesh.triangles[s], mesh.triangles[t]); });
  if (!found)
    return std::nullopt;
  std::array<std::array<Eigen::Vector3d, 3>, 2> triangles;
  for (unsigned int side = 0; side < 2; ++side)
    for (unsigned int i = 0; i < 3; ++i)
      triangles[side][i] = mesh.vertices[mesh.triangles[(*found)[side]][i]];
  return Crossing{*found, common_point(triangles)};
}

std::optional<std::array<unsigned int, 2>> find_touching_sides(const std::vector<std::array<double, 2>>& outline)
{
  const std::size_t n = outline.size();
  const auto corner = [&](const std::size_t i) { return Kernel::Point_2(outline[i % n][0], outline[i % n][1]); };
  std::vector<Eigen::AlignedBox3d> boxes(n);
  for (std::size_t i = 0; i < n; ++i)
    for (const auto& x : {outline[i], outline[(i + 1) % n]})
      boxes[i].extend(Eigen::Vector3d(x[0], x[1], 0.));

  const auto folds_back = [&](const std::size_t i)
  {
    const Kernel::Point_2 a = corner(i), b = corner(i + 1), c = corner(i + 2);
    return CGAL::collinear(a, b, c) && CGAL::angle(a, b, c) == CGAL::ACUTE;
  };
  return first_pair(boxes,
                    [&](const unsigned int i, const unsigned int j)
                    {
                      if ((i + 1) % n == j || (j + 1) % n == i)
                        return ((i + 1) % n == j && folds_back(i)) || ((j + 1) % n == i && folds_back(j));
                      return CGAL::do_intersect(Kernel::Segment_2(corner(i), corner(i + 1)),
                                                Kernel::Segment_2(corner(j), corner(j + 1)));
                    });
}
} // namespace kedge
