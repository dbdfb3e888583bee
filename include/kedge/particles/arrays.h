// Particle data as the kernels see them: plain arrays, one entry per particle of this rank.
#pragma once

#include <kedge/materials/laws.h>

namespace kedge
{
/// The laws' state variables, a row of neighbours in memory for each particle: the laws read and write them in place.
using StateView = Kokkos::View<double * [Laws::max_state], Kokkos::LayoutRight, MemorySpace>;

/// What the kernels read and write, one entry per particle of this rank. Trial data become committed only through
/// ParticleSet::commit.
struct ParticleArrays
{
  std::size_t n = 0;
  View<double* [6]> elastic_left_cauchy_green; ///< committed: exp(2 eps_e)
  View<double*> young, initial_volume, mass;   ///< committed
  View<unsigned int*> layer;                   ///< committed
  View<double*> cell_size;                     ///< edge of the cell in which the particle is, m
  View<double*[3]> velocity, acceleration;     ///< committed, m/s, m/s2
  View<double*[6]> trial_strain, trial_stress; ///< elastic logarithmic strain; Kirchhoff stress, Pa
  View<double*> trial_plastic;                 ///< increment of the equivalent plastic strain
  StateView state, trial_state;                ///< the laws' state variables: committed; at the step's end
};

/// What a dynamic step makes of the particles' motion.
struct ParticleMotion
{
  View<double*[3]> velocity_change, acceleration; ///< m/s, m/s2
};

/// Result of a step per particle, for the commit.
struct ParticleIncrements
{
  View<double* [3]> displacement;         ///< m
  View<double* [9]> deformation_gradient; ///< dF of the step
  ParticleMotion motion;                  ///< empty after a static step, which leaves the particles at rest
};
} // namespace kedge
