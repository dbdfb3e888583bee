#include <cmath>
#include <kedge/assembly/deformation.h>
#include <kedge/assembly/volume_average.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::TeamPolicy<ExecutionSpace>;
using Member = Policy::member_type;

/// Share of the difference from the cell's mean stress that a step takes away from soil that flows, and the plastic
/// strain in a step from which on soil flows. Soil at rest keeps the gradient of its pressure.
constexpr double relaxed_share = 0.5, flow = 1e-3;

template <int dim> struct MeanDilationKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  CellGroups cells;
  DilationModuli moduli;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;
  // by node of a cell and component, laid out as cells.nodes: changes with the displacement of the node of
  View<double*> force;    ///< the nodal force with the pressure of the cell
  View<double*> dilation; ///< the volume that the cell takes in at a held pressure
  View<double*> volume;   ///< the cell's volume

  KEDGE_FUNCTION void operator()(const Member& team) const
  {
    const unsigned int c = team.league_rank();
    const unsigned int first = cells.node_begin(c), n = cells.node_begin(c + 1) - first;
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    double total = 0., compliance = 0.;
    Kokkos::parallel_reduce(
        Kokkos::TeamThreadRange(team, begin, end), [&](const unsigned int p, double& sum) { sum += gather(p, first); },
        total);
    Kokkos::parallel_reduce(
        Kokkos::TeamThreadRange(team, begin, end),
        [&](const unsigned int p, double& sum)
        { sum += integration_volume(particles, stencils, p) * moduli.compliance(p); },
        compliance);
    team.team_barrier();
    Kokkos::parallel_for(Kokkos::TeamThreadRange(team, n), [&](const unsigned int a)
                         { scatter(first, n, first + a, 1. / compliance, cells.spring(begin) / total); });
  }

  /// Adds a particle's part to the sums of its cell, whose nodes begin at `first`; returns its volume.
  KEDGE_FUNCTION double gather(const unsigned int p, const unsigned int first) const
  {
    const Eigen::Matrix3d dF = matrix_of(particles.trial_deformation, p);
    const Eigen::Matrix3d to_spatial = inverse(dF);
    const double initial = integration_volume(particles, stencils, p), end = initial * determinant(dF);
    const Eigen::Matrix3d stress = full_matrix(row_of(moduli.stress, p)),
                          change = full_matrix(row_of(moduli.volume, p));
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
        double of_force = 0., of_volume = 0.;
        for (int j = 0; j < dim; ++j)
        {
          of_force += stress(i, j) * h[j];
          of_volume += change(i, j) * h[j];
        }
        add_to(force(std::size_t(dim) * at + i), initial * of_force);
        add_to(dilation(std::size_t(dim) * at + i), initial * of_volume);
        add_to(volume(std::size_t(dim) * at + i), end * h[i]);
      }
    }
    return end;
  }

  KEDGE_FUNCTION void scatter(const unsigned int first, const unsigned int n, const unsigned int a,
                              const double modulus, const double spring) const
  {
    const unsigned int row = cells.nodes(a);
    const std::size_t begin = row_begin(row), row_stride = dim * (row_begin(row + 1) - begin);
    double* target = &values(std::size_t(dim) * dim * begin);
    double of_dilation[dim], of_volume[dim];
    for (int i = 0; i < dim; ++i)
    {
      of_dilation[i] = modulus * force(std::size_t(dim) * a + i);
      of_volume[i] = spring * volume(std::size_t(dim) * a + i);
    }
    std::size_t at = begin;
    for (unsigned int b = first; b < first + n; ++b, ++at)
    {
      while (column(at) != cells.nodes(b))
        ++at;
      double* to = target + dim * (at - begin);
      for (int i = 0; i < dim; ++i, to += row_stride)
        for (int k = 0; k < dim; ++k)
        {
          const std::size_t dof = std::size_t(dim) * b + k;
          add_to(to[k], of_dilation[i] * dilation(dof) - of_volume[i] * volume(dof));
        }
    }
  }
};
} // namespace

void relax_pressure(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                    const Materials& materials)
{
  Kokkos::parallel_for(
      "relax pressure", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()), KOKKOS_LAMBDA(const std::size_t c) {
        const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
        double sum = 0., volume = 0., plastic = 0.;
        for (unsigned int p = begin; p < end; ++p)
        {
          sum += integration_volume(particles, stencils, p) * mean_stress<3>(row_of(particles.trial_stress, p));
          plastic += integration_volume(particles, stencils, p) * particles.trial_plastic(p);
          volume += integration_volume(particles, stencils, p);
        }
        const double share = relaxed_share * std::fmin(1., plastic / (flow * volume));
        for (unsigned int p = begin; p < end; ++p)
        {
          const double change = share * (sum / volume - mean_stress<3>(row_of(particles.trial_stress, p)));
          const double bulk = materials(particles.layer(p)).elasticity(particles.young(p)).bulk();
          for (int i = 0; i < 3; ++i)
          {
            particles.trial_stress(p, i) += change;
            particles.trial_strain(p, i) += change / (3. * bulk);
          }
        }
      });
}

template <int dim>
void add_mean_dilation(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                       const DilationModuli& moduli, const NodeGraph& graph, const View<double*>& values)
{
  const std::size_t n = dim * cells.nodes.extent(0);
  const MeanDilationKernel<dim> kernel{particles,
                                       stencils,
                                       cells,
                                       moduli,
                                       graph.row_begin,
                                       graph.column,
                                       values,
                                       View<double*>("force", n),
                                       View<double*>("dilation", n),
                                       View<double*>("volume", n)};
  Kokkos::parallel_for("mean dilation", Policy(cells.n_cells(), Kokkos::AUTO), kernel);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void add_mean_dilation<dim>(const ParticleArrays&, const StencilSet&, const CellGroups&,                    \
                                       const DilationModuli&, const NodeGraph&, const View<double*>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
