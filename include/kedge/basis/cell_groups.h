// The particles of a rank by the cell that holds them, for quantities that are averaged over cells.
#pragma once

#include <kedge/basis/stencil.h>
#include <vector>

namespace kedge
{
/// Cell c holds the particles particle_begin[c] .. particle_begin[c + 1], at least one. Together they see the nodes
/// nodes[node_begin[c] .. node_begin[c + 1]), ascending.
struct CellGroups
{
  View<unsigned int*> particle_begin;
  View<unsigned int*> node_begin, nodes;
  // by particle, written by every stress update (assembly/volume_average.h)
  View<double*> volume_factor; ///< what stretches dF
  View<double*> pressure;      ///< mean stress that acts on the nodes, per volume change, Pa
  View<double*> spring;        ///< between the volume changes of the particles of a cell, Pa

  KEDGE_FUNCTION bool empty() const { return particle_begin.extent(0) == 0; }
  KEDGE_FUNCTION std::size_t n_cells() const { return empty() ? 0 : particle_begin.extent(0) - 1; }
};

/// Particles of one leaf must follow one another. In a leaf that is not full (`is_full`, by leaf) every particle forms
/// its own group.
CellGroups group_by_cell(const StencilSet& stencils, const std::vector<unsigned int>& leaf_of_particle,
                         const std::vector<unsigned char>& is_full);

/// By leaf, the group whose particles share the volume change of the leaf; -1 where there is none.
std::vector<int> groups_of_leaves(const CellGroups& cells, const std::vector<unsigned int>& leaf_of_particle,
                                  std::size_t n_leaves);
} // namespace kedge
