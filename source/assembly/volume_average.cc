#include <cmath>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/volume_average.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::TeamPolicy<ExecutionSpace>;
using Member = Policy::member_type;

template <int dim> struct MeanDilationKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  CellGroups cells;
  NodalVector increment;
  View<double* [9]> moduli;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;
  View<double*> force;  ///< change of the nodal force with the dilation of the cell; laid out as cells.nodes
  View<double*> volume; ///< change of the cell's volume with the node; laid out as cells.nodes

  KEDGE_FUNCTION void operator()(const Member& team) const
  {
    const unsigned int c = team.league_rank();
    const unsigned int first = cells.node_begin(c), n = cells.node_begin(c + 1) - first;
    double total = 0.;
    Kokkos::parallel_reduce(
        Kokkos::TeamThreadRange(team, cells.particle_begin(c), cells.particle_begin(c + 1)),
        [&](const unsigned int p, double& sum) { sum += gather(p, first); }, total);
    team.team_barrier();
    Kokkos::parallel_for(Kokkos::TeamThreadRange(team, n),
                         [&](const unsigned int a) { scatter(first, n, first + a, 1. / total); });
  }

  /// Adds a particle's part to the sums of its cell, whose nodes begin at `first`; returns its volume.
  KEDGE_FUNCTION double gather(const unsigned int p, const unsigned int first) const
  {
    const Eigen::Matrix3d dF = deformation_increment<dim>(stencils, increment, p);
    const Eigen::Matrix3d to_spatial = inverse(dF);
    const double initial = particles.initial_volume(p), end = initial * determinant(dF);
    const ParticleNodes nodes = nodes_of(stencils, p);
    const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
    for (unsigned int v = 0, at = first; v < nodes.n; ++v, ++at)
    {
      while (cells.nodes(at) != nodes.node[v]) // both lists ascend
        ++at;
      double h[dim] = {};
      for (int j = 0; j < dim; ++j)
        for (int m = 0; m < dim; ++m)
          h[j] += to_spatial(m, j) * gradient[dim * v + m];
      for (int i = 0; i < dim; ++i)
      {
        double change = 0.;
        for (int j = 0; j < dim; ++j)
          change += moduli(p, 3 * i + j) * h[j];
        add_to(force(std::size_t(dim) * at + i), initial * change);
        add_to(volume(std::size_t(dim) * at + i), end * h[i]);
      }
    }
    return end;
  }

  KEDGE_FUNCTION void scatter(const unsigned int first, const unsigned int n, const unsigned int a,
                              const double factor) const
  {
    const unsigned int row = cells.nodes(a);
    const std::size_t begin = row_begin(row), row_stride = dim * (row_begin(row + 1) - begin);
    double* target = &values(std::size_t(dim) * dim * begin);
    double scaled[dim];
    for (int i = 0; i < dim; ++i)
      scaled[i] = factor * force(std::size_t(dim) * a + i);
    std::size_t at = begin;
    for (unsigned int b = first; b < first + n; ++b, ++at)
    {
      while (column(at) != cells.nodes(b))
        ++at;
      double* to = target + dim * (at - begin);
      for (int i = 0; i < dim; ++i, to += row_stride)
        for (int k = 0; k < dim; ++k)
          add_to(to[k], scaled[i] * volume(std::size_t(dim) * b + k));
    }
  }
};
} // namespace

template <int dim>
View<double*> find_volume_factors(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                                  const NodalVector& increment)
{
  const View<double*> factor("volume factors", cells.empty() ? 0 : stencils.n_particles);
  Kokkos::parallel_for(
      "volume factors", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()), KOKKOS_LAMBDA(const std::size_t c) {
        // First pass: J of every particle, and the volumes of the cell before and after. Second pass: the factors.
        const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
        double before = 0., after = 0.;
        for (unsigned int p = begin; p < end; ++p)
        {
          const double J = determinant(deformation_increment<dim>(stencils, increment, p));
          factor(p) = J;
          if (J > 0.)
          {
            before += particles.initial_volume(p);
            after += particles.initial_volume(p) * J;
          }
        }
        for (unsigned int p = begin; p < end; ++p)
          factor(p) = factor(p) > 0. ? std::pow(after / (before * factor(p)), 1. / dim) : 1.;
      });
  return factor;
}

template <int dim>
void add_mean_dilation(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                       const NodalVector& increment, const View<double* [9]>& moduli, const NodeGraph& graph,
                       const View<double*>& values)
{
  const std::size_t n = dim * cells.nodes.extent(0);
  const MeanDilationKernel<dim> kernel{particles,
                                       stencils,
                                       cells,
                                       increment,
                                       moduli,
                                       graph.row_begin,
                                       graph.column,
                                       values,
                                       View<double*>("force", n),
                                       View<double*>("volume", n)};
  Kokkos::parallel_for("mean dilation", Policy(cells.n_cells(), Kokkos::AUTO), kernel);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template View<double*> find_volume_factors<dim>(const ParticleArrays&, const StencilSet&, const CellGroups&,         \
                                                  const NodalVector&);                                                 \
  template void add_mean_dilation<dim>(const ParticleArrays&, const StencilSet&, const CellGroups&,                    \
                                       const NodalVector&, const View<double* [9]>&, const NodeGraph&,                 \
                                       const View<double*>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
