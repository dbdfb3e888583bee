// Finite elements with the mean moduli of their soil.
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/lanes.h>
#include <kedge/assembly/linearised_force.h>

namespace kedge
{
namespace
{
template <int dim> struct ElementKernel
{
  Elements elements;
  CellGroups cells;
  LinearisedForce derivative;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;

  using Row = typename Lanes<dim>::Type;
  static constexpr int lanes = Lanes<dim>::size, set = dim * lanes, n_places = 1 << dim;

  KEDGE_FUNCTION void operator()(const unsigned int e) const
  {
    double moduli[dim * dim * set] = {};
    for (unsigned int i = elements.part_begin(e); i < elements.part_begin(e + 1); ++i)
    {
      const double share = elements.share(i) / n_places;
      for (int k = 0; k < dim * dim * set; ++k)
        moduli[k] += share * derivative.moduli(elements.particle(i), k);
    }
    double terms[3 * set] = {}, modulus = 0., spring = 0.;
    const int c = elements.cell(e);
    if (c >= 0)
    {
      modulus = derivative.modulus(c) / (n_places * n_places);
      spring = derivative.spring(c) / (n_places * n_places);
      for (unsigned int p = cells.particle_begin(c); p < cells.particle_begin(c + 1); ++p)
        for (int i = 0; i < 3 * set; ++i) // of which `volume` once
          terms[i] += derivative.cell(p, i);
    }
    const unsigned int first = elements.node_begin(e), n = elements.node_begin(e + 1) - first;
    for (unsigned int a = 0; a < n; ++a)
    {
      double of_a[3][dim];
      contract(terms, first, n, a, of_a);
      const unsigned int row = elements.nodes(first + a);
      const std::size_t begin = row_begin(row), length = row_begin(row + 1) - begin;
      std::size_t at = begin;
      for (unsigned int b = 0; b < n; ++b, ++at)
      {
        while (column(at) != elements.nodes(first + b)) // both lists ascend
          ++at;
        double of_b[3][dim];
        contract(terms, first, n, b, of_b);
        Row block[dim];
        for (int k = 0; k < dim; ++k)
          block[k].setZero();
        add_block(moduli, first, n, a, b, block);
        for (int i = 0; i < dim; ++i)
          for (int k = 0; k < dim; ++k)
            add_to(values(std::size_t(dim) * (dim * begin + i * length + at - begin) + k),
                   block[k][i] + modulus * of_a[0][i] * of_b[2][k] - spring * of_a[1][i] * of_b[1][k]);
      }
    }
  }

  /// of[t][i] = sum over places and m of grad_m of node v times entry m, i of terms t; i, m for t = 2.
  KEDGE_FUNCTION void contract(const double* terms, const unsigned int first, const unsigned int n,
                               const unsigned int v, double (&of)[3][dim]) const
  {
    double g[dim] = {};
    for (int s = 0; s < n_places; ++s)
      for (int m = 0; m < dim; ++m)
        g[m] += elements.gradient(dim * (n_places * first + n * s + v) + m);
    for (int t = 0; t < 3; ++t)
      for (int i = 0; i < dim; ++i)
      {
        of[t][i] = 0.;
        for (int m = 0; m < dim; ++m)
          of[t][i] += terms[set * t + (t < 2 ? lanes * m + i : lanes * i + m)] * g[m];
      }
  }

  /// block[k][i] += sum of moduli_imkl times grad_m of a and grad_l of b over the places.
  KEDGE_FUNCTION void add_block(const double* moduli, const unsigned int first, const unsigned int n,
                                const unsigned int a, const unsigned int b, Row (&block)[dim]) const
  {
    Row product[dim]; // [l][m]
    for (int l = 0; l < dim; ++l)
      product[l].setZero();
    for (int s = 0; s < n_places; ++s)
    {
      const Row of_a = Lanes<dim>::read(&elements.gradient(dim * (n_places * first + n * s + a)));
      const double* of_b = &elements.gradient(dim * (n_places * first + n * s + b));
      for (int l = 0; l < dim; ++l)
        product[l] += of_b[l] * of_a;
    }
    for (int l = 0; l < dim; ++l)
      for (int k = 0; k < dim; ++k)
        for (int m = 0; m < dim; ++m)
          block[k] += product[l][m] * Lanes<dim>::map(moduli + ((dim * l + k) * dim + m) * lanes);
  }
};
} // namespace

template <int dim>
void add_element_stiffness(const Elements& elements, const CellGroups& cells, const LinearisedForce& derivative,
                           const NodeGraph& graph, const View<double*>& values)
{
  Kokkos::parallel_for("element stiffness", Kokkos::RangePolicy<ExecutionSpace>(0, elements.n()),
                       ElementKernel<dim>{elements, cells, derivative, graph.row_begin, graph.column, values});
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void add_element_stiffness<dim>(const Elements&, const CellGroups&, const LinearisedForce&,                 \
                                           const NodeGraph&, const View<double*>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
