#include <algorithm>
#include <kedge/assembly/internal_force.h>
#include <kedge/assembly/kernels.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::TeamPolicy<ExecutionSpace>;
using Member = Policy::member_type;
using Scratch = Kokkos::View<double*, ExecutionSpace::scratch_memory_space, Kokkos::MemoryUnmanaged>;

/// Particles whose contracted moduli are held at once: as many as stay in the first-level cache.
constexpr std::size_t cache_bytes = 32768;

/// Adds the blocks of one pattern: all its particles first sum into rows of blocks, which then go to the matrix once.
template <int dim> struct TangentKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  Materials materials;
  NodalVector increment;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;
  unsigned int chunk;

  static constexpr unsigned int rows = dim * dim; // (j, i) pairs of the contracted moduli

  /// contracted[(j dim + i) width + dim b + k] = V0 a_ijkl G_bl and gradient[dim b + j] = G_bj of one particle.
  KEDGE_FUNCTION void contract(const unsigned int p, const unsigned int n, double* contracted,
                               double* spatial_gradient) const
  {
    const Eigen::Matrix3d dF = deformation_increment<dim>(stencils, increment, p);
    SymmetricTensor b;
    for (int i = 0; i < 6; ++i)
      b[i] = particles.elastic_left_cauchy_green(p, i);
    SpatialTangent tangent;
    update_stress(dF, b, particles.young(p), materials(particles.layer(p)), tangent);
    const double volume = particles.initial_volume(p);
    const Eigen::Matrix3d to_spatial = inverse(dF);
    const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
    const unsigned int width = dim * n;
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

  KEDGE_FUNCTION void operator()(const Member& team) const
  {
    const unsigned int pattern = team.league_rank();
    const unsigned int first_node = stencils.pattern_node_begin(pattern);
    const unsigned int n = stencils.pattern_node_begin(pattern + 1) - first_node, width = dim * n;
    const unsigned int begin = stencils.pattern_particle_begin(pattern),
                       end = stencils.pattern_particle_begin(pattern + 1);
    const Scratch contracted(team.team_scratch(0), chunk * rows * width), gradient(team.team_scratch(0), chunk * width);
    const Scratch sums(team.thread_scratch(0), dim * width);

    for (unsigned int start = begin; start < end; start += chunk)
    {
      const unsigned int count = start + chunk < end ? chunk : end - start;
      Kokkos::parallel_for(
          Kokkos::TeamThreadRange(team, count), [&](const unsigned int c)
          { contract(stencils.pattern_particles(start + c), n, &contracted(c * rows * width), &gradient(c * width)); });
      team.team_barrier();
      Kokkos::parallel_for(Kokkos::TeamThreadRange(team, n),
                           [&](const unsigned int a)
                           {
                             for (unsigned int s = 0; s < dim * width; ++s)
                               sums(s) = 0.;
                             for (unsigned int c = 0; c < count; ++c)
                               add_rows(&gradient(c * width + dim * a), &contracted(c * rows * width), width, &sums(0));
                             scatter(stencils.pattern_nodes(first_node + a), &stencils.pattern_nodes(first_node), n,
                                     &sums(0));
                           });
      team.team_barrier();
    }
  }

  /// sums[i width + c] += sum over j of g[j] contracted[(j dim + i) width + c].
  KEDGE_FUNCTION static void add_rows(const double* g, const double* contracted, const unsigned int width, double* sums)
  {
    for (int i = 0; i < dim; ++i)
    {
      double* sum = sums + i * width;
      const double* t0 = contracted + i * width;
      const double* t1 = contracted + (dim + i) * width;
      const double* t2 = contracted + ((dim == 3 ? 2 * dim : dim) + i) * width;
      const double g0 = g[0], g1 = g[1], g2 = dim == 3 ? g[dim - 1] : 0.;
#ifdef __GNUC__
#pragma GCC ivdep
#endif
      for (unsigned int c = 0; c < width; ++c)
        sum[c] += g0 * t0[c] + g1 * t1[c] + (dim == 3 ? g2 * t2[c] : 0.);
    }
  }

  /// Nodes and columns both ascend, so one walk along the row finds all positions.
  KEDGE_FUNCTION void scatter(const unsigned int row, const unsigned int* nodes, const unsigned int n,
                              const double* sums) const
  {
    const std::size_t begin = row_begin(row);
    const unsigned int length = row_begin(row + 1) - begin;
    const unsigned int* columns = &column(begin);
    double* target = &values(dim * dim * begin);
    unsigned int position = 0;
    for (unsigned int b = 0; b < n; ++b, ++position)
    {
      while (columns[position] != nodes[b])
        ++position;
      for (int i = 0; i < dim; ++i)
        for (int k = 0; k < dim; ++k)
          add_to(target[dim * (i * length + position) + k], sums[(i * n + b) * dim + k]);
    }
  }
};
} // namespace

template <int dim>
void add_tangent(const ParticleArrays& particles, const StencilSet& stencils, const Materials& materials,
                 const NodalVector& increment, const NodeGraph& graph, const View<double*>& values)
{
  const unsigned int width = dim * stencils.max_nodes;
  const std::size_t per_particle = sizeof(double) * width * (dim * dim + 1);
  const unsigned int chunk =
      std::max<std::size_t>(1, std::min<std::size_t>(8, cache_bytes / std::max<std::size_t>(1, per_particle)));
  const TangentKernel<dim> kernel{particles,       stencils,     materials, increment,
                                  graph.row_begin, graph.column, values,    chunk};
  Policy policy(stencils.n_patterns, Kokkos::AUTO);
  policy.set_scratch_size(
      0, Kokkos::PerTeam(Scratch::shmem_size(chunk * dim * dim * width) + Scratch::shmem_size(chunk * width)),
      Kokkos::PerThread(Scratch::shmem_size(dim * width)));
  Kokkos::parallel_for("tangent", policy, kernel);
}

template void add_tangent<2>(const ParticleArrays&, const StencilSet&, const Materials&, const NodalVector&,
                             const NodeGraph&, const View<double*>&);
template void add_tangent<3>(const ParticleArrays&, const StencilSet&, const Materials&, const NodalVector&,
                             const NodeGraph&, const View<double*>&);
} // namespace kedge
