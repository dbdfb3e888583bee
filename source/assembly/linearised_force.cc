#include <kedge/assembly/lanes.h>
#include <kedge/assembly/linearised_force.h>
#include <kedge/assembly/point_tangents.h>

namespace kedge
{
namespace
{
/// What particle p adds to its cell, pulled back to the start of the step, where [m][i] is entry dim m + i.
template <int dim> struct CellTerms
{
  double stress[dim * dim], dilation[dim * dim], volume[dim * dim];
};

template <int dim> struct LineariseKernel
{
  PointTangents<dim> points;
  LinearisedForce derivative;

  KEDGE_FUNCTION void particle(const unsigned int p) const
  {
    const Eigen::Matrix3d dF = matrix_of(points.particles.trial_deformation, p);
    SpatialTangent tangent;
    points.evaluate(p, determinant(dF), tangent);
    store(p, pull_back(tangent, dF, integration_volume(points.particles, points.stencils, p)).value);
  }

  KEDGE_FUNCTION void operator()(const unsigned int c) const
  {
    const unsigned int begin = points.cells.particle_begin(c), end = points.cells.particle_begin(c + 1);
    double compliance = 0., total = 0.;
    Pulled pulled;
    CellTerms<dim> terms;
    for (unsigned int p = begin; p < end; ++p)
    {
      const Eigen::Matrix3d dF = matrix_of(points.particles.trial_deformation, p);
      const double volume = integration_volume(points.particles, points.stencils, p), J = determinant(dF);
      SpatialTangent tangent;
      const PointDilation dilation = points.evaluate(p, J, tangent);
      compliance += volume * dilation.compliance;
      total += volume * J;
      pulled = pull_back(tangent, dF, volume);
      terms = pull_back(dilation, dF, volume);
      if (end - begin > 1)
      {
        store(p, pulled.value);
        store(p, terms);
      }
    }
    const double modulus = 1. / compliance, spring = points.cells.spring(begin) / total;
    const bool shares = end - begin > 1;
    derivative.modulus(c) = shares ? modulus : 0.;
    derivative.spring(c) = shares ? spring : 0.;
    if (shares)
      return;
    for (int kn = 0; kn < dim * dim; ++kn)
      for (int im = 0; im < dim * dim; ++im)
      {
        const int k = kn % dim, n = kn / dim;
        pulled.value[(n * dim + k) * dim * dim + im] +=
            modulus * terms.stress[im] * terms.dilation[kn] - spring * terms.volume[im] * terms.volume[kn];
      }
    store(begin, pulled.value);
  }

  struct Pulled
  {
    double value[dim * dim * dim * dim]; ///< as LinearisedForce::moduli
  };

  /// V a_ijkl dF^-1_mj dF^-1_nl, one index after the other.
  KEDGE_FUNCTION static Pulled pull_back(const SpatialTangent& tangent, const Eigen::Matrix3d& dF, const double volume)
  {
    const Eigen::Matrix3d to_start = inverse(dF);
    double half[dim][dim][dim][dim]; // [n][k][j][i]
    for (int n = 0; n < dim; ++n)
      for (int k = 0; k < dim; ++k)
        for (int j = 0; j < dim; ++j)
          for (int i = 0; i < dim; ++i)
          {
            double sum = 0.;
            for (int l = 0; l < dim; ++l)
              sum += to_start(n, l) * tangent(i, j, k, l);
            half[n][k][j][i] = volume * sum;
          }
    Pulled result;
    double* to = result.value;
    for (int n = 0; n < dim; ++n)
      for (int k = 0; k < dim; ++k)
        for (int m = 0; m < dim; ++m)
          for (int i = 0; i < dim; ++i, ++to)
          {
            *to = 0.;
            for (int j = 0; j < dim; ++j)
              *to += to_start(m, j) * half[n][k][j][i];
          }
    return result;
  }

  KEDGE_FUNCTION static CellTerms<dim> pull_back(const PointDilation& dilation, const Eigen::Matrix3d& dF,
                                                 const double volume)
  {
    const Eigen::Matrix3d to_start = inverse(dF);
    const double end_volume = volume * determinant(dF);
    CellTerms<dim> terms;
    for (int m = 0; m < dim; ++m)
      for (int i = 0; i < dim; ++i)
      {
        double stress = 0., change = 0.;
        for (int j = 0; j < dim; ++j)
        {
          stress += dilation.stress[3 * i + j] * to_start(m, j);
          change += dilation.volume[3 * i + j] * to_start(m, j);
        }
        terms.stress[dim * m + i] = volume * stress;
        terms.dilation[dim * m + i] = volume * change;
        terms.volume[dim * m + i] = end_volume * to_start(m, i);
      }
    return terms;
  }

  KEDGE_FUNCTION void store(const unsigned int p, const double* value) const
  {
    constexpr int lanes = Lanes<dim>::size;
    for (int row = 0; row < dim * dim * dim; ++row)
    {
      for (int i = 0; i < dim; ++i)
        derivative.moduli(p, lanes * row + i) = value[dim * row + i];
      for (int i = dim; i < lanes; ++i)
        derivative.moduli(p, lanes * row + i) = 0.;
    }
  }

  KEDGE_FUNCTION void store(const unsigned int p, const CellTerms<dim>& terms) const
  {
    for (int m = 0; m < dim; ++m)
      for (int i = 0; i < dim; ++i)
      {
        constexpr int lanes = Lanes<dim>::size, set = dim * lanes;
        const int k = lanes * m + i, transposed = lanes * i + m;
        derivative.cell(p, k) = terms.stress[dim * m + i];
        derivative.cell(p, set + k) = terms.volume[dim * m + i];
        derivative.cell(p, 2 * set + transposed) = terms.dilation[dim * m + i];
        derivative.cell(p, 3 * set + transposed) = terms.volume[dim * m + i];
      }
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
  static constexpr int size = dim * dim, lanes = Lanes<dim>::size;

  KEDGE_FUNCTION void particle(const unsigned int p) const
  {
    Row H[dim], w[dim];
    displacement_gradient<dim>(stencils, direction, p, H);
    multiply(p, H, w);
    scatter(p, w);
  }

  KEDGE_FUNCTION void operator()(const unsigned int c) const
  {
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    if (end - begin == 1)
      return particle(begin);
    Row dilations = Row::Zero(), volumes = Row::Zero();
    for (unsigned int p = begin; p < end; ++p)
    {
      Row H[dim], w[dim];
      displacement_gradient<dim>(stencils, direction, p, H);
      multiply(p, H, w);
      for (int m = 0; m < dim; ++m)
        flux(p, m) = w[m];
      for (int k = 0; k < dim; ++k)
      {
        dilations += cell_row(p, 2, k) * H[k];
        volumes += cell_row(p, 3, k) * H[k];
      }
    }
    double dilation = 0., volume = 0.;
    for (int n = 0; n < dim; ++n) // not the lane behind them
    {
      dilation += derivative.modulus(c) * dilations[n];
      volume += derivative.spring(c) * volumes[n];
    }
    for (unsigned int p = begin; p < end; ++p)
    {
      Row w[dim];
      for (int m = 0; m < dim; ++m)
      {
        w[m] = flux(p, m) + dilation * cell_row(p, 0, m) - volume * cell_row(p, 1, m);
      }
      scatter(p, w);
    }
  }

  /// A row of Rows, which a GPU reads in one piece.
  KEDGE_FUNCTION static Row read_row(const float* from)
  {
    return Lanes<dim>::read(static_cast<const float*>(__builtin_assume_aligned(from, lanes * sizeof(float))));
  }

  /// Row m of a set of a particle's terms.
  KEDGE_FUNCTION Row cell_row(const unsigned int p, const int set, const int m) const
  {
    return read_row(&derivative.cell(p, (set * dim + m) * lanes));
  }

  KEDGE_FUNCTION Eigen::Map<Row> flux(const unsigned int p, const int m) const
  {
    return Eigen::Map<Row>(&derivative.flux(p, m * lanes));
  }

  /// w[m][i] = sum of A_imkn H_kn.
  KEDGE_FUNCTION void multiply(const unsigned int p, const Row (&H)[dim], Row (&w)[dim]) const
  {
    const float* moduli = &derivative.moduli(p, 0);
    Row sum[dim]; // in registers; w itself would be stored and loaded with every term
    for (int m = 0; m < dim; ++m)
      sum[m].setZero();
    for (int n = 0; n < dim; ++n)
      for (int k = 0; k < dim; ++k)
        for (int m = 0; m < dim; ++m, moduli += lanes)
          sum[m] += H[k][n] * read_row(moduli);
    for (int m = 0; m < dim; ++m)
      w[m] = sum[m];
  }

  KEDGE_FUNCTION void scatter(const unsigned int p, const Row (&w)[dim]) const
  {
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
    constexpr int set = dim * Lanes<dim>::size;
    const std::size_t n_sharing = cells.empty() ? 0 : particles.n;
    derivative.moduli = Rows<float>(uninitialised("moduli"), particles.n, dim * dim * set);
    derivative.cell = Rows<float>("terms of the cell", n_sharing, 4 * set); // with zeros in idle lanes
    derivative.flux = Rows<double>(uninitialised("flux"), n_sharing, set);
    derivative.modulus = View<float*>("modulus of the cell", cells.n_cells());
    derivative.spring = View<float*>("spring of the cell", cells.n_cells());
  }
  const LineariseKernel<dim> kernel{{particles, stencils, materials, cells, elastic_share}, derivative};
  if (cells.empty())
    Kokkos::parallel_for(
        "linearise", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n),
        KOKKOS_LAMBDA(const unsigned int i) { kernel.particle(kernel.points.stencils.pattern_particles(i)); });
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
        KOKKOS_LAMBDA(const unsigned int i) { kernel.particle(kernel.stencils.pattern_particles(i)); });
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
