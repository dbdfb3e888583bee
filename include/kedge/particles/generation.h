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

/// Fills the soil block with particles and gives them stiffness and initial stress. `gravity` is its magnitude in m/s2.
template <int dim>
void generate_particles(ParticleSet<dim>& particles, BackgroundMesh<dim>& mesh,
                        const MaterialPointParameters& parameters, double gravity);
} // namespace kedge
