// Bodies that are in the soil from the start.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <kedge/particles/particle_set.h>

namespace kedge
{
/// Removes the particles whose centre lies inside a body and loads the others. Returns the number removed. Collective.
template <int dim> long long remove_buried_particles(ParticleSet<dim>& particles, const RigidSystems& bodies);
} // namespace kedge
