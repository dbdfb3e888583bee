// The shape functions of all particles of a rank in plain arrays, the form that kernels need.
#pragma once

#include <kedge/base/kokkos.h>

namespace kedge
{
/// Particles that see the same nodes form a pattern. Pattern k holds the nodes
/// pattern_nodes[pattern_node_begin[k] .. pattern_node_begin[k + 1]), ascending, and the particles
/// pattern_particles[pattern_particle_begin[k] .. pattern_particle_begin[k + 1]). Particle p with n nodes has its
/// values S_v(p) at value[value_begin[p] + v] and its gradients (1/m) at gradient[dim * (value_begin[p] + v) + axis].
/// Stresses are integrated over volume_factor[p] times the particle's initial volume V0: 1 unless cells correct their
/// quadrature (cell_quadrature.h).
struct StencilSet
{
  unsigned int dim = 3;
  std::size_t n_particles = 0, n_patterns = 0;
  unsigned int max_nodes = 0; ///< most nodes of any pattern
  View<unsigned int*> pattern_node_begin, pattern_nodes;
  View<unsigned int*> pattern_particle_begin, pattern_particles;
  View<unsigned int*> pattern_of_particle;
  View<std::size_t*> value_begin;
  View<double*> value, gradient, volume_factor;
};
} // namespace kedge
