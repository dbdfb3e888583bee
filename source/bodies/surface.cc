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

std::pair<Eigen::Vector3d, Part> surface_tree::project(const Facet& facet, const Eigen::Vector3d& x)
{
  const auto& [a, ab, ac, triangle] = facet;
  const Eigen::Vector3d ap = x - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0. && d2 <= 0.)
    return {a, vertex_0};
  const Eigen::Vector3d bp = ap - ab;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0. && d4 <= d3)
    return {a + ab, vertex_1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0. && d1 >= 0. && d3 <= 0.)
    return {a + d1 / (d1 - d3) * ab, edge_0};
  const Eigen::Vector3d cp = ap - ac;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0. && d5 <= d6)
    return {a + ac, vertex_2};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0. && d2 >= 0. && d6 <= 0.)
    return {a + d2 / (d2 - d6) * ac, edge_2};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0. && d4 >= d3 && d5 >= d6)
    return {a + ab + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (ac - ab), edge_1};
  const double sum = va + vb + vc;
  return {a + vb / sum * ab + vc / sum * ac, face};
}

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
  parts.resize(mesh.triangles.size());
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
  {
    for (PartData& part : parts[t])
      part.normal = normals[t];
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
      parts[edge.triangles[side]][edge_0 + edge.sides[side]] = {normal, tangent, Feature::edge};
    for (const unsigned int v : edge.vertices)
      tangents[v].push_back(tangent);
  }

  // Vertices at such edges. One with just two collinear edges lies inside an edge.
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
    for (unsigned int i = 0; i < 3; ++i)
    {
      const unsigned int v = mesh.triangles[t][i];
      PartData& part = parts[t][vertex_0 + i];
      if (tangents[v].empty())
        continue;
      part.normal = vertex_normals[v].normalized();
      const bool inside_edge = tangents[v].size() == 2 && tangents[v][0].cross(tangents[v][1]).norm() < flat;
      part.feature = inside_edge ? Feature::edge : Feature::vertex;
      if (inside_edge)
        part.tangent = tangents[v][0];
    }
}

Nearest Surface::Tree::nearest(const Eigen::Vector3d& x, double squared_limit) const
{
  struct Entry
  {
    unsigned int node;
    double squared_distance;
  };
  std::array<Entry, 64> stack; // the tree is balanced: 64 levels are never reached
  Nearest best{squared_limit, {}};
  unsigned int size = 0;
  if (const double d = nodes[0].squared_distance(x); d <= squared_limit)
    stack[size++] = {0, d};
  while (size > 0)
  {
    // A box that was near enough when it was stacked may have become too far.
    const Entry entry = stack[--size];
    if (entry.squared_distance > best.squared_distance)
      continue;
    const Node& node = nodes[entry.node];
    for (unsigned int f = node.first_facet; f < node.first_facet + node.n_facets; ++f)
    {
      const auto [point, part] = project(facets[f], x);
      const double squared_distance = (x - point).squaredNorm();
      if (squared_distance <= best.squared_distance)
        best = {squared_distance, point, f, part};
    }
    if (node.n_facets > 0)
      continue;
    // The nearer child goes on top of the stack: it is searched first and tightens the bound for the other one.
    Entry near{entry.node + 1, nodes[entry.node + 1].squared_distance(x)};
    Entry far{node.other, nodes[node.other].squared_distance(x)};
    if (far.squared_distance < near.squared_distance)
      std::swap(near, far);
    if (far.squared_distance <= best.squared_distance)
      stack[size++] = far;
    if (near.squared_distance <= best.squared_distance)
      stack[size++] = near;
  }
  return best;
}

ClosestPoint Surface::Tree::describe(const Eigen::Vector3d& x, const Nearest& nearest) const
{
  const unsigned int triangle = facets[nearest.facet].triangle;
  const PartData& part = parts[triangle][nearest.part];
  const Eigen::Vector3d away = x - nearest.point;
  const double height = part.normal.dot(away);
  // On a face the gap is the height above its plane, which passes smoothly through zero. Elsewhere the height gives
  // only the sign.
  if (part.feature == Feature::face)
  {
    // The foot of the perpendicular is more exact than barycentric coordinates of a slender triangle.
    const Eigen::Vector3d foot = nearest.part == face ? Eigen::Vector3d(x - height * part.normal) : nearest.point;
    return {height, foot, part.normal, part.feature, part.tangent, triangle, part.normal};
  }
  const double distance = std::sqrt(nearest.squared_distance), gap = std::copysign(distance, height);
  const Eigen::Vector3d normal = distance > tiny ? Eigen::Vector3d(away / gap) : part.normal;
  return {gap, nearest.point, normal, part.feature, part.tangent, triangle, part.normal};
}

double Surface::Tree::least_distance(const Eigen::Vector3d& x) const
{
  if (n_queries < n_grid_cells && ++n_queries < n_grid_cells)
    return 0.;
  std::call_once(has_grid,
                 [this]
                 {
                   grid.emplace(nodes[0].lower, nodes[0].upper, n_grid_cells,
                                [this](const Eigen::Vector3d& at)
                                {
                                  const Nearest found = nearest(at, std::numeric_limits<double>::infinity());
                                  return std::copysign(std::sqrt(found.squared_distance), describe(at, found).gap);
                                });
                 });
  return grid->least_distance(x);
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
  const Nearest nearest = tree->nearest(x, infinity);
  if (nearest.facet == -1u) // only where x is not finite
  {
    const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(nan);
    return {nan, x, nowhere, Feature::face, Eigen::Vector3d::Zero(), 0, nowhere};
  }
  return tree->describe(x, nearest);
}

/// Share of a known distance that covers round-off. Beside a nearly flat edge the gap is a height and a little less
/// than the distance to the edge; the margin covers this difference too.
constexpr double margin = 1e-6;

std::optional<ClosestPoint> Surface::closest_point_within(const Eigen::Vector3d& x, double distance) const
{
  KnownDistance nothing;
  return closest_point_within(x, distance, nothing);
}

std::optional<ClosestPoint> Surface::closest_point_within(const Eigen::Vector3d& x, double distance,
                                                          KnownDistance& known) const
{
  const double to_box = tree->nodes[0].squared_distance(x);
  if (to_box > distance * distance)
    return std::nullopt;
  if (to_box == 0. && (1. - margin) * tree->least_distance(x) > distance)
    return std::nullopt;
  // A point inside the box may lie deep in the body; only the sign tells, so the search has no limit there.
  double squared_limit = to_box > 0. ? distance * distance : std::numeric_limits<double>::infinity();
  if (!std::isnan(known.signed_distance))
  {
    const double travelled = (x - known.at).norm();
    if ((1. - margin) * (known.signed_distance - travelled) > distance)
      return std::nullopt;
    const double farthest = (1. + margin) * (std::abs(known.signed_distance) + travelled) + tree->tiny;
    squared_limit = std::min(squared_limit, farthest * farthest);
  }
  const Nearest nearest = tree->nearest(x, squared_limit);
  if (nearest.facet == -1u)
    return std::nullopt;
  const ClosestPoint closest = tree->describe(x, nearest);
  known = {x, std::copysign(std::sqrt(nearest.squared_distance), closest.gap)};
  return closest.gap <= distance ? std::optional<ClosestPoint>(closest) : std::nullopt;
}

double Surface::least_gap(const Eigen::Vector3d& x, const KnownDistance& known) const
{
  const double to_box = std::sqrt(tree->nodes[0].squared_distance(x));
  const double least = to_box > 0. ? to_box : (1. - margin) * tree->least_distance(x);
  return std::isnan(known.signed_distance)
             ? least
             : std::max(least, (1. - margin) * (known.signed_distance - (x - known.at).norm()));
}
} // namespace kedge
