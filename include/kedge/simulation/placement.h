// How bodies meet the soil at the start of a stage: in it, or on its surface.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <kedge/particles/particle_set.h>

namespace kedge
{
/// Removes the particles whose centre lies inside a body and loads the others. Returns the number removed. Collective.
template <int dim> long long remove_buried_particles(ParticleSet<dim>& particles, const RigidSystems& bodies);

/// Moves all bodies vertically by one amount so that their lowest surface point rests on the soil as it is now: on the
/// highest domain below the box around all surfaces. Soil that has settled under its weight lies lower than it was
/// drawn. Without soil there the bodies stay. Collective.
template <int dim> void place_on_soil(RigidSystems& bodies, const ParticleSet<dim>& particles, MPI_Comm communicator);
} // namespace kedge
