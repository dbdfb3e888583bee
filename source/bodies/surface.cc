#include <kedge/bodies/surface.h>

#include "surface_edges.h"
#include "surface_tree.h"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace kedge
{
using namespace surface_tree;

Surface::Tree::Tree(TriangleMesh mesh_) : mesh(std::move(mesh_))
{
  std::vector<unsigned int> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  grow(order.begin(), order.end());
  tiny = 1e-9 * (nodes[0].upper - nodes[0].lower).norm();
  find_parts();
}

/// Appends the tree over some triangles, split at the median along the longest side of their centroids' box.
void Surface::Tree::grow(std::vector<unsigned int>::iterator begin, std::vector<unsigned int>::iterator end)
{
  const auto corner = [&](unsigned int t, unsigned int i) -> const Eigen::Vector3d&
  { return mesh.vertices[mesh.triangles[t][i]]; };
  const auto centre = [&](unsigned int t) -> Eigen::Vector3d { return corner(t, 0) + corner(t, 1) + corner(t, 2); };
  // Bounds of the triangles, and of their centroids for the choice of the axis to split.
  const unsigned int number = nodes.size();
  nodes.emplace_back();
  Eigen::Vector3d lower = corner(*begin, 0), upper = lower, lower_centre = centre(*begin), upper_centre = lower_centre;
  for (auto t = begin; t != end; ++t)
  {
    for (unsigned int i = 0; i < 3; ++i)
    {
      lower = lower.cwiseMin(corner(*t, i));
      upper = upper.cwiseMax(corner(*t, i));
    }
    lower_centre = lower_centre.cwiseMin(centre(*t));
    upper_centre = upper_centre.cwiseMax(centre(*t));
  }
  nodes[number].lower = lower;
  nodes[number].upper = upper;

  if (end - begin <= leaf_size)
  {
    nodes[number].first_facet = facets.size();
    nodes[number].n_facets = end - begin;
    for (auto t = begin; t != end; ++t)
      facets.push_back({corner(*t, 0), corner(*t, 1) - corner(*t, 0), corner(*t, 2) - corner(*t, 0), *t});
    return;
  }
  // The first child follows at once, so the node stores only where the second one begins.
  int axis;
  (upper_centre - lower_centre).maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end,
                   [&](unsigned int s, unsigned int t) { return centre(s)[axis] < centre(t)[axis]; });
  grow(begin, middle);
  nodes[number].other = nodes.size();
  grow(middle, end);
}

/// Pseudo-normals of faces, edges and vertices, and which of them are features.
void Surface::Tree::find_parts()
{
  // Faces, and the sums that give the pseudo-normals of vertices: face normals weighted by the angle of the corner.
  constexpr double flat = 1e-3; // rad
  const std::vector<Eigen::Vector3d> normals = face_normals(mesh);
  std::vector<Eigen::Vector3d> vertex_normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  parts.resize(n_parts * mesh.triangles.size());
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
  {
    for (unsigned int part = 0; part < n_parts; ++part)
      parts[n_parts * t + part].normal = normals[t];
    const auto& triangle = mesh.triangles[t];
    for (unsigned int i = 0; i < 3; ++i)
    {
      const Eigen::Vector3d u = mesh.vertices[triangle[(i + 1) % 3]] - mesh.vertices[triangle[i]],
                            v = mesh.vertices[triangle[(i + 2) % 3]] - mesh.vertices[triangle[i]];
      vertex_normals[triangle[i]] += std::atan2(u.cross(v).norm(), u.dot(v)) * normals[t];
    }
  }

  // Edges that are not flat. Flat ones keep the normal of the face.
  std::vector<std::vector<Eigen::Vector3d>> tangents(mesh.vertices.size()); // of these edges at each vertex
  for (const SurfaceEdge& edge : surface_edges(mesh, normals))
  {
    if (std::abs(edge.angle) < flat)
      continue;
    const Eigen::Vector3d tangent = (mesh.vertices[edge.vertices[1]] - mesh.vertices[edge.vertices[0]]).normalized();
    const Eigen::Vector3d normal = (normals[edge.triangles[0]] + normals[edge.triangles[1]]).normalized();
    for (unsigned int side = 0; side < 2; ++side)
      parts[n_parts * edge.triangles[side] + edge_0 + edge.sides[side]] = {normal, tangent, Feature::edge};
    for (const unsigned int v : edge.vertices)
      tangents[v].push_back(tangent);
  }

  // Vertices at such edges. One with just two collinear edges lies inside an edge.
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
    for (unsigned int i = 0; i < 3; ++i)
    {
      const unsigned int v = mesh.triangles[t][i];
      PartData& part = parts[n_parts * t + vertex_0 + i];
      if (tangents[v].empty())
        continue;
      part.normal = vertex_normals[v].normalized();
      const bool inside_edge = tangents[v].size() == 2 && tangents[v][0].cross(tangents[v][1]).norm() < flat;
      part.feature = inside_edge ? Feature::edge : Feature::vertex;
      if (inside_edge)
        part.tangent = tangents[v][0];
    }
}

TriangleTree Surface::Tree::on_host(const std::size_t n_queries) const
{
  TriangleTree view{nodes.data(), facets.data(), parts.data(), nodes.size(), facets.size(), tiny, {}};
  if (n_asked < n_grid_cells && (n_asked += n_queries) < n_grid_cells)
    return view;
  std::call_once(has_grid,
                 [&]
                 {
                   grid.emplace(nodes[0].lower, nodes[0].upper, n_grid_cells,
                                [&](const Eigen::Vector3d& at)
                                {
                                  const Nearest found = view.nearest(at, std::numeric_limits<double>::infinity());
                                  return std::copysign(std::sqrt(found.squared_distance), view.describe(at, found).gap);
                                });
                 });
  view.grid = grid->cells();
  return view;
}

TriangleTree Surface::Tree::on_device(const std::size_t n_queries) const
{
  TriangleTree view = on_host(n_queries);
  if (device_is_host && !mirrors_apart())
    return view;
  if (device_nodes.extent(0) == 0)
  {
    device_nodes = upload(nodes, "surface nodes");
    device_facets = upload(facets, "surface facets");
    device_parts = upload(parts, "surface parts");
  }
  if (grid && device_grid.extent(0) == 0)
    device_grid = upload(grid->values(), "surface grid");
  view.nodes = device_nodes.data();
  view.facets = device_facets.data();
  view.parts = device_parts.data();
  view.grid.distance = grid ? device_grid.data() : nullptr;
  return view;
}

Surface::Surface(TriangleMesh mesh) : tree(std::make_unique<Tree>(std::move(mesh))) {}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

const TriangleMesh& Surface::mesh() const { return tree->mesh; }

std::array<Eigen::Vector3d, 2> Surface::bounds() const { return {tree->nodes[0].lower, tree->nodes[0].upper}; }

ClosestPoint Surface::closest_point(const Eigen::Vector3d& x) const
{
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const TriangleTree view = tree->on_host();
  const Nearest nearest = view.nearest(x, infinity);
  if (nearest.facet == -1u) // only where x is not finite
  {
    const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(nan);
    return {nan, x, nowhere, Feature::face, Eigen::Vector3d::Zero(), 0, nowhere};
  }
  return view.describe_all(x, nearest);
}

std::optional<ClosestPoint> Surface::closest_point_within(const Eigen::Vector3d& x, double distance) const
{
  KnownDistance nothing;
  return closest_point_within(x, distance, nothing);
}

std::optional<ClosestPoint> Surface::closest_point_within(const Eigen::Vector3d& x, double distance,
                                                          KnownDistance& known) const
{
  ClosestPoint closest;
  return tree->on_host().find_within(x, distance, known, closest) ? std::optional<ClosestPoint>(closest) : std::nullopt;
}

bool Surface::is_within(const Eigen::Vector3d& x, const double distance) const
{
  return tree->on_host().is_within(x, distance);
}

double Surface::least_gap(const Eigen::Vector3d& x, const KnownDistance& known) const
{
  return tree->on_host().least_gap(x, known);
}

TriangleTree Surface::for_kernels(const std::size_t n_queries) const { return tree->on_device(n_queries); }
} // namespace kedge
