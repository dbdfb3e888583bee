// Discrete GIMP basis: the shape functions of the mesh averaged over each particle's box.
#pragma once

#include <kedge/basis/box_parts.h>
#include <kedge/basis/cell_quadrature.h>
#include <kedge/basis/stencil.h>
#include <vector>

namespace kedge
{
/// Value and gradient (1/m) at one true node, by its local number in the leaf table.
template <int dim> struct NodeShare
{
  unsigned int node;
  double value;
  std::array<double, dim> gradient;
};

/// Adds values and gradients of a leaf's true nodes at a point x (m) of the leaf, times a weight, to `shares`.
template <int dim>
void add_leaf_shape(const LeafTable<dim>& table, unsigned int leaf, const std::array<double, dim>& x, double weight,
                    std::vector<NodeShare<dim>>& shares);

/// Gradients (1/m) of a leaf's true nodes at a point x (m) of the leaf, in the order in which it names them.
template <int dim>
void find_leaf_gradients(const LeafTable<dim>& table, unsigned int leaf, const std::array<double, dim>& x,
                         std::vector<std::array<double, dim>>& gradients);

/// The particles of a rank with their patterns, before nodes are numbered: nodes are local numbers of the leaf table.
struct HostStencils
{
  std::vector<unsigned int> pattern_node_begin, pattern_nodes, pattern_particle_begin, pattern_particles,
      pattern_of_particle;
  std::vector<std::size_t> value_begin;
  HostView<double*> value, gradient, volume_factor;
};

/// Shape functions S_v and grad S_v, averaged over the particles' boxes (Bardenhagen & Kober 2004; one point per part
/// of a box is exact, Bird et al. 2026, arXiv:2606.09275), in stencils of all particles. `corrections`, one per leaf or
/// none, are those of the quadrature of full cells, which gradients follow. Every box must have parts.
template <int dim>
HostStencils build_stencils(const LeafTable<dim>& table, const BoxParts<dim>& parts,
                            const std::vector<CellCorrection<dim>>& corrections = {});

/// Renames the nodes by `number` (leaf-table node -> active node), sorts the nodes of each pattern and copies
/// everything to the device.
template <int dim> StencilSet upload_stencils(HostStencils&& host, const std::vector<unsigned int>& number);
} // namespace kedge
