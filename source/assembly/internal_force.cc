#include <kedge/assembly/deformation.h>
#include <kedge/assembly/internal_force.h>
#include <kedge/assembly/volume_average.h>
#include <kedge/materials/stress_lanes.h>

namespace kedge
{
namespace
{
/// Follows deform(), and share_pressure() with F-bar.
template <int dim> struct StressKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  Materials materials;
  View<double*> factor, pressure; ///< F-bar's, by particle; empty without it
  View<double*> force;

  static constexpr int width = points_together;

  KEDGE_FUNCTION void operator()(const std::size_t batch, unsigned long& inverted) const
  {
    const unsigned int first = width * batch, rest = particles.n - first, n = rest < width ? rest : width;
    StressLanes<width> lanes;
    for (unsigned int l = 0; l < width; ++l)
    {
      const unsigned int p = first + (l < n ? l : 0);
      lanes.trial.set(l, trial_frame<dim>(particles, factor, p));
      lanes.point[l] = {particles.young(p), particles.cell_size(p), &particles.state(p, 0)};
      lanes.material[l] = &materials(particles.layer(p));
      lanes.next_state[l] = &particles.trial_state(p, 0);
      lanes.admissible[l] = l < n;
    }
    lanes.trial.find_strains();
    lanes.respond();
    double stress[6][width], strain[6][width];
    lanes.trial.turn(lanes.stress, stress);
    lanes.trial.turn(lanes.elastic_strain, strain);
    for (unsigned int l = 0; l < n; ++l)
    {
      const unsigned int p = first + l;
      if (!lanes.admissible[l])
      {
        ++inverted;
        continue;
      }
      SymmetricTensor acting;
      for (int i = 0; i < 6; ++i)
      {
        acting[i] = particles.trial_stress(p, i) = stress[i][l];
        particles.trial_strain(p, i) = strain[i][l];
      }
      particles.trial_plastic(p) = lanes.plastic_increment[l];
      const Eigen::Matrix3d dF = matrix_of(particles.trial_deformation, p);
      if (pressure.extent(0) > 0)
        acting = with_mean_stress<dim>(acting, determinant(dF) * pressure(p));
      add_internal_force<dim>(particles, stencils, p, acting, inverse(dF), force);
    }
  }
};
} // namespace

template <int dim>
unsigned long update_stress_and_force(const ParticleArrays& particles, const StencilSet& stencils,
                                      const Materials& materials, const NodalVector& increment,
                                      const NodalVector& force, const CellGroups& cells)
{
  deform<dim>(particles, stencils, increment);
  share_pressure<dim>(particles, stencils, cells, materials);
  constexpr std::size_t width = StressKernel<dim>::width;
  unsigned long n_inverted = 0;
  Kokkos::parallel_reduce(
      "stress and internal force", Kokkos::RangePolicy<ExecutionSpace>(0, (particles.n + width - 1) / width),
      StressKernel<dim>{particles, stencils, materials, cells.volume_factor, cells.pressure, force}, n_inverted);
  return n_inverted;
}

template <int dim>
void add_weight(const ParticleArrays& particles, const StencilSet& stencils, const std::array<double, 3>& gravity,
                const double factor, const NodalVector& force)
{
  double g[dim];
  for (int d = 0; d < dim; ++d)
    g[d] = factor * gravity[d];
  const Eigen::Map<const Eigen::Matrix<double, dim, 1>> map(g);
  const Eigen::Matrix<double, dim, 1> acceleration = map;
  Kokkos::parallel_for(
      "weight", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n), KOKKOS_LAMBDA(const unsigned int p) {
        add_weighted_by_mass(particles, stencils, dim, p, acceleration.data(), force);
      });
}

View<double* [3]> interpolate_to_particles(const StencilSet& stencils, const NodalVector& x)
{
  const View<double* [3]> result("at particles", stencils.n_particles);
  const unsigned int dim = stencils.dim;
  Kokkos::parallel_for(
      "interpolate", Kokkos::RangePolicy<ExecutionSpace>(0, stencils.n_particles), KOKKOS_LAMBDA(const unsigned int p) {
        const ParticleNodes at = nodes_of(stencils, p);
        for (unsigned int v = 0; v < at.n; ++v)
          for (unsigned int c = 0; c < dim; ++c)
            result(p, c) += at.value[v] * x(static_cast<std::size_t>(dim) * at.node[v] + c);
      });
  return result;
}

template <int dim>
ParticleIncrements interpolate_increments(const ParticleArrays& particles, const StencilSet& stencils,
                                          const NodalVector& increment, const CellGroups& cells)
{
  const View<double*> factor = cells.volume_factor;
  ParticleIncrements result;
  result.displacement = interpolate_to_particles(stencils, increment);
  result.deformation_gradient = View<double* [9]>("dF", stencils.n_particles);
  Kokkos::parallel_for(
      "interpolate increments", Kokkos::RangePolicy<ExecutionSpace>(0, stencils.n_particles),
      KOKKOS_LAMBDA(const unsigned int p) {
        const Eigen::Matrix3d dF = stretch<dim>(deformation_increment<dim>(stencils, increment, p), factor, p);
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            result.deformation_gradient(p, 3 * i + j) = dF(i, j);
      });
  return result;
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template unsigned long update_stress_and_force<dim>(const ParticleArrays&, const StencilSet&, const Materials&,      \
                                                      const NodalVector&, const NodalVector&, const CellGroups&);      \
  template void add_weight<dim>(const ParticleArrays&, const StencilSet&, const std::array<double, 3>&, double,        \
                                const NodalVector&);                                                                   \
  template ParticleIncrements interpolate_increments<dim>(const ParticleArrays&, const StencilSet&,                    \
                                                          const NodalVector&, const CellGroups&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
