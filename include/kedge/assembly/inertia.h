// Inertia of the soil at the nodes: masses, projection of the particles' motion, Newmark's forces.
#pragma once

#include <kedge/assembly/ghost.h>
#include <kedge/assembly/system.h>
#include <kedge/time/newmark.h>

namespace kedge
{
/// Adds M_ab = sum over particles of m S_a S_b to a symmetric matrix. `lumped`: adds its row sums to the diagonal
/// instead.
void add_particle_mass(const ParticleArrays& particles, const StencilSet& stencils, bool lumped, const NodeGraph& graph,
                       const NodalMass& mass);

/// Adds factor * M x to `result`; `x` and `result` have dim entries per local node.
void add_mass_times(const NodeGraph& graph, const NodalMass& mass, double factor, const NodalVector& x,
                    const NodalVector& result);

/// Adds factor * M to the diagonals of the blocks of `values`, laid out by `graph`; what its rows have no column for
/// goes to their diagonal. `mass_graph` is that of M.
void add_mass_matrix(const NodeGraph& mass_graph, const NodalMass& mass, double factor, const NodeGraph& graph,
                     const View<double*>& values);

/// Adds m S_v q to `result` for a quantity q of every particle. If q is the velocity, this is the momentum (kg m/s).
void add_particle_momentum(const ParticleArrays& particles, const StencilSet& stencils,
                           const View<double* [3]>& quantity, const NodalVector& result);

/// How the nodes move at the start of a step, and their mass.
struct NodalMotion
{
  NodalMass mass;
  NodalVector velocity, acceleration; ///< m/s; m/s2, 0 where no step depends on it
};

/// The accelerations that forces (N) give the nodes at rest, on all local nodes: M^-1 b, or near to it without ghost
/// mass, and exactly that where all nodes move alike. M couples nodes as `graph` says, which may be a local one.
/// Constrained dofs of `system` become zero, also in the forces. M^-1 itself makes immense accelerations of what a step
/// leaves unbalanced at nodes into whose cells soil reaches by a hair: by a share e of a box, their force is of order e
/// and their mass of e^4. Throws SolverError if the system cannot be solved. Collective.
NodalVector find_accelerations(TpetraVector& forces, const NodeGraph& graph, const NodalMass& mass,
                               const System& system, bool has_ghost_mass);

/// Projects the particles' velocity and, if asked to, acceleration (else 0): M v = sum of m S v_p, M coupling nodes as
/// `graph` says. Throws SolverError if the system cannot be solved. Collective.
NodalMotion project_motion(const ParticleArrays& particles, const StencilSet& stencils, const GhostFaces& faces,
                           bool lumped, bool with_acceleration, const NodeGraph& graph, const System& system);

/// Adds M a (N), where a is Newmark's acceleration for the nodal increments (m).
void add_inertia_force(const NodeGraph& graph, const NodalMotion& motion, const Newmark& newmark,
                       const NodalVector& increment, const NodalVector& force);

/// FLIP (Brackbill & Ruppel 1986): change of the particles' velocity in the step, and their new acceleration.
ParticleMotion particle_motion(const StencilSet& stencils, const NodalMotion& motion, const Newmark& newmark,
                               const NodalVector& increment);
} // namespace kedge
