#include <cmath>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/volume_average.h>

namespace kedge
{
namespace
{
using Eigen::Matrix3d;

/// Follows the path with one group of particles after the other, so that what they share is in the nearest cache.
template <int dim> struct PathKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  Materials materials;
  ParticlePath path;
  CellGroups cells;

  /// A node's components in one register: three numbers and a fourth of no meaning.
  static constexpr int packed = packed_components(dim);
  using Packet = Eigen::Matrix<double, packed, 1>;

  /// So many particles find their principal frames together, on the host in the lanes of vector registers.
  static constexpr int width = device_is_host ? 4 : 1;

  /// Returns the number of inadmissible particles of a cell. The others share the mean J and the mean pressure.
  KEDGE_FUNCTION unsigned long follow_cell(const unsigned int c) const
  {
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    double before = 0., after = 0., stress = 0.;
    for (unsigned int p = begin; p < end; ++p)
    {
      const double J = deform(p), volume = integration_volume(particles, stencils, p);
      before += J > 0. ? volume : 0.;
      after += J > 0. ? volume * J : 0.;
    }
    for (unsigned int p = begin; p < end; p += width)
      share_volume(p, end - p < width ? end - p : width, after / before);
    unsigned long inverted = 0;
    for (unsigned int p = begin; p < end; p += width)
      inverted += advance([p](const unsigned int i) { return p + i; }, end - p,
                          [&](const unsigned int i) { return cells.volume_factor(i); });
    if (inverted > 0)
      return inverted;
    for (unsigned int p = begin; p < end; ++p)
      stress += integration_volume(particles, stencils, p) * mean_stress<dim>(row_of(particles.trial_stress, p));
    for (unsigned int p = begin; p < end; ++p)
    {
      cells.pressure(p) = stress / after;
      add_force(p, with_mean_stress<dim>(row_of(particles.trial_stress, p), path.volume_change(p) * cells.pressure(p)));
    }
    return 0;
  }

  /// Stretches n <= width particles from the first one on to the volume change J of their cell.
  KEDGE_FUNCTION void share_volume(const unsigned int first, const unsigned int n, const double J) const
  {
    Eigen::Array<double, width, 1> factor = Eigen::Array<double, width, 1>::Ones();
    for (unsigned int i = 0; i < n; ++i)
      if (const double own = path.volume_change(first + i); own > 0.)
        factor[i] = J / own;
    factor = ((1. / dim) * factor.log()).exp(); // one root is slower than four of these in a vector
    for (unsigned int i = 0; i < n; ++i)
      cells.volume_factor(first + i) = factor[i];
  }

  /// The same for `width` particles by themselves.
  KEDGE_FUNCTION unsigned long follow_batch(const unsigned int first) const
  {
    const unsigned int rest = particles.n - first, n = rest < width ? rest : width;
    const auto particle = [first](const unsigned int i) { return first + i; };
    for (unsigned int i = 0; i < n; ++i)
      deform(particle(i));
    const unsigned long inverted = advance(particle, n, [](const unsigned int) { return 1.; });
    for (unsigned int i = 0; i < n; ++i)
      if (path.volume_change(particle(i)) > 0.)
        add_force(particle(i), row_of(particles.trial_stress, particle(i)));
    return inverted;
  }

  /// Writes dF = 1 + sum over nodes of d_v (x) grad S_v and returns its determinant.
  KEDGE_FUNCTION double deform(const unsigned int p) const
  {
    const ParticleNodes at = nodes_of(stencils, p);
    const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
    Eigen::Matrix<double, packed, dim> f = Eigen::Matrix<double, packed, dim>::Identity();
    for (unsigned int v = 0; v < at.n; ++v)
    {
      const Eigen::Map<const Packet> d(&path.increment(std::size_t(packed) * at.node[v]));
      for (int j = 0; j < dim; ++j)
        f.col(j) += gradient[dim * v + j] * d;
    }
    Matrix3d dF = Matrix3d::Identity();
    dF.template topLeftCorner<dim, dim>() = f.template topRows<dim>();
    set_matrix(path.deformation, p, dF);
    return path.volume_change(p) = determinant(dF);
  }

  /// Brings up to `width` particles, `particle(i)` with i < n, to their dF, the dim x dim part times `factor(p)`, and
  /// leaves its inverse in its place. Returns how many of them are inadmissible; these do not move on.
  template <typename Particle, typename Factor>
  KEDGE_FUNCTION unsigned long advance(const Particle& particle, const unsigned int n, const Factor& factor) const
  {
    PrincipalFrames<width> frames;
    for (unsigned int i = 0; i < width; ++i)
    {
      const unsigned int p = particle(i < n ? i : 0);
      const Matrix3d dF = matrix_of(path.deformation, p);
      frames.set(i, internal::push_forward(stretched(dF, factor(p)), row_of(path.pulled_back, p)));
    }
    frames.find();
    frames.find_strains();
    unsigned long inverted = 0;
    for (unsigned int i = 0; i < width && i < n; ++i)
    {
      const unsigned int p = particle(i);
      if (!(path.volume_change(p) > 0. && settle(p, frames, i, factor(p))))
      {
        path.volume_change(p) = 0.;
        ++inverted;
      }
    }
    return inverted;
  }

  /// Goes on from the trial b of a lane; false where that is inadmissible.
  KOKKOS_FORCEINLINE_FUNCTION bool settle(const unsigned int p, const PrincipalFrames<width>& frames,
                                          const unsigned int lane, const double factor) const
  {
    SymmetricTensor b = frames.tensor_of(lane);
    double* state = &particles.trial_state(p, 0);
    const StressUpdate update =
        advance_stress(frames.frame_of(lane), frames.strain_of(lane), b,
                       {particles.young(p), particles.cell_size(p), state}, materials(particles.layer(p)), state);
    if (update.status == Status::inverted)
      return false;
    const Matrix3d to_start = inverse(matrix_of(path.deformation, p));
    set_matrix(path.deformation, p, to_start);
    if (update.status != Status::elastic)
      set_row(path.pulled_back, p, internal::push_forward(stretched(to_start, 1. / factor), b));
    set_trial(particles, p, update, particles.trial_plastic(p) + update.plastic_increment);
    return true;
  }

  /// Adds V tau grad_x S, as add_internal_force() does.
  KEDGE_FUNCTION void add_force(const unsigned int p, const SymmetricTensor& stress) const
  {
    const Matrix3d flux =
        integration_volume(particles, stencils, p) * full_matrix(stress) * matrix_of(path.deformation, p).transpose();
    Eigen::Matrix<double, packed, dim> columns = Eigen::Matrix<double, packed, dim>::Zero();
    columns.template topRows<dim>() = flux.template topLeftCorner<dim, dim>();
    const ParticleNodes at = nodes_of(stencils, p);
    const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
    for (unsigned int v = 0; v < at.n; ++v)
    {
      Packet f = gradient[dim * v] * columns.col(0);
      for (int j = 1; j < dim; ++j)
        f += gradient[dim * v + j] * columns.col(j);
      add_to<packed>(&path.force(std::size_t(packed) * at.node[v]), f);
    }
  }

  KEDGE_FUNCTION static Matrix3d stretched(Matrix3d f, const double factor)
  {
    f.template topLeftCorner<dim, dim>() *= factor;
    return f;
  }
};
} // namespace

ParticlePath begin_path(const ParticleArrays& particles, const unsigned int dim, const std::size_t n_nodes)
{
  const std::size_t n = particles.n, n_packed = n_nodes * packed_components(dim);
  const ParticlePath path{View<double* [6]>("path b", n), View<double* [9]>("path dF", n), View<double*>("path J", n),
                          View<double*>("path increment", n_packed), View<double*>("path force", n_packed)};
  Kokkos::deep_copy(path.pulled_back, particles.elastic_left_cauchy_green);
  Kokkos::deep_copy(particles.trial_state, particles.state);
  Kokkos::deep_copy(particles.trial_plastic, 0.);
  return path;
}

template <int dim>
unsigned long advance_stress_and_force(const ParticleArrays& particles, const StencilSet& stencils,
                                       const Materials& materials, const NodalVector& increment,
                                       const ParticlePath& path, const NodalVector& force, const CellGroups& cells)
{
  constexpr int packed = packed_components(dim), width = PathKernel<dim>::width;
  const std::size_t n_nodes = path.increment.extent(0) / packed; // that particles see; the vectors may have more
  Kokkos::parallel_for(
      "pack", Kokkos::RangePolicy<ExecutionSpace>(0, n_nodes), KOKKOS_LAMBDA(const std::size_t v) {
        for (int i = 0; i < packed; ++i)
        {
          path.increment(packed * v + i) = i < dim ? increment(dim * v + i) : 0.;
          path.force(packed * v + i) = 0.;
        }
      });
  const PathKernel<dim> kernel{particles, stencils, materials, path, cells};
  unsigned long n_inverted = 0;
  if (cells.empty())
    Kokkos::parallel_reduce(
        "follow path", Kokkos::RangePolicy<ExecutionSpace>(0, (particles.n + width - 1) / width),
        KOKKOS_LAMBDA(const unsigned int i, unsigned long& inverted) { inverted += kernel.follow_batch(width * i); },
        n_inverted);
  else
    Kokkos::parallel_reduce(
        "follow path by cell", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()),
        KOKKOS_LAMBDA(const unsigned int c, unsigned long& inverted) { inverted += kernel.follow_cell(c); },
        n_inverted);
  Kokkos::parallel_for(
      "unpack", Kokkos::RangePolicy<ExecutionSpace>(0, n_nodes), KOKKOS_LAMBDA(const std::size_t v) {
        for (int i = 0; i < dim; ++i)
          force(dim * v + i) += path.force(packed * v + i);
      });
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
