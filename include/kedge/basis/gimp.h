// Discrete GIMP basis: the shape functions of the mesh averaged over each particle's box.
#pragma once

#include <kedge/basis/cell_quadrature.h>
#include <kedge/basis/stencil.h>
#include <kedge/mesh/leaf_table.h>
#include <vector>

namespace kedge
{
/// Share of a box that lies in one leaf.
struct Overlap
{
  unsigned int leaf;
  double fraction; ///< of the clipped box's volume
};

/// Value and gradient (1/m) at one true node, by its local number in the leaf table.
template <int dim> struct NodeShare
{
  unsigned int node;
  double value;
  std::array<double, dim> gradient;
};

template <int dim> struct BoxParts;

/// Shape function averages S_v and grad S_v of one box (centre, half-widths, m) over the leaves that it overlaps
/// (Bardenhagen & Kober 2004; one-point integration per overlap box is exact, Bird et al. 2026, arXiv:2606.09275).
/// Overlaps below 1e-11 of the box are ignored. A box that reaches beyond the window or the known leaves is clipped and
/// renormalised. The object keeps workspace between calls, so each thread needs its own.
template <int dim> class BoxAverage
{
public:
  explicit BoxAverage(const LeafTable<dim>& table);

  /// Leaves that the box overlaps, with their fractions (sum 1). Empty if the box lies outside the window.
  const std::vector<Overlap>& find_overlaps(const std::array<double, dim>& centre,
                                            const std::array<double, dim>& half_width);
  /// Centre of the part of the box that lies in the overlap's leaf, m.
  std::array<double, dim> middle_of(const Overlap& overlap) const;
  /// Node shares of the box of the last find_overlaps(), in the order in which its leaves name the nodes. With
  /// corrections, one per leaf, gradients are those of the corrected quadrature.
  const std::vector<NodeShare<dim>>& average(const std::vector<CellCorrection<dim>>& corrections = {});
  /// The factor of the volume that belongs to the last average().
  double volume_factor() const { return factor; }
  /// Adds the overlaps of the last find_overlaps(), with what the corrections make of them.
  void append_to(BoxParts<dim>& parts, const std::vector<CellCorrection<dim>>& corrections) const;

private:
  const LeafTable<dim>& table;
  std::array<double, dim> lower, upper;
  std::vector<unsigned int> candidates;
  std::vector<Overlap> overlaps;
  std::vector<NodeShare<dim>> shares;
  double factor = 1.;
};

/// Adds values and gradients of a leaf's true nodes at a point x (m) of the leaf, times a weight, to `shares`.
template <int dim>
void add_leaf_shape(const LeafTable<dim>& table, unsigned int leaf, const std::array<double, dim>& x, double weight,
                    std::vector<NodeShare<dim>>& shares);

/// The particles of a rank with their patterns, before nodes are numbered: nodes are local numbers of the leaf table.
struct HostStencils
{
  std::vector<unsigned int> pattern_node_begin, pattern_nodes, pattern_particle_begin, pattern_particles,
      pattern_of_particle;
  std::vector<std::size_t> value_begin;
  std::vector<double> value, gradient, volume_factor;
};

/// The parts of the particles' boxes in the leaves, as build_stencils() found them.
template <int dim> struct BoxParts
{
  std::vector<std::size_t> begin;             ///< by particle, and the end
  std::vector<unsigned int> leaf;             ///< by part
  std::vector<double> weight;                 ///< over the particle's initial volume
  std::vector<std::array<double, dim>> place; ///< where gradients are taken, m
};

/// Builds the stencils of all particles. `leaf_of_particle` serves only to find equal patterns; particles of one leaf
/// must be consecutive. With `point_basis` every box shrinks to its centre (standard MPM). `corrections`, one per leaf
/// or none, are those of the quadrature of full cells. `parts` receives the overlaps, if it is given. Throws
/// SolverError if a particle lies outside the window.
template <int dim>
HostStencils build_stencils(const LeafTable<dim>& table, const std::vector<std::array<double, dim>>& centre,
                            const std::vector<std::array<double, dim>>& half_width,
                            const std::vector<unsigned int>& leaf_of_particle, bool point_basis,
                            const std::vector<CellCorrection<dim>>& corrections = {}, BoxParts<dim>* parts = nullptr);

/// Renames the nodes by `number` (leaf-table node -> active node), sorts the nodes of each pattern and copies
/// everything to the device.
template <int dim> StencilSet upload_stencils(HostStencils&& host, const std::vector<unsigned int>& number);
} // namespace kedge
