// The initial material points: rows in layers, overburden stiffness, initial stress.
#pragma once

#include <kedge/particles/particle_set.h>

namespace kedge
{
/// Horizontal slice of the block that becomes one row of particles.
struct ParticleRow
{
  double bottom, top;     ///< m
  unsigned int layer;     ///< from 0, from the surface down
  double vertical_stress; ///< overburden at its centre, Pa, compression positive
};

/// Rows from the base up. Rows follow the cells (`row_height`, m); a row that a layer interface passes through is cut
/// there, so that interfaces stay exact. The topmost layer takes what rounding adds to the block's height.
std::vector<ParticleRow> make_rows(double row_height, double block_height, const std::vector<Layer>& layers,
                                   double gravity);

/// Fills the soil block with particles, still without stiffness, state and stress. Throws InputError where these cannot
/// be had: under an initial stress that crushes the soil. `gravity` is its magnitude in m/s2.
template <int dim>
void generate_particles(ParticleSet<dim>& particles, BackgroundMesh<dim>& mesh,
                        const MaterialPointParameters& parameters, double gravity);

/// Gives all particles stiffness, state and initial stress by their own depth, as long as the soil has not moved:
/// pieces of a particle that is split then start with what belongs to its centre.
template <int dim>
void set_state_at_rest(ParticleSet<dim>& particles, const GridLayout<dim>& grid,
                       const MaterialPointParameters& parameters, double gravity);
} // namespace kedge
