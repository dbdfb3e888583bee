// The bounding-volume tree of a surface, for the queries that descend it.
#pragma once

#include <atomic>
#include <kedge/bodies/distance_grid.h>
#include <kedge/bodies/surface.h>
#include <mutex>
#include <optional>

namespace kedge
{
struct Surface::Tree
{
  explicit Tree(TriangleMesh mesh_);

  /// For one query, or `n_queries` of them: sets the grid up when it is worth that.
  TriangleTree on_host(std::size_t n_queries = 1) const;
  TriangleTree on_device(std::size_t n_queries) const;

  TriangleMesh mesh;
  std::vector<surface_tree::Node> nodes;
  std::vector<surface_tree::Facet> facets;
  std::vector<surface_tree::PartData> parts; ///< n_parts per triangle
  double tiny = 0.; ///< below this distance (m) the direction to an edge or vertex is round-off

private:
  static constexpr unsigned int leaf_size = 4;
  /// Cells of the grid, and queries after which it is worth its set-up.
  static constexpr std::size_t n_grid_cells = 16384;
  mutable std::atomic<std::size_t> n_asked{0};
  mutable std::once_flag has_grid;
  mutable std::optional<DistanceGrid> grid;
  /// Copies that the device reads.
  mutable View<surface_tree::Node*> device_nodes;
  mutable View<surface_tree::Facet*> device_facets;
  mutable View<surface_tree::PartData*> device_parts;
  mutable View<float*> device_grid;
  void grow(std::vector<unsigned int>::iterator begin, std::vector<unsigned int>::iterator end);
  void find_parts();
};
} // namespace kedge
