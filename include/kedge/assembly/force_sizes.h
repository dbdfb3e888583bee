// Sizes of the forces that meet at the nodes: what residuals are compared with.
#pragma once

#include <cmath>
#include <kedge/assembly/internal_force.h>

namespace kedge
{
/// Size of the vector at a node, of a nodal one with dim entries per node.
template <typename Nodal>
KEDGE_FUNCTION double size_at(const unsigned int dim, const Nodal& nodal, const std::size_t node)
{
  double square = 0.;
  for (unsigned int d = 0; d < dim; ++d)
    square += nodal(dim * node + d) * nodal(dim * node + d);
  return std::sqrt(square);
}

/// Adds |V0 tau grad_x S_v| (N) of every particle to entry dim * v of `size`: its trial stress and dF are
/// those of the last update_stress_and_force(). Opposite forces of neighbours add up.
template <int dim>
void add_internal_force_sizes(const ParticleArrays& particles, const StencilSet& stencils, const NodalVector& size);

/// Adds the length of every node's part of `force` (dim per local node, N, sums of all ranks or of this one) to entry
/// dim * v of `size`.
void add_force_sizes(unsigned int dim, const NodalVector& force, const NodalVector& size);
} // namespace kedge
