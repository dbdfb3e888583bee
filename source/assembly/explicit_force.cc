#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/volume_average.h>

namespace kedge
{
ParticlePath begin_path(const ParticleArrays& particles)
{
  ParticlePath path{View<double* [6]>("path b", particles.n), View<double* [9]>("path inverse dF", particles.n)};
  Kokkos::deep_copy(path.left_cauchy_green, particles.elastic_left_cauchy_green);
  Kokkos::deep_copy(particles.trial_state, particles.state);
  Kokkos::parallel_for(
      "begin path", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n), KOKKOS_LAMBDA(const std::size_t p) {
        for (int i = 0; i < 9; ++i)
          path.inverse_deformation(p, i) = i % 4 == 0 ? 1. : 0.;
        particles.trial_plastic(p) = 0.;
      });
  return path;
}

template <int dim>
unsigned long advance_stress_and_force(const ParticleArrays& particles, const StencilSet& stencils,
                                       const Materials& materials, const NodalVector& increment,
                                       const ParticlePath& path, const NodalVector& force, const CellGroups& cells)
{
  share_volume_change<dim>(particles, stencils, cells, increment);
  const View<double*> factor = cells.volume_factor;
  unsigned long n_inverted = 0;
  Kokkos::parallel_reduce(
      "follow path", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n),
      KOKKOS_LAMBDA(const unsigned int i, unsigned long& inverted) {
        const unsigned int p = stencils.pattern_particles(i); // in an order that visits nodes close in memory
        const Eigen::Matrix3d dF = deformation_increment<dim>(stencils, increment, p);
        const Eigen::Matrix3d to_start = inverse(dF);
        // The law sees the increment since the last point of the path.
        Eigen::Matrix3d before;
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            before(r, c) = path.inverse_deformation(p, 3 * r + c);
        SymmetricTensor b = row_of(path.left_cauchy_green, p);
        double* state = &particles.trial_state(p, 0);
        const StressUpdate update =
            advance_stress(stretch<dim>(dF, factor, p) * before, b, {particles.young(p), particles.cell_size(p), state},
                           materials(particles.layer(p)), state);
        if (update.status == Status::inverted || !(determinant(dF) > 0.))
        {
          ++inverted;
          return;
        }
        // The path moves on only with an admissible increment.
        const double shrink = factor.extent(0) > 0 ? 1. / factor(p) : 1.; // the inverse of stretch()
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            path.inverse_deformation(p, 3 * r + c) = (r < dim && c < dim ? shrink : 1.) * to_start(r, c);
        set_row(path.left_cauchy_green, p, b);
        set_trial(particles, p, update, particles.trial_plastic(p) + update.plastic_increment);
        if (factor.extent(0) == 0)
          add_internal_force<dim>(particles, stencils, p, update.stress, to_start, force);
      },
      n_inverted);
  if (factor.extent(0) > 0)
    add_force_of_mean_pressure<dim>(particles, stencils, cells, increment, force);
  return n_inverted;
}

void add_lumped_mass(const ParticleArrays& particles, const StencilSet& stencils, const double least_share,
                     const View<double*>& mass)
{
  Kokkos::parallel_for(
      "lumped mass", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n), KOKKOS_LAMBDA(const unsigned int p) {
        const ParticleNodes at = nodes_of(stencils, p);
        for (unsigned int v = 0; v < at.n; ++v)
          if (at.value[v] > 0.)
            add_to(mass(at.node[v]), particles.mass(p) * std::fmax(at.value[v], least_share));
      });
}

double largest_squared_frequency(const ParticleArrays& particles, const StencilSet& stencils,
                                 const Materials& materials, const double least_share)
{
  double largest = 0.;
  const unsigned int dim = stencils.dim;
  Kokkos::parallel_reduce(
      "stable step", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n),
      KOKKOS_LAMBDA(const unsigned int p, double& most) {
        const HenckyElasticity elasticity = materials(particles.layer(p)).elasticity(particles.young(p));
        const ParticleNodes at = nodes_of(stencils, p);
        const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
        double G[3][3] = {};
        for (unsigned int v = 0; v < at.n; ++v)
          if (at.value[v] > 0.)
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                G[i][j] += gradient[dim * v + i] * gradient[dim * v + j] / std::fmax(at.value[v], least_share);
        double row_sum = 0.; // bounds the largest eigenvalue from above
        for (unsigned int i = 0; i < dim; ++i)
          row_sum = std::fmax(row_sum, std::fabs(G[i][0]) + std::fabs(G[i][1]) + std::fabs(G[i][2]));
        const double stiffness = std::fmax(3. * elasticity.bulk(), 2. * elasticity.shear);
        const double rate = integration_volume(particles, stencils, p) * stiffness / particles.mass(p) * row_sum;
        most = std::fmax(most, rate);
      },
      Kokkos::Max<double>(largest));
  return largest;
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template unsigned long advance_stress_and_force<dim>(const ParticleArrays&, const StencilSet&, const Materials&,     \
                                                       const NodalVector&, const ParticlePath&, const NodalVector&,    \
                                                       const CellGroups&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
