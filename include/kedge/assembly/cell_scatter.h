// How the particles of a cell add to its nodes where several threads share the cell.
#pragma once

#include <kedge/basis/cell_groups.h>

namespace kedge
{
/// Cells of several particles, and for each of their nodes and particles what the particle calls the node: each node is
/// one thread's, which adds up the particles without meeting another one. place[begin[i] + v n + p] belongs to node v
/// and particle p of the n particles of cell sharing[i].
struct CellScatter
{
  static constexpr unsigned char nothing = 255; ///< the particle does not see the node

  View<unsigned int*> sharing, alone; ///< cells of several particles and of one
  View<std::size_t*> begin;
  View<unsigned char*> place;
  View<double* [2]> change; ///< workspace by particle: what it adds to the two sums of its cell

  bool empty() const { return begin.extent(0) == 0; }
};

CellScatter make_cell_scatter(const StencilSet& stencils, const CellGroups& cells);
} // namespace kedge
