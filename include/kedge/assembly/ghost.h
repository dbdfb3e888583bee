// Ghost stabilisation: penalises jumps of the normal derivative across faces near the boundary of the soil.
#pragma once

#include <kedge/assembly/node_graph.h>
#include <kedge/basis/ghost_faces.h>

namespace kedge
{
/// Mass of pairs of nodes (kg), one number per entry of graph.column; it is the same for every component.
using NodalMass = View<double*>;

/// The jump of the normal derivative of a step's increment (root of the mean square over a face, no unit) at which
/// ghost faces begin to yield, and the share of their stiffness that never does. Without yield, faces in a shear band
/// carry far more than the soil can: a strip plate in clay is 2 % too strong, N_gamma 15 %, and steps of another size
/// give another answer.
constexpr double ghost_yield_jump = 1e-3, ghost_floor = 0.1;

/// Adds the force of the faces (N) for increments (m): stiffness times J u where the jump s of a face is small, and
/// floor + (1 - floor) / sqrt(1 + (s / yield)^2) of it in general, which has a convex potential.
template <int dim>
void add_ghost_force(const GhostFaces& faces, const View<double*>& increment, const View<double*>& force);

/// The derivative of that force, held by face.
struct LinearisedGhost
{
  View<double*> pull;              ///< J u of every node, dim numbers each, laid out as faces.nodes
  View<double*> secant, softening; ///< by face
};

template <int dim> LinearisedGhost linearise_ghost(const GhostFaces& faces, const View<double*>& increment);

/// Adds the derivative to the blocks of the faces' nodes; what a row has no column for goes to its
/// diagonal.
template <int dim>
void add_ghost_matrix(const GhostFaces& faces, const LinearisedGhost& derivative, const NodeGraph& graph,
                      const View<double*>& values);

/// Adds the derivative times `direction` (m) to `force` (N).
template <int dim>
void add_linearised_ghost(const GhostFaces& faces, const LinearisedGhost& derivative, const View<double*>& direction,
                          const View<double*>& force);

/// Adds the ghost mass of the faces. It does not change the total mass (Coombs 2023, doi 10.1002/nme.7332).
void add_ghost_mass(const GhostFaces& faces, const NodeGraph& graph, const NodalMass& mass);
} // namespace kedge
