// Ghost stabilisation: penalises jumps of the normal derivative across faces near the boundary of the soil.
#pragma once

#include <kedge/assembly/node_graph.h>
#include <kedge/basis/ghost_faces.h>

namespace kedge
{
/// Mass of pairs of nodes (kg), one number per entry of graph.column; it is the same for every component.
using NodalMass = View<double*>;

/// Adds weight J d to `force` for every component of the nodal vector d. `weight` holds one number per face: the faces'
/// stiffness if d are increments (m), their mass if d are accelerations (m/s2).
template <int dim>
void add_ghost_force(const GhostFaces& faces, const View<double*>& weight, const View<double*>& nodal,
                     const View<double*>& force);

/// Adds weight J times the identity to the blocks of the faces' nodes.
template <int dim>
void add_ghost_matrix(const GhostFaces& faces, const View<double*>& weight, const NodeGraph& graph,
                      const View<double*>& values);

/// Adds the ghost mass of the faces. It does not change the total mass (Coombs 2023, doi 10.1002/nme.7332).
void add_ghost_mass(const GhostFaces& faces, const NodeGraph& graph, const NodalMass& mass);
} // namespace kedge
