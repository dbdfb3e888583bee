#include <algorithm>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/point_tangents.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::TeamPolicy<ExecutionSpace>;
using Member = Policy::member_type;
using Scratch = Kokkos::View<double*, ExecutionSpace::scratch_memory_space, Kokkos::MemoryUnmanaged>;

/// Size of the contracted moduli that are held at once, so that they stay in the nearer caches.
constexpr std::size_t cache_bytes = 131072;

/// The memory that threads of a group share is too small on a GPU: groups there are few threads and use the large one.
constexpr int threads_beside_host = 16;
KEDGE_FUNCTION constexpr int scratch_level() { return device_is_host ? 0 : 1; }

/// Nodes and columns whose sums stay in registers: 4 x 8 numbers fill half of the registers of AVX2.
constexpr unsigned int node_block = 4, column_block = 8;

KEDGE_FUNCTION constexpr unsigned int round_up(const unsigned int n, const unsigned int block)
{
  return (n + block - 1) / block * block;
}

/// Adds the blocks of one pattern. All its particles are first summed in rows of blocks; each sum goes to the matrix
/// once.
template <int dim> struct TangentKernel
{
  PointTangents<dim> points;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;
  unsigned int chunk;
  DilationModuli moduli; ///< empty without F-bar

  static constexpr unsigned int rows = dim * dim; // (j, i) pairs of the contracted moduli

  /// contracted[(j dim + i) width + dim b + k] = V0 a_ijkl G_bl and gradient[dim b + j] = G_bj of one particle, with
  /// zeros behind the last node.
  KEDGE_FUNCTION void contract(const unsigned int p, const unsigned int n, const unsigned int width, double* contracted,
                               double* spatial_gradient) const
  {
    const Eigen::Matrix3d dF = matrix_of(points.particles.trial_deformation, p);
    PrincipalTangent principal;
    const PointDilation dilation = points.evaluate(p, determinant(dF), principal);
    const Eigen::Matrix3d directions = trial_frame<dim>(points.particles, points.cells.volume_factor, p).directions;
    if (!points.cells.empty())
      set(p, dilation, directions);
    const SpatialTangent tangent = turn(principal, directions);
    const double volume = integration_volume(points.particles, points.stencils, p);
    const Eigen::Matrix3d to_spatial = inverse(dF);
    const double* gradient = &points.stencils.gradient(dim * points.stencils.value_begin(p));
    for (unsigned int row = 0; row < rows; ++row)
      for (unsigned int c = dim * n; c < width; ++c)
        contracted[row * width + c] = 0.;
    for (unsigned int s = dim * n; s < dim * round_up(n, node_block); ++s)
      spatial_gradient[s] = 0.;
    for (unsigned int v = 0; v < n; ++v)
    {
      double g[3] = {0., 0., 0.}, scaled[3] = {0., 0., 0.};
      for (int j = 0; j < dim; ++j)
        for (int m = 0; m < dim; ++m)
          g[j] += to_spatial(m, j) * gradient[dim * v + m];
      for (int j = 0; j < dim; ++j)
      {
        spatial_gradient[dim * v + j] = g[j];
        scaled[j] = volume * g[j];
      }
      double t[27];
      tangent.contract(scaled, t);
      for (int j = 0; j < dim; ++j)
        for (int i = 0; i < dim; ++i)
          for (int k = 0; k < dim; ++k)
            contracted[(j * dim + i) * width + dim * v + k] = t[(3 * j + i) * 3 + k];
    }
  }

  KEDGE_FUNCTION void set(const unsigned int p, const PointDilation& dilation, const Eigen::Matrix3d& directions) const
  {
    Eigen::Vector3d stress = Eigen::Vector3d::Zero(), volume = Eigen::Vector3d::Zero();
    for (int m = 0; m < dim; ++m)
    {
      stress[m] = dilation.stress[m];
      volume[m] = dilation.volume[m];
    }
    set_row(moduli.stress, p, from_principal(stress, directions));
    set_row(moduli.volume, p, from_principal(volume, directions));
    moduli.compliance(p) = dilation.compliance;
  }

  KEDGE_FUNCTION void operator()(const Member& team) const
  {
    const unsigned int pattern = team.league_rank();
    const StencilSet& stencils = points.stencils;
    const unsigned int first_node = stencils.pattern_node_begin(pattern);
    const unsigned int n = stencils.pattern_node_begin(pattern + 1) - first_node;
    const unsigned int width = round_up(dim * n, column_block), n_padded = round_up(n, node_block);
    const unsigned int begin = stencils.pattern_particle_begin(pattern),
                       end = stencils.pattern_particle_begin(pattern + 1);
    const Scratch contracted(team.team_scratch(scratch_level()), chunk * rows * width),
        gradient(team.team_scratch(scratch_level()), chunk * dim * n_padded);
    const Scratch sums(team.thread_scratch(scratch_level()), node_block * dim * width);

    for (unsigned int start = begin; start < end; start += chunk)
    {
      const unsigned int count = start + chunk < end ? chunk : end - start;
      Kokkos::parallel_for(Kokkos::TeamThreadRange(team, count),
                           [&](const unsigned int c)
                           {
                             contract(stencils.pattern_particles(start + c), n, width, &contracted(c * rows * width),
                                      &gradient(c * dim * n_padded));
                           });
      team.team_barrier();
      Kokkos::parallel_for(Kokkos::TeamThreadRange(team, n_padded / node_block),
                           [&](const unsigned int block)
                           {
                             const unsigned int a = block * node_block;
                             for (unsigned int i = 0; i < dim; ++i)
                               for (unsigned int column = 0; column < width; column += column_block)
                                 multiply(&gradient(dim * a), dim * n_padded, &contracted(i * width + column), width,
                                          count, &sums(i * width + column));
                             for (unsigned int m = 0; m < node_block && a + m < n; ++m)
                               scatter(stencils.pattern_nodes(first_node + a + m), &stencils.pattern_nodes(first_node),
                                       n, width, &sums(m * dim * width));
                           });
      team.team_barrier();
    }
  }

  /// sums[m dim width + c] = sum over particles p and j of g[p stride + dim m + j] contracted[(p rows + j dim) width +
  /// c], a block of nodes m and columns c.
  KEDGE_FUNCTION static void multiply(const double* g, const unsigned int stride, const double* contracted,
                                      const unsigned int width, const unsigned int n_particles, double* sums)
  {
    using Columns = Eigen::Array<double, column_block, 1>; // the compiler does not vectorise plain loops here
    Columns block[node_block];
    for (unsigned int m = 0; m < node_block; ++m)
      block[m].setZero();
    for (unsigned int p = 0; p < n_particles; ++p)
      for (unsigned int j = 0; j < dim; ++j)
      {
        const Columns t = Eigen::Map<const Columns>(contracted + (p * rows + j * dim) * width);
        for (unsigned int m = 0; m < node_block; ++m)
          block[m] += g[p * stride + dim * m + j] * t;
      }
    for (unsigned int m = 0; m < node_block; ++m)
      Eigen::Map<Columns>(sums + m * dim * width) = block[m];
  }

  /// Nodes and columns both ascend, so one pass along the row finds all positions.
  KEDGE_FUNCTION void scatter(const unsigned int row, const unsigned int* nodes, const unsigned int n,
                              const unsigned int width, const double* sums) const
  {
    const std::size_t begin = row_begin(row);
    const unsigned int length = row_begin(row + 1) - begin;
    const unsigned int* columns = &column(begin);
    double* target = &values(dim * dim * begin);
    const std::size_t row_stride = std::size_t(dim) * length;
    const unsigned int* at = columns;
    for (unsigned int b = 0; b < n; ++b, ++at)
    {
      while (*at != nodes[b])
        ++at;
      double* to = target + dim * (at - columns);
      const double* from = sums + dim * b;
      for (int i = 0; i < dim; ++i, to += row_stride, from += width)
        for (int k = 0; k < dim; ++k)
          add_to(to[k], from[k]);
    }
  }
};
} // namespace

template <int dim>
void add_tangent(const ParticleArrays& particles, const StencilSet& stencils, const Materials& materials,
                 const NodeGraph& graph, const View<double*>& values, const CellGroups& cells,
                 const double elastic_share)
{
  const unsigned int width = round_up(dim * stencils.max_nodes, column_block);
  const unsigned int gradients = dim * round_up(stencils.max_nodes, node_block);
  const std::size_t per_particle = sizeof(double) * (dim * dim * width + gradients);
  const unsigned int chunk =
      std::max<std::size_t>(1, std::min<std::size_t>(16, cache_bytes / std::max<std::size_t>(1, per_particle)));
  const std::size_t n_sharing = cells.empty() ? 0 : particles.n;
  const DilationModuli moduli{View<double* [6]>("stress moduli", n_sharing),
                              View<double* [6]>("volume moduli", n_sharing), View<double*>("compliance", n_sharing)};
  const TangentKernel<dim> kernel{
      {particles, stencils, materials, cells, elastic_share}, graph.row_begin, graph.column, values, chunk, moduli};
  Policy policy =
      device_is_host ? Policy(stencils.n_patterns, Kokkos::AUTO) : Policy(stencils.n_patterns, threads_beside_host);
  policy.set_scratch_size(
      scratch_level(),
      Kokkos::PerTeam(Scratch::shmem_size(chunk * dim * dim * width) + Scratch::shmem_size(chunk * gradients)),
      Kokkos::PerThread(Scratch::shmem_size(node_block * dim * width)));
  Kokkos::parallel_for("tangent", policy, kernel);
  if (!cells.empty())
    add_mean_dilation<dim>(particles, stencils, cells, moduli, graph, values);
}

template void add_tangent<2>(const ParticleArrays&, const StencilSet&, const Materials&, const NodeGraph&,
                             const View<double*>&, const CellGroups&, double);
template void add_tangent<3>(const ParticleArrays&, const StencilSet&, const Materials&, const NodeGraph&,
                             const View<double*>&, const CellGroups&, double);
} // namespace kedge
