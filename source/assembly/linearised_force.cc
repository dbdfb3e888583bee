#include <kedge/assembly/linearised_force.h>
#include <kedge/assembly/principal_moduli.h>

namespace kedge
{
namespace
{
std::size_t largest_cell(const CellGroups& cells)
{
  std::size_t n = 0;
  Kokkos::parallel_reduce(
      "largest cell", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()),
      KOKKOS_LAMBDA(const std::size_t c, std::size_t& most) {
        const std::size_t in_cell = cells.particle_begin(c + 1) - cells.particle_begin(c);
        most = in_cell > most ? in_cell : most;
      },
      Kokkos::Max<std::size_t>(n));
  return n;
}

template <int dim> struct LineariseKernel
{
  PointTangents<dim> points;
  LinearisedForce derivative;

  /// Without F-bar.
  KEDGE_FUNCTION void particle(const unsigned int p) const
  {
    const Eigen::Matrix3d dF = matrix_of(points.particles.trial_deformation, p);
    PrincipalTangent tangent;
    points.evaluate(p, determinant(dF), tangent);
    store(p, tangent, integration_volume(points.particles, points.stencils, p), dF);
  }

  KEDGE_FUNCTION void operator()(const unsigned int c) const
  {
    const unsigned int begin = points.cells.particle_begin(c), end = points.cells.particle_begin(c + 1);
    const bool shares = end - begin > 1;
    double compliance = 0., total = 0.;
    for (unsigned int p = begin; p < end; ++p)
    {
      const Eigen::Matrix3d dF = matrix_of(points.particles.trial_deformation, p);
      const double volume = integration_volume(points.particles, points.stencils, p), J = determinant(dF);
      PrincipalTangent tangent;
      const PointDilation dilation = points.evaluate(p, J, tangent);
      if (!shares)
        for (int m = 0; m < dim; ++m)
          for (int n = 0; n < dim; ++n)
            tangent.direct[m][n] +=
                dilation.stress[m] * dilation.volume[n] / dilation.compliance - points.cells.spring(p) * J;
      store(p, tangent, volume, dF);
      CellModuli<dim>::store(dilation, volume, J, &derivative.cell(p, 0));
      compliance += volume * dilation.compliance;
      total += volume * J;
    }
    derivative.modulus(c) = shares ? 1. / compliance : 0.;
    derivative.spring(c) = shares ? points.cells.spring(begin) / total : 0.;
  }

  KEDGE_FUNCTION void store(const unsigned int p, const PrincipalTangent& tangent, const double volume,
                            const Eigen::Matrix3d& dF) const
  {
    PrincipalModuli<dim>::store(tangent, volume,
                                trial_frame<dim>(points.particles, points.cells.volume_factor, p).directions,
                                inverse(dF), &derivative.moduli(p, 0));
  }
};

template <int dim> struct ProductKernel
{
  StencilSet stencils;
  CellGroups cells;
  LinearisedForce derivative;
  NodalVector direction;
  View<double*> force; ///< `lanes` numbers per local node

  using Row = typename Lanes<dim>::Type;
  static constexpr int lanes = Lanes<dim>::size;

  KEDGE_FUNCTION void particle(const unsigned int p) const
  {
    const PrincipalModuli<dim> moduli = moduli_of(p);
    Row h[dim];
    double s[dim][dim];
    find_gradient(p, moduli, h);
    moduli.change_stress(h, s);
    scatter(p, moduli, s);
  }

  KEDGE_FUNCTION void operator()(const unsigned int c) const
  {
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    if (end - begin == 1)
      return particle(begin);
    const unsigned int first = one_thread ? begin : 0; // a cell at a time needs room for one cell
    double dilation = 0., volume = 0.;
    for (unsigned int p = begin; p < end; ++p)
    {
      const PrincipalModuli<dim> moduli = moduli_of(p);
      const CellModuli<dim> of_cell(&derivative.cell(p, 0));
      Row h[dim];
      double s[dim][dim];
      find_gradient(p, moduli, h);
      moduli.change_stress(h, s);
      for (int m = 0; m < dim; ++m)
        for (int n = 0; n < dim; ++n)
          derivative.stress(p - first, dim * m + n) = s[m][n];
      dilation += of_cell.change_of_dilation(h);
      volume += of_cell.change_of_volume(h);
    }
    dilation *= derivative.modulus(c);
    volume *= derivative.spring(c);
    for (unsigned int p = begin; p < end; ++p)
    {
      const CellModuli<dim> of_cell(&derivative.cell(p, 0));
      double s[dim][dim];
      for (int m = 0; m < dim; ++m)
      {
        for (int n = 0; n < dim; ++n)
          s[m][n] = derivative.stress(p - first, dim * m + n);
        s[m][m] += dilation * of_cell.stress(m) - volume * of_cell.volume();
      }
      scatter(p, moduli_of(p), s);
    }
  }

  KEDGE_FUNCTION PrincipalModuli<dim> moduli_of(const unsigned int p) const
  {
    return PrincipalModuli<dim>(&derivative.moduli(p, 0));
  }

  KEDGE_FUNCTION void find_gradient(const unsigned int p, const PrincipalModuli<dim>& moduli, Row (&h)[dim]) const
  {
    Row H[dim];
    displacement_gradient<dim>(stencils, direction, p, H);
    moduli.turn_gradient(H, h);
  }

  KEDGE_FUNCTION void scatter(const unsigned int p, const PrincipalModuli<dim>& moduli,
                              const double (&s)[dim][dim]) const
  {
    Row w[dim];
    moduli.turn_stress(s, w);
    const ParticleNodes at = nodes_of(stencils, p);
    const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
    for (unsigned int v = 0; v < at.n; ++v)
    {
      Row f = w[0] * gradient[dim * v];
      for (int m = 1; m < dim; ++m)
        f += w[m] * gradient[dim * v + m];
      add_to<lanes, dim>(&force(std::size_t(lanes) * at.node[v]), f.matrix());
    }
  }
};
} // namespace

template <int dim>
LinearisedForce linearise_force(const ParticleArrays& particles, const StencilSet& stencils, const Materials& materials,
                                const CellGroups& cells, const double elastic_share, LinearisedForce derivative)
{
  if (derivative.moduli.extent(0) != particles.n)
  {
    const auto uninitialised = [](const std::string& label)
    { return Kokkos::view_alloc(label, Kokkos::WithoutInitializing); };
    const std::size_t n_sharing = cells.empty() ? 0 : particles.n;
    derivative.moduli = Rows<float>(uninitialised("moduli"), particles.n, PrincipalModuli<dim>::size);
    derivative.cell = Rows<float>(uninitialised("moduli of the cell"), n_sharing, CellModuli<dim>::size);
    derivative.stress =
        Rows<double>(uninitialised("change of stress"), one_thread ? largest_cell(cells) : n_sharing, dim * dim);
    derivative.modulus = View<float*>("modulus of the cell", cells.n_cells());
    derivative.spring = View<float*>("spring of the cell", cells.n_cells());
  }
  const LineariseKernel<dim> kernel{{particles, stencils, materials, cells, elastic_share}, derivative};
  if (cells.empty())
    Kokkos::parallel_for(
        "linearise", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n),
        KOKKOS_LAMBDA(const unsigned int p) { kernel.particle(p); });
  else
    Kokkos::parallel_for("linearise by cell", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()), kernel);
  return derivative;
}

template <int dim>
void add_linearised_force(const StencilSet& stencils, const CellGroups& cells, const LinearisedForce& derivative,
                          const NodalVector& direction, const NodalVector& force)
{
  const std::size_t n_nodes = force.extent(0) / dim;
  constexpr int lanes = Lanes<dim>::size;
  const View<double*> sums("force in lanes", lanes * n_nodes);
  const ProductKernel<dim> kernel{stencils, cells, derivative, direction, sums};
  if (cells.empty())
    Kokkos::parallel_for(
        "product", Kokkos::RangePolicy<ExecutionSpace>(0, stencils.n_particles),
        KOKKOS_LAMBDA(const unsigned int p) { kernel.particle(p); });
  else
    Kokkos::parallel_for("product by cell", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()), kernel);
  Kokkos::parallel_for(
      "sum product", Kokkos::RangePolicy<ExecutionSpace>(0, n_nodes), KOKKOS_LAMBDA(const std::size_t v) {
        for (int i = 0; i < dim; ++i)
          force(dim * v + i) += sums(lanes * v + i);
      });
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template LinearisedForce linearise_force<dim>(const ParticleArrays&, const StencilSet&, const Materials&,            \
                                                const CellGroups&, double, LinearisedForce);                           \
  template void add_linearised_force<dim>(const StencilSet&, const CellGroups&, const LinearisedForce&,                \
                                          const NodalVector&, const NodalVector&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
