#include <cmath>
#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/volume_average.h>
#include <kedge/materials/stress_lanes.h>

namespace kedge
{
namespace
{
using Eigen::Matrix3d;
using Policy = Kokkos::RangePolicy<ExecutionSpace>;

/// Follows the path with some cells after the other, so that what they share is in the nearest cache.
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

  static constexpr int width = points_together;
  /// So many cells are followed together: many enough to leave few lanes empty, few enough to stay in the cache.
  static constexpr int block = device_is_host ? 16 : 1;

  /// Returns the number of inadmissible particles of a block of cells. The others share the mean J of their cell and,
  /// where all of it are admissible, its mean pressure.
  KEDGE_FUNCTION unsigned long follow_block(const unsigned int first) const
  {
    const unsigned int last = first + block < cells.n_cells() ? first + block : cells.n_cells();
    const unsigned int begin = cells.particle_begin(first), end = cells.particle_begin(last);
    for (unsigned int c = first; c < last; ++c)
      find_volume_change(c);
    for (unsigned int p = begin; p < end; p += width)
      share_volume(p, end - p < width ? end - p : width);
    unsigned long inverted = 0;
    for (unsigned int p = begin; p < end; p += width)
      inverted += advance(p, end - p < width ? end - p : width);
    for (unsigned int c = first; c < last; ++c)
      add_force_of_cell(c);
    return inverted;
  }

  /// Writes the mean J of a cell to the volume factors of its particles.
  KEDGE_FUNCTION void find_volume_change(const unsigned int c) const
  {
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    double before = 0., after = 0.;
    for (unsigned int p = begin; p < end; ++p)
    {
      const double J = deform(p), volume = integration_volume(particles, stencils, p);
      before += J > 0. ? volume : 0.;
      after += J > 0. ? volume * J : 0.;
    }
    for (unsigned int p = begin; p < end; ++p)
      cells.volume_factor(p) = after / before;
  }

  /// Adds the forces of a cell's particles, each with the cell's pressure; none where one of them is inadmissible.
  KEDGE_FUNCTION void add_force_of_cell(const unsigned int c) const
  {
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    double after = 0., stress = 0.;
    for (unsigned int p = begin; p < end; ++p)
    {
      if (!(path.volume_change(p) > 0.))
        return;
      const double volume = integration_volume(particles, stencils, p);
      after += volume * path.volume_change(p);
      stress += volume * mean_stress<dim>(row_of(particles.trial_stress, p));
    }
    for (unsigned int p = begin; p < end; ++p)
    {
      cells.pressure(p) = stress / after;
      add_force(p, with_mean_stress<dim>(row_of(particles.trial_stress, p), path.volume_change(p) * cells.pressure(p)));
    }
  }

  /// Turns the mean J in the volume factors of n <= width particles from the first one on into what stretches their dF.
  KEDGE_FUNCTION void share_volume(const unsigned int first, const unsigned int n) const
  {
    Eigen::Array<double, width, 1> factor = Eigen::Array<double, width, 1>::Ones();
    for (unsigned int i = 0; i < n; ++i)
      if (const double own = path.volume_change(first + i); own > 0.)
        factor[i] = cells.volume_factor(first + i) / own;
    factor = ((1. / dim) * factor.log()).exp(); // one root is slower than four of these in a vector
    for (unsigned int i = 0; i < n; ++i)
      cells.volume_factor(first + i) = factor[i];
  }

  /// Returns the number of inadmissible ones of `width` particles by themselves.
  KEDGE_FUNCTION unsigned long follow_batch(const unsigned int first) const
  {
    const unsigned int rest = particles.n - first, n = rest < width ? rest : width;
    for (unsigned int p = first; p < first + n; ++p)
      deform(p);
    const unsigned long inverted = advance(first, n);
    for (unsigned int p = first; p < first + n; ++p)
      if (path.volume_change(p) > 0.)
        add_force(p, row_of(particles.trial_stress, p));
    return inverted;
  }

  /// Writes dF = 1 + sum over nodes of d_v (x) grad S_v and returns its determinant.
  KEDGE_FUNCTION double deform(const unsigned int p) const
  {
    const ParticleNodes at = nodes_of(stencils, p);
    const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
    const double* increment = path.increment.data();
    Eigen::Matrix<double, packed, dim> f = Eigen::Matrix<double, packed, dim>::Identity();
    for (unsigned int v = 0; v < at.n; ++v, gradient += dim)
    {
      const Eigen::Map<const Packet> d(increment + std::size_t(packed) * at.node[v]);
      for (int j = 0; j < dim; ++j)
        f.col(j) += gradient[j] * d;
    }
    Matrix3d dF = Matrix3d::Identity();
    dF.template topLeftCorner<dim, dim>() = f.template topRows<dim>();
    set_matrix(path.deformation, p, dF);
    return path.volume_change(p) = determinant(dF);
  }

  /// Brings n <= width particles from the first one on to their dF, with F-bar stretched by their factor, and leaves
  /// its inverse in its place. Returns how many of them are inadmissible; these do not move on.
  KEDGE_FUNCTION unsigned long advance(const unsigned int first, const unsigned int n) const
  {
    StressLanes<width> lanes;
    DeformationLanes<width> deformation;
    double stretch[width], pulled_back[6][width];
    for (unsigned int l = 0; l < width; ++l)
    {
      const unsigned int p = first + (l < n ? l : 0);
      double* state = &particles.trial_state(p, 0);
      lanes.point[l] = {particles.young(p), particles.cell_size(p), state};
      lanes.material[l] = &materials(particles.layer(p));
      lanes.next_state[l] = state;
      lanes.admissible[l] = l < n && path.volume_change(p) > 0.;
      stretch[l] = cells.empty() ? 1. : cells.volume_factor(p);
      for (int i = 0; i < 9; ++i)
        deformation.f[i][l] = path.deformation(p, i);
      for (int i = 0; i < 6; ++i)
        pulled_back[i][l] = path.pulled_back(p, i);
    }
    for (int j = 0; j < dim; ++j)
      for (int i = 0; i < dim; ++i)
        for (unsigned int l = 0; l < width; ++l)
          deformation.f[3 * j + i][l] *= stretch[l];
    deformation.push_forward(pulled_back, lanes.trial.tensor);
    lanes.trial.find();
    lanes.trial.find_strains();
    lanes.respond();
    deformation.invert();
    double stress[6][width], strain[6][width];
    lanes.trial.turn(lanes.stress, stress);
    lanes.trial.turn(lanes.elastic_strain, strain);

    unsigned long inverted = 0;
    bool yields = false;
    for (unsigned int l = 0; l < n; ++l)
    {
      const unsigned int p = first + l;
      if (!lanes.admissible[l])
      {
        path.volume_change(p) = 0.;
        ++inverted;
        continue;
      }
      for (int i = 0; i < 6; ++i)
      {
        particles.trial_stress(p, i) = stress[i][l];
        particles.trial_strain(p, i) = strain[i][l];
      }
      particles.trial_plastic(p) += lanes.plastic_increment[l];
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          path.deformation(p, 3 * j + i) = deformation.f[3 * j + i][l] * (i < dim && j < dim ? stretch[l] : 1.);
      yields = yields || lanes.status[l] != Status::elastic;
    }
    if (!yields)
      return inverted;

    double b[6][width];
    lanes.find_left_cauchy_green(b);
    deformation.push_forward(b, pulled_back);
    for (unsigned int l = 0; l < n; ++l)
      if (lanes.admissible[l] && lanes.status[l] != Status::elastic)
        for (int i = 0; i < 6; ++i)
          path.pulled_back(first + l, i) = pulled_back[i][l];
    return inverted;
  }

  /// Adds V tau grad_x S, as add_internal_force() does.
  KEDGE_FUNCTION void add_force(const unsigned int p, const SymmetricTensor& stress) const
  {
    // Columns as sums of unit vectors stay in registers: what is written number by number and read as a vector has to
    // wait for its writing.
    constexpr int entry[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
    Packet tau[dim], flux[dim];
    for (int j = 0; j < dim; ++j)
    {
      tau[j] = stress[entry[j][0]] * Packet::Unit(0);
      for (int i = 1; i < dim; ++i)
        tau[j] += stress[entry[j][i]] * Packet::Unit(i);
    }
    for (int j = 0; j < dim; ++j)
    {
      flux[j] = path.deformation(p, j) * tau[0];
      for (int k = 1; k < dim; ++k)
        flux[j] += path.deformation(p, 3 * k + j) * tau[k];
      flux[j] *= integration_volume(particles, stencils, p);
    }
    const ParticleNodes at = nodes_of(stencils, p);
    const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
    double* force = path.force.data();
    for (unsigned int v = 0; v < at.n; ++v, gradient += dim)
    {
      Packet f = gradient[0] * flux[0];
      for (int j = 1; j < dim; ++j)
        f += gradient[j] * flux[j];
      add_to<packed>(force + std::size_t(packed) * at.node[v], f);
    }
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
  constexpr int packed = packed_components(dim), width = PathKernel<dim>::width, block = PathKernel<dim>::block;
  const std::size_t n_nodes = path.increment.extent(0) / packed; // that particles see; the vectors may have more
  Kokkos::parallel_for(
      "pack", Policy(0, n_nodes), KOKKOS_LAMBDA(const std::size_t v) {
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
        "follow path", Policy(0, (particles.n + width - 1) / width),
        KOKKOS_LAMBDA(const unsigned int i, unsigned long& inverted) { inverted += kernel.follow_batch(width * i); },
        n_inverted);
  else
    Kokkos::parallel_reduce(
        "follow path by cell", Policy(0, (cells.n_cells() + block - 1) / block),
        KOKKOS_LAMBDA(const unsigned int i, unsigned long& inverted) { inverted += kernel.follow_block(block * i); },
        n_inverted);
  Kokkos::parallel_for(
      "unpack", Policy(0, n_nodes), KOKKOS_LAMBDA(const std::size_t v) {
        for (int i = 0; i < dim; ++i)
          force(dim * v + i) += path.force(packed * v + i);
      });
  return n_inverted;
}

void add_lumped_mass(const ParticleArrays& particles, const StencilSet& stencils, const double least_share,
                     const View<double*>& mass)
{
  Kokkos::parallel_for(
      "lumped mass", Policy(0, particles.n), KOKKOS_LAMBDA(const unsigned int p) {
        const ParticleNodes at = nodes_of(stencils, p);
        for (unsigned int v = 0; v < at.n; ++v)
          if (at.value[v] > 0.)
            add_to(mass(at.node[v]), particles.mass(p) * std::fmax(at.value[v], least_share));
      });
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template unsigned long advance_stress_and_force<dim>(const ParticleArrays&, const StencilSet&, const Materials&,     \
                                                       const NodalVector&, const ParticlePath&, const NodalVector&,    \
                                                       const CellGroups&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
