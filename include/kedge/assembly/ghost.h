// Ghost stabilisation: jumps of the normal derivative across faces near the soil's boundary are made expensive.
#pragma once

#include <kedge/assembly/node_graph.h>

namespace kedge
{
/// Scalar face matrices J (Coombs 2023, doi 10.1002/nme.7332) of the stabilised faces, times their stiffness: face f
/// couples the nodes lists.nodes[lists.begin[f] .. ) and has its n x n matrix at value[value_begin[f]], N/m.
struct GhostFaces
{
  NodeLists lists;
  View<std::size_t*> value_begin;
  View<double*> value;

  std::size_t n_faces() const { return lists.begin.extent(0) == 0 ? 0 : lists.begin.extent(0) - 1; }
};

/// Adds J d, for every component of the increments d (m), to `force`.
template <int dim>
void add_ghost_force(const GhostFaces& faces, const View<double*>& increment, const View<double*>& force);

/// Adds J times the identity to the blocks of the faces' nodes.
template <int dim> void add_ghost_tangent(const GhostFaces& faces, const NodeGraph& graph, const View<double*>& values);
} // namespace kedge
