#include "surface_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace kedge
{
std::vector<Eigen::Vector3d> face_normals(const TriangleMesh& mesh)
{
  std::vector<Eigen::Vector3d> normals;
  for (const auto& [i, j, k] : mesh.triangles)
  {
    const Eigen::Vector3d &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
    normals.push_back((b - a).cross(c - a).normalized());
  }
  return normals;
}

std::vector<SurfaceEdge> surface_edges(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& normals)
{
  std::map<std::array<unsigned int, 2>, std::array<unsigned int, 2>> first_sides; // edge -> triangle, side
  std::vector<SurfaceEdge> edges;
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
    for (unsigned int side = 0; side < 3; ++side)
    {
      const unsigned int a = mesh.triangles[t][side], b = mesh.triangles[t][(side + 1) % 3];
      const auto first = first_sides.find({b, a});
      if (first == first_sides.end())
      {
        first_sides[{a, b}] = {t, side};
        continue;
      }
      const auto [t0, side0] = first->second;
      const Eigen::Vector3d turn = normals[t0].cross(normals[t]);
      const double angle = std::atan2(turn.norm(), normals[t0].dot(normals[t]));
      const bool convex = turn.dot(mesh.vertices[a] - mesh.vertices[b]) > 0.;
      edges.push_back({{b, a}, {t0, t}, {side0, side}, convex ? angle : -angle});
      first_sides.erase(first);
    }
  return edges;
}

namespace
{
/// For every side of every triangle: the far corner of the neighbour across it if both are coplanar, else none.
using FlatNeighbours = std::vector<std::array<std::optional<Eigen::Vector3d>, 3>>;

FlatNeighbours flat_neighbours(const TriangleMesh& mesh, const std::vector<SurfaceEdge>& edges)
{
  FlatNeighbours across(mesh.triangles.size());
  for (const SurfaceEdge& edge : edges)
    if (std::abs(edge.angle) < 1e-3)
      for (unsigned int i = 0; i < 2; ++i)
        across[edge.triangles[i]][edge.sides[i]] =
            mesh.vertices[mesh.triangles[edge.triangles[1 - i]][(edge.sides[1 - i] + 2) % 3]];
  return across;
}

/// Half the width of a face, seen from one of its sides. Two coplanar triangles that share a diagonal count as one
/// quadrilateral, with half the mean distance of its far corners. A single triangle has the distance of its
/// circumcentre. Long or obtuse triangles have theirs far away, so the distance of the centroid and half the height
/// bound it.
double half_width(const TriangleMesh& mesh, const FlatNeighbours& across, unsigned int triangle, unsigned int side)
{
  const auto corner = [&](unsigned int i) { return mesh.vertices[mesh.triangles[triangle][(side + i) % 3]]; };
  const Eigen::Vector3d a = corner(0), b = corner(1), c = corner(2);
  const double base = (b - a).norm(), twice_area = (b - a).cross(c - a).norm(), height = twice_area / base;
  const unsigned int diagonal = (side + ((c - b).norm() > (a - c).norm() ? 1 : 2)) % 3;
  if (const auto& d = across[triangle][diagonal])
    return (height + (b - a).cross(*d - a).norm() / base) / 4.;
  const double circumcentre = 0.5 * base * (a - c).dot(b - c) / twice_area;
  return std::clamp(circumcentre, height / 3., height / 2.);
}

/// Whether any vertex has no concave edge and face normals that spread by more than a right angle.
bool has_sharp_convex_vertex(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& normals,
                             const std::vector<SurfaceEdge>& edges)
{
  std::vector<bool> convex(mesh.vertices.size(), true);
  for (const SurfaceEdge& edge : edges)
    if (edge.angle < -1e-3)
      convex[edge.vertices[0]] = convex[edge.vertices[1]] = false;
  std::vector<std::vector<unsigned int>> around(mesh.vertices.size());
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
    for (const unsigned int v : mesh.triangles[t])
      around[v].push_back(t);
  for (unsigned int v = 0; v < around.size(); ++v)
    if (convex[v])
      for (const unsigned int s : around[v])
        for (const unsigned int t : around[v])
          if (normals[s].dot(normals[t]) < -1e-3)
            return true;
  return false;
}
} // namespace

double rounding_radius(const double angle, const double half_width_0, const double half_width_1)
{
  constexpr double flat = 5. * M_PI / 180., sharp = 60. * M_PI / 180., much_wider = 3.;
  if (angle < flat)
    return std::numeric_limits<double>::infinity();
  if (angle > sharp)
    return 0.;
  const double narrow = std::min(half_width_0, half_width_1), wide = std::max(half_width_0, half_width_1);
  const double turned_over = wide > much_wider * narrow ? narrow : narrow + wide;
  return turned_over / (2. * std::sin(angle / 2.));
}

double Surface::sharpest_edge_radius() const
{
  const std::vector<Eigen::Vector3d> normals = face_normals(mesh());
  const std::vector<SurfaceEdge> edges = surface_edges(mesh(), normals);
  if (has_sharp_convex_vertex(mesh(), normals, edges))
    return 0.;
  const FlatNeighbours across = flat_neighbours(mesh(), edges);
  double smallest = std::numeric_limits<double>::infinity();
  for (const SurfaceEdge& edge : edges)
    smallest =
        std::min(smallest, rounding_radius(edge.angle, half_width(mesh(), across, edge.triangles[0], edge.sides[0]),
                                           half_width(mesh(), across, edge.triangles[1], edge.sides[1])));
  return smallest;
}
} // namespace kedge
