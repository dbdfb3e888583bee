// The kernels of explicit dynamics: forces along a path of many small increments, lumped mass, stable step.
#pragma once

#include <kedge/assembly/internal_force.h>

namespace kedge
{
/// Where the particles are on their way through a step: the stress follows the path, not the increment of the whole.
/// The laws' state variables follow it in the particles' trial state.
struct ParticlePath
{
  View<double* [6]> left_cauchy_green;   ///< elastic, exp(2 eps_e)
  View<double* [9]> inverse_deformation; ///< inverse of dF since the start of the step, of F-bar where it is on
};

/// At the committed state, which becomes the trial state.
ParticlePath begin_path(const ParticleArrays& particles);

/// Follows every particle to the nodal increments since the start of the step (m), writes its trial state and adds its
/// internal force (N) to `force`, as update_stress_and_force does. The plastic increments add up until the next path
/// begins. Returns the number of particles of this rank whose increment is not admissible; their force is left out.
template <int dim>
unsigned long advance_stress_and_force(const ParticleArrays& particles, const StencilSet& stencils,
                                       const Materials& materials, const NodalVector& increment,
                                       const ParticlePath& path, const NodalVector& force,
                                       const CellGroups& cells = {});

/// Adds m max(S_v, least share) to every node's mass (kg, one per local node); nodes with S_v = 0 get nothing.
void add_lumped_mass(const ParticleArrays& particles, const StencilSet& stencils, double least_share,
                     const View<double*>& mass);

/// Upper bound of the squared circular frequencies (1/s2) of this rank's soil with that mass: the largest of any
/// particle alone, since no system is faster than its fastest part (Irons & Treharne 1971). A particle with its share m
/// S_v of the mass has one of at most V/m times the largest eigenvalue of the elasticity, 3 bulk or 2 shear, times that
/// of the sum over nodes of grad S_v (x) grad S_v / S_v.
double largest_squared_frequency(const ParticleArrays& particles, const StencilSet& stencils,
                                 const Materials& materials, double least_share);
} // namespace kedge
