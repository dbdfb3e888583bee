// Ghost stabilisation: jumps of the normal derivative across faces near the soil's boundary are made expensive.
#pragma once

#include <kedge/assembly/node_graph.h>
#include <kedge/basis/ghost_faces.h>

namespace kedge
{
/// Adds weight J d, for every component of the nodal vector d, to `force`; `weight` holds one number per face, the
/// faces' stiffness for increments (m) or their mass for accelerations (m/s2).
template <int dim>
void add_ghost_force(const GhostFaces& faces, const View<double*>& weight, const View<double*>& nodal,
                     const View<double*>& force);

/// Adds weight J times the identity to the blocks of the faces' nodes.
template <int dim>
void add_ghost_matrix(const GhostFaces& faces, const View<double*>& weight, const NodeGraph& graph,
                      const View<double*>& values);
} // namespace kedge
