// Removal of the particles with which no step can be solved.
#pragma once

#include <kedge/particles/particle_set.h>

namespace kedge
{
/// Particles removed over all ranks, by reason.
struct HopelessParticles
{
  long long distorted = 0; ///< not finite, or volume or domain beyond what soil can do
  long long isolated = 0;  ///< no other particle's domain near
  double mass = 0.;        ///< of both, kg (2-D: per metre)
};

/// Removes distorted particles, and isolated ones where they have no inertia.
///
/// Distorted: an entry that is not finite, a domain without extent, det F below 0.1, or an elastic volume outside [0.1,
/// 10] of the initial one. Soil without any voids has 1 / (1 + e0) of its volume, a quarter for a void ratio of 3. Soil
/// that opens without stress is no reason: F is bounded at a tenfold volume as it is committed. Nor is shear, however
/// large: in soil that flows around a body F grows without bound, and the stress does not depend on F.
///
/// Isolated: active, and no other sound active particle's domain reaches into its cell or a cell across one of that
/// cell's faces. Such a particle hangs on nodes of its own, without stiffness but its own: nothing holds it in a static
/// step. With inertia (`has_inertia`) it flies on and stays.
///
/// Collective. Domains of particles that wait for splitting count as they are.
template <int dim>
HopelessParticles remove_hopeless_particles(ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh,
                                            bool has_inertia);
} // namespace kedge
