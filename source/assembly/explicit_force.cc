#include <cmath>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/volume_average.h>

namespace kedge
{
namespace
{
/// Follows the path with one group of particles after the other, so that what they share is in the nearest cache.
template <int dim> struct PathKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  Materials materials;
  NodalVector increment;
  ParticlePath path;
  NodalVector force;
  CellGroups cells;

  /// Returns the number of inadmissible particles of a cell. The others share the mean J and the mean pressure.
  KEDGE_FUNCTION unsigned long follow_cell(const unsigned int c) const
  {
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    double before = 0., after = 0., stress = 0.;
    for (unsigned int p = begin; p < end; ++p)
    {
      const Eigen::Matrix3d dF = deformation_increment<dim>(stencils, increment, p);
      write(path.deformation, p, dF);
      const double J = determinant(dF), volume = integration_volume(particles, stencils, p);
      if (J > 0.)
      {
        before += volume;
        after += volume * J;
      }
      cells.volume_factor(p) = J;
    }
    unsigned long inverted = 0;
    for (unsigned int p = begin; p < end; ++p)
    {
      const double J = cells.volume_factor(p);
      cells.volume_factor(p) = J > 0. ? std::pow(after / (before * J), 1. / dim) : 1.;
      if (advance(p, read(path.deformation, p), cells.volume_factor(p)))
        stress += integration_volume(particles, stencils, p) * mean_stress<dim>(row_of(particles.trial_stress, p));
      else
        ++inverted;
    }
    for (unsigned int p = begin; p < end && inverted == 0; ++p)
    {
      const Eigen::Matrix3d dF = read(path.deformation, p);
      cells.pressure(p) = stress / after;
      add_internal_force<dim>(
          particles, stencils, p,
          with_mean_stress<dim>(row_of(particles.trial_stress, p), determinant(dF) * cells.pressure(p)), inverse(dF),
          force);
    }
    return inverted;
  }

  /// The same for a particle by itself.
  KEDGE_FUNCTION unsigned long follow_particle(const unsigned int p) const
  {
    const Eigen::Matrix3d dF = deformation_increment<dim>(stencils, increment, p);
    if (!advance(p, dF, 1.))
      return 1;
    add_internal_force<dim>(particles, stencils, p, row_of(particles.trial_stress, p), inverse(dF), force);
    return 0;
  }

  /// Brings a particle to dF, its dim x dim part times `factor`. The law sees the increment since the last point of the
  /// path. False, and the path does not move on, if that is inadmissible.
  KEDGE_FUNCTION bool advance(const unsigned int p, Eigen::Matrix3d dF, const double factor) const
  {
    if (!(determinant(dF) > 0.))
      return false;
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
        dF(i, j) *= factor;
    SymmetricTensor b = row_of(path.left_cauchy_green, p);
    double* state = &particles.trial_state(p, 0);
    const StressUpdate update =
        advance_stress(dF * read(path.inverse_deformation, p), b, {particles.young(p), particles.cell_size(p), state},
                       materials(particles.layer(p)), state);
    if (update.status == Status::inverted)
      return false;
    write(path.inverse_deformation, p, inverse(dF));
    set_row(path.left_cauchy_green, p, b);
    set_trial(particles, p, update, particles.trial_plastic(p) + update.plastic_increment);
    return true;
  }

  KEDGE_FUNCTION static Eigen::Matrix3d read(const View<double* [9]>& view, const unsigned int p)
  {
    Eigen::Matrix3d m;
    for (int i = 0; i < 9; ++i)
      m(i / 3, i % 3) = view(p, i);
    return m;
  }

  KEDGE_FUNCTION static void write(const View<double* [9]>& view, const unsigned int p, const Eigen::Matrix3d& m)
  {
    for (int i = 0; i < 9; ++i)
      view(p, i) = m(i / 3, i % 3);
  }
};
} // namespace

ParticlePath begin_path(const ParticleArrays& particles)
{
  const ParticlePath path{View<double* [6]>("path b", particles.n), View<double* [9]>("path inverse dF", particles.n),
                          View<double* [9]>("path dF", particles.n)};
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
  const PathKernel<dim> kernel{particles, stencils, materials, increment, path, force, cells};
  unsigned long n_inverted = 0;
  if (cells.empty())
    Kokkos::parallel_reduce(
        "follow path", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n),
        KOKKOS_LAMBDA(const unsigned int i, unsigned long& inverted) {
          // in an order that visits nodes close in memory
          inverted += kernel.follow_particle(kernel.stencils.pattern_particles(i));
        },
        n_inverted);
  else
    Kokkos::parallel_reduce(
        "follow path by cell", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()),
        KOKKOS_LAMBDA(const unsigned int c, unsigned long& inverted) { inverted += kernel.follow_cell(c); },
        n_inverted);
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
