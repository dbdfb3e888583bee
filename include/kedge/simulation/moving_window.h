// The window of active soil moves along with the bodies.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <kedge/particles/particle_set.h>

namespace kedge
{
/// Bounds of all surfaces as they stand, along the axes of the mesh.
template <int dim> Extent<dim> extent_of(const RigidSystems& bodies);

/// Gives the mesh this window, deletes the particles that it leaves behind for good and loads the others that are in
/// it. Returns the number deleted over all ranks. Collective.
template <int dim>
long long move_window(BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles, const Window<dim>& window,
                      const BoundaryTrack& track);
} // namespace kedge
