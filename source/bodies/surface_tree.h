// The bounding-volume tree of a surface, for the queries that descend it.
#pragma once

#include <atomic>
#include <kedge/bodies/distance_grid.h>
#include <kedge/bodies/surface.h>
#include <mutex>
#include <optional>
#include <utility>

namespace kedge
{
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

  double squared_distance(const Eigen::Vector3d& x) const
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

/// Closest point of a triangle by the Voronoi regions of its parts (Ericson 2005, Real-Time Collision
/// Detection, 5.1.5).
std::pair<Eigen::Vector3d, Part> project(const Facet& facet, const Eigen::Vector3d& x);
} // namespace surface_tree

struct Surface::Tree
{
  explicit Tree(TriangleMesh mesh_);

  surface_tree::Nearest nearest(const Eigen::Vector3d& x, double squared_limit) const;
  ClosestPoint describe(const Eigen::Vector3d& x, const surface_tree::Nearest& nearest) const;
  /// A distance (m) that the gap at x in the bounding box is not below; 0 where that is not known.
  double least_distance(const Eigen::Vector3d& x) const;

  TriangleMesh mesh;
  std::vector<surface_tree::Node> nodes;
  std::vector<surface_tree::Facet> facets;
  std::vector<std::array<surface_tree::PartData, surface_tree::n_parts>> parts; ///< per triangle
  double tiny = 0.; ///< below this distance (m) the direction to an edge or vertex is round-off

private:
  static constexpr unsigned int leaf_size = 4;
  /// Cells of the grid, and queries in the bounding box after which it is worth its set-up.
  static constexpr unsigned int n_grid_cells = 16384;
  mutable std::atomic<unsigned int> n_queries{0};
  mutable std::once_flag has_grid;
  mutable std::optional<DistanceGrid> grid;
  void grow(std::vector<unsigned int>::iterator begin, std::vector<unsigned int>::iterator end);
  void find_parts();
};
} // namespace kedge
