#include <cmath>
#include <kedge/assembly/deformation.h>
#include <kedge/assembly/force_sizes.h>

namespace kedge
{
template <int dim>
void add_internal_force_sizes(const ParticleArrays& particles, const StencilSet& stencils, const NodalVector& size)
{
  Kokkos::parallel_for(
      "sizes of internal forces", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n),
      KOKKOS_LAMBDA(const unsigned int p) {
        const Eigen::Matrix3d to_start = inverse(matrix_of(particles.trial_deformation, p));
        const Eigen::Matrix3d flux = integration_volume(particles, stencils, p) *
                                     full_matrix(row_of(particles.trial_stress, p)) * to_start.transpose();
        const ParticleNodes at = nodes_of(stencils, p);
        const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
        for (unsigned int v = 0; v < at.n; ++v)
        {
          double square = 0.;
          for (int c = 0; c < dim; ++c)
          {
            double f = 0.;
            for (int j = 0; j < dim; ++j)
              f += flux(c, j) * gradient[dim * v + j];
            square += f * f;
          }
          add_to(size(static_cast<std::size_t>(dim) * at.node[v]), std::sqrt(square));
        }
      });
}

void add_force_sizes(const unsigned int dim, const NodalVector& force, const NodalVector& size)
{
  Kokkos::parallel_for(
      "sizes of nodal forces", Kokkos::RangePolicy<ExecutionSpace>(0, force.extent(0) / dim),
      KOKKOS_LAMBDA(const std::size_t v) { size(dim * v) += size_at(dim, force, v); });
}

template void add_internal_force_sizes<2>(const ParticleArrays&, const StencilSet&, const NodalVector&);
template void add_internal_force_sizes<3>(const ParticleArrays&, const StencilSet&, const NodalVector&);
} // namespace kedge
