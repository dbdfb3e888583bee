// Signed distances from a closed triangulated surface, by a bounding-volume tree that kernels descend, too.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <kedge/base/kokkos.h>
#include <limits>

namespace kedge
{
/// Part of the surface that holds a closest point. Edges flatter than 1e-3 rad count as face, and so do vertices that
/// join only such edges. A vertex inside a straight edge counts as part of that edge.
enum class Feature
{
  face,
  edge,
  vertex
};

struct ClosestPoint
{
  double gap;                    ///< signed distance, m; negative inside
  Eigen::Vector3d point;         ///< on the surface, m
  Eigen::Vector3d normal;        ///< unit, outwards: d gap / d x
  Feature feature;               ///< where the point lies
  Eigen::Vector3d tangent;       ///< unit direction of the edge where feature is edge, else zero
  unsigned int triangle;         ///< one triangle that holds the point
  Eigen::Vector3d pseudo_normal; ///< unit, of the face, edge or vertex itself: for x that is hardly off it
};

/// Result of the last query for one point. It speeds up the next one, because the signed distance changes by no more
/// than the distance that the point travels.
struct KnownDistance
{
  Eigen::Vector3d at = Eigen::Vector3d::Zero();                      ///< m
  double signed_distance = std::numeric_limits<double>::quiet_NaN(); ///< m; not a number: nothing is known
};

namespace surface_tree
{
/// Parts of a triangle: its face, the edges from corner i to i + 1, the corners.
enum Part : unsigned int
{
  face,
  edge_0,
  edge_1,
  edge_2,
  vertex_0,
  vertex_1,
  vertex_2,
  n_parts
};

/// Data that a closest point takes from the part of the triangle on which it lies.
struct PartData
{
  Eigen::Vector3d normal; ///< pseudo-normal, unit
  Eigen::Vector3d tangent = Eigen::Vector3d::Zero();
  Feature feature = Feature::face;
};

/// A triangle in the form that the distance computation needs. Facets stand in the order of the tree's leaves.
struct Facet
{
  Eigen::Vector3d a, ab, ac;
  unsigned int triangle;
};

/// A box of the tree. Its children are the next node and `other`; a leaf has facets instead.
struct Node
{
  Eigen::Vector3d lower, upper;
  unsigned int other = 0, first_facet = 0, n_facets = 0;

  KEDGE_FUNCTION double squared_distance(const Eigen::Vector3d& x) const
  {
    return (lower - x).cwiseMax(x - upper).cwiseMax(0.).squaredNorm();
  }
};

struct Nearest
{
  double squared_distance;
  Eigen::Vector3d point;
  unsigned int facet = -1;
  Part part = face;
};

struct PointOfFacet
{
  Eigen::Vector3d point;
  Part part;
};

/// Closest point of a triangle by the Voronoi regions of its parts (Ericson 2005, Real-Time Collision
/// Detection, 5.1.5).
KEDGE_FUNCTION PointOfFacet project(const Facet& facet, const Eigen::Vector3d& x)
{
  const Eigen::Vector3d &a = facet.a, &ab = facet.ab, &ac = facet.ac;
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
} // namespace surface_tree

/// Distances at the centres of the cells of a box, which tell at once of most points that they are far from a surface:
/// the distance changes by no more than that between two points, so each value bounds those around it.
struct DistanceCells
{
  Eigen::Vector3d lower; ///< m
  double size;           ///< of a cell, m
  int n[3];
  const float* distance = nullptr; ///< m, rounded down; null: nothing is known

  std::size_t n_cells() const { return distance == nullptr ? 0 : static_cast<std::size_t>(n[0]) * n[1] * n[2]; }

  /// A distance (m) that the signed one at x is not below; 0 where the grid tells nothing.
  KEDGE_FUNCTION double least_distance(const Eigen::Vector3d& x) const
  {
    if (distance == nullptr)
      return 0.;
    const Eigen::Vector3d place = (x - lower) / size;
    int at[3];
    double squared = 0.; // from the centre of the cell
    for (int d = 0; d < 3; ++d)
    {
      if (!(place[d] >= 0. && place[d] < n[d]))
        return 0.;
      at[d] = static_cast<int>(place[d]);
      const double off = place[d] - at[d] - 0.5;
      squared += off * off;
    }
    const std::size_t cell = (static_cast<std::size_t>(at[2]) * n[1] + at[1]) * n[0] + at[0];
    const double least = distance[cell] - size * std::sqrt(squared);
    return least > 0. ? least : 0.;
  }
};

/// The tree of a surface where host or device can read it; who made it keeps its memory. Angle-weighted pseudo-normals
/// give the sign (Baerentzen & Aanaes 2005, doi 10.1109/TVCG.2005.49).
struct TriangleTree
{
  const surface_tree::Node* nodes;
  const surface_tree::Facet* facets;
  const surface_tree::PartData* parts; ///< surface_tree::n_parts per triangle
  std::size_t n_nodes, n_triangles;
  double tiny; ///< below this distance (m) the direction to an edge or vertex is round-off
  DistanceCells grid;

  /// Share of a known distance that covers round-off. Beside a nearly flat edge the gap is a height and a little less
  /// than the distance to the edge; the margin covers this difference too.
  static constexpr double margin = 1e-6;
  /// Squares of distances that differ by less, relatively, are equal: neither round-off nor the single precision of STL
  /// files must choose between them.
  static constexpr double same_distance = 1e-5;
  /// Squares of the distances between feet of perpendiculars, over those to the feet, below which the feet are the
  /// same.
  static constexpr double same_foot = 1e-4;
  static constexpr unsigned int most_feet = 8;

  /// `any`: the first that is found within the limit will do.
  KEDGE_FUNCTION surface_tree::Nearest nearest(const Eigen::Vector3d& x, double squared_limit, bool any = false) const;
  KEDGE_FUNCTION ClosestPoint describe(const Eigen::Vector3d& x, const surface_tree::Nearest& nearest) const;
  /// The same where several parts of the surface may be equally near, as inside a body on the bisector of an edge: then
  /// the normal is the mean of theirs, and `point` lies where its perpendicular ends. Where they cancel, as half way
  /// through a plate, or are many, as on the axis of a cylinder, the triangle with the least number counts.
  KEDGE_FUNCTION ClosestPoint describe_all(const Eigen::Vector3d& x, const surface_tree::Nearest& nearest) const;
  /// Whether gap <= distance, up to `margin` of it, for distance >= 0: what find_within() finds out, in less time where
  /// the gap does not matter.
  KEDGE_FUNCTION bool is_within(const Eigen::Vector3d& x, double distance) const;
  /// Finds the closest point if gap <= distance. This finds every point inside the body, however deep. A far point
  /// costs one comparison with the bounding box. `known` is what the last query for this point has left, and changes
  /// nothing but the time.
  KEDGE_FUNCTION bool find_within(const Eigen::Vector3d& x, double distance, KnownDistance& known,
                                  ClosestPoint& closest) const;
  /// A distance (m) that the gap at x is not below, from the bounding box and what the last query left in `known`; 0
  /// where these tell nothing.
  KEDGE_FUNCTION double least_gap(const Eigen::Vector3d& x, const KnownDistance& known) const;
};

KEDGE_FUNCTION surface_tree::Nearest TriangleTree::nearest(const Eigen::Vector3d& x, const double squared_limit,
                                                           const bool any) const
{
  struct Entry
  {
    unsigned int node;
    double squared_distance;
  };
  Entry stack[64]; // the tree is balanced: 64 levels are never reached
  surface_tree::Nearest best{squared_limit, {}};
  unsigned int size = 0;
  if (const double d = nodes[0].squared_distance(x); d <= squared_limit)
    stack[size++] = {0, d};
  while (size > 0)
  {
    // A box that was near enough when it was stacked may have become too far.
    const Entry entry = stack[--size];
    if (entry.squared_distance > best.squared_distance)
      continue;
    const surface_tree::Node& node = nodes[entry.node];
    for (unsigned int f = node.first_facet; f < node.first_facet + node.n_facets; ++f)
    {
      const surface_tree::PointOfFacet found = surface_tree::project(facets[f], x);
      const double squared_distance = (x - found.point).squaredNorm();
      if (squared_distance <= best.squared_distance)
        best = {squared_distance, found.point, f, found.part};
    }
    if (any && best.facet != -1u)
      break;
    if (node.n_facets > 0)
      continue;
    // The nearer child goes on top of the stack: it is searched first and tightens the bound for the other one.
    Entry near{entry.node + 1, nodes[entry.node + 1].squared_distance(x)};
    Entry far{node.other, nodes[node.other].squared_distance(x)};
    if (far.squared_distance < near.squared_distance)
    {
      const Entry other = near;
      near = far;
      far = other;
    }
    if (far.squared_distance <= best.squared_distance)
      stack[size++] = far;
    if (near.squared_distance <= best.squared_distance)
      stack[size++] = near;
  }
  return best;
}

KEDGE_FUNCTION ClosestPoint TriangleTree::describe(const Eigen::Vector3d& x, const surface_tree::Nearest& nearest) const
{
  const unsigned int triangle = facets[nearest.facet].triangle;
  const surface_tree::PartData& part = parts[surface_tree::n_parts * triangle + nearest.part];
  const Eigen::Vector3d away = x - nearest.point;
  const double height = part.normal.dot(away);
  // On a face the gap is the height above its plane, which passes smoothly through zero. Elsewhere the height gives
  // only the sign.
  if (part.feature == Feature::face)
  {
    // The foot of the perpendicular is more exact than barycentric coordinates of a slender triangle.
    const Eigen::Vector3d foot =
        nearest.part == surface_tree::face ? Eigen::Vector3d(x - height * part.normal) : nearest.point;
    return {height, foot, part.normal, part.feature, part.tangent, triangle, part.normal};
  }
  const double distance = std::sqrt(nearest.squared_distance), gap = std::copysign(distance, height);
  const Eigen::Vector3d normal = distance > tiny ? Eigen::Vector3d(away / gap) : part.normal;
  return {gap, nearest.point, normal, part.feature, part.tangent, triangle, part.normal};
}

KEDGE_FUNCTION ClosestPoint TriangleTree::describe_all(const Eigen::Vector3d& x,
                                                       const surface_tree::Nearest& nearest) const
{
  const ClosestPoint closest = describe(x, nearest);
  if (!(std::fabs(closest.gap) > tiny))
    return closest;
  ClosestPoint first = closest;
  const double limit = (1. + same_distance) * nearest.squared_distance;
  Eigen::Vector3d feet[most_feet], sum = closest.normal;
  feet[0] = nearest.point;
  unsigned int n_feet = 1, size = 0, stack[64];
  stack[size++] = 0;
  while (size > 0)
  {
    const unsigned int number = stack[--size];
    const surface_tree::Node& node = nodes[number];
    if (node.squared_distance(x) > limit)
      continue;
    for (unsigned int f = node.first_facet; f < node.first_facet + node.n_facets; ++f)
    {
      const surface_tree::PointOfFacet found = surface_tree::project(facets[f], x);
      const double squared_distance = (x - found.point).squaredNorm();
      bool is_new = squared_distance <= limit && n_feet < most_feet;
      for (unsigned int k = 0; k < n_feet && is_new; ++k)
        is_new = (found.point - feet[k]).squaredNorm() > same_foot * nearest.squared_distance;
      if (!is_new)
        continue;
      feet[n_feet++] = found.point;
      const ClosestPoint other = describe(x, {squared_distance, found.point, f, found.part});
      sum += other.normal;
      if (other.triangle < first.triangle)
        first = other;
    }
    if (node.n_facets == 0)
    {
      stack[size++] = node.other;
      stack[size++] = number + 1;
    }
  }
  if (n_feet == 1)
    return closest;
  const double length = sum.norm();
  if (length < margin || n_feet == most_feet)
    return first;
  const Eigen::Vector3d normal = sum / length;
  return {closest.gap, x - closest.gap * normal, normal, Feature::face, Eigen::Vector3d::Zero(), first.triangle,
          normal};
}

KEDGE_FUNCTION bool TriangleTree::is_within(const Eigen::Vector3d& x, const double distance) const
{
  const double to_box = nodes[0].squared_distance(x), least = grid.least_distance(x);
  if (to_box > distance * distance || (1. - margin) * least > distance)
    return false;
  if (nearest(x, distance * distance, true).facet != -1u)
    return true;
  if (to_box > 0. || least > 0.) // outside, and far
    return false;
  const surface_tree::Nearest found = nearest(x, std::numeric_limits<double>::infinity());
  return found.facet != -1u && describe(x, found).gap <= distance;
}

KEDGE_FUNCTION bool TriangleTree::find_within(const Eigen::Vector3d& x, const double distance, KnownDistance& known,
                                              ClosestPoint& closest) const
{
  const double to_box = nodes[0].squared_distance(x);
  if (to_box > distance * distance)
    return false;
  if (to_box == 0. && (1. - margin) * grid.least_distance(x) > distance)
    return false;
  // A point inside the box may lie deep in the body; only the sign tells, so the search has no limit there.
  double squared_limit = to_box > 0. ? distance * distance : std::numeric_limits<double>::infinity();
  if (known.signed_distance == known.signed_distance)
  {
    const double travelled = (x - known.at).norm();
    if ((1. - margin) * (known.signed_distance - travelled) > distance)
      return false;
    const double farthest = (1. + margin) * (std::fabs(known.signed_distance) + travelled) + tiny;
    if (farthest * farthest < squared_limit)
      squared_limit = farthest * farthest;
  }
  const surface_tree::Nearest found = nearest(x, squared_limit);
  if (found.facet == -1u)
    return false;
  closest = describe_all(x, found);
  known.at = x;
  known.signed_distance = std::copysign(std::sqrt(found.squared_distance), closest.gap);
  return closest.gap <= distance;
}

KEDGE_FUNCTION double TriangleTree::least_gap(const Eigen::Vector3d& x, const KnownDistance& known) const
{
  const double to_box = std::sqrt(nodes[0].squared_distance(x));
  const double least = to_box > 0. ? to_box : (1. - margin) * grid.least_distance(x);
  if (!(known.signed_distance == known.signed_distance))
    return least;
  const double by_known = (1. - margin) * (known.signed_distance - (x - known.at).norm());
  return by_known > least ? by_known : least;
}
} // namespace kedge
