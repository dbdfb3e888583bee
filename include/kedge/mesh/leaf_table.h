// The leaf cells that a rank knows, as plain arrays: boxes, nodes, and a tree for finding them.
#pragma once

#include <array>
#include <cstdint>
#include <kedge/mesh/partition.h>
#include <kedge/mesh/window.h>
#include <vector>

namespace kedge
{
/// Leaves owned by this rank and the ghost leaves around them. The shape functions of a leaf belong to its "true"
/// nodes: the share of a hanging vertex goes to the nodes that it hangs on.
template <int dim> struct LeafTable
{
  static constexpr unsigned int n_vertices = 1u << dim;

  struct Leaf
  {
    std::array<double, dim> lower; ///< lower corner, m
    double size;                   ///< edge, m
    unsigned int node_begin;       ///< first entry in `nodes`
    unsigned int weight_begin;     ///< first entry in `weights`; unused if regular
    unsigned short n_nodes;        ///< number of true nodes
    bool regular;                  ///< no hanging vertex: nodes are the vertices, in lexicographic order
    bool owned;                    ///< owned by this rank
    unsigned int owner;            ///< rank that owns the leaf
    int tree_level;                ///< refinement level of the deal.II cell
    int tree_index;                ///< index of the deal.II cell on its level
  };

  /// Octree without pointers. An entry >= 0 is the position of the first of 2^dim consecutive children, an entry < 0
  /// stands for leaf -1 - entry, and `unknown` marks parts that other ranks own. The first entries are the forest's
  /// trees, x fastest.
  static constexpr std::int32_t unknown = INT32_MIN;
  std::vector<std::int32_t> tree;
  Partition<dim> partition;
  std::array<unsigned int, dim> base_cells{};
  double base_size = 0.;
  Window<dim> window; ///< where soil is active

  /// The window's ends along an axis, m.
  double lower_end(const unsigned int axis) const { return base_size * window.lower[axis]; }
  double upper_end(const unsigned int axis) const { return base_size * window.upper[axis]; }
  bool in_window(const Leaf& leaf) const;

  std::vector<Leaf> leaves;
  std::vector<unsigned int> nodes; ///< local node numbers of each leaf's true nodes
  /// weights[vertex * n_nodes + node] of the leaves that are not regular: N_node = sum over vertices of weight *
  /// N_vertex.
  std::vector<double> weights;

  std::vector<long long> node_ids;                    ///< global number of each local node
  std::vector<std::array<double, dim>> node_position; ///< m
  std::vector<unsigned int> node_owner_is_me;         ///< 1 where this rank owns the node
  long long n_global_nodes = 0;
  long long n_owned_nodes = 0; ///< nodes that this rank numbers, including hanging ones, which are not listed here

  /// Leaf that holds x, or -1 if x is outside the grid or in an unknown part. A point on a face belongs to the upper
  /// cell, except on the upper boundary of the grid.
  int find_leaf(const std::array<double, dim>& x) const;
  /// Rank that owns the leaf that holds x, wherever that is; -1 outside the grid.
  int find_owner(const std::array<double, dim>& x) const;

  /// The half-widths (m) of a box around x that reach no farther than through the neighbours of the owned leaf that
  /// holds x: each is cut to the distance from x to the nearer face of that leaf plus the edge of the smallest
  /// neighbour. What lies behind neighbours is known to one rank and not to the next, so boxes that reach there would
  /// give results that depend on the ranks.
  std::array<double, dim> within_neighbours(unsigned int leaf, const std::array<double, dim>& x,
                                            const std::array<double, dim>& half_width) const;

  /// Appends the leaves whose interior meets the open box (lower, upper), in tree order.
  void find_leaves(const std::array<double, dim>& lower, const std::array<double, dim>& upper,
                   std::vector<unsigned int>& found) const;

private:
  bool in_grid(const std::array<double, dim>& x) const;
};
} // namespace kedge
