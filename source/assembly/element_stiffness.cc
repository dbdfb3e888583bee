// Finite elements with the mean moduli of their soil.
#include <kedge/assembly/linearised_force.h>
#include <kedge/assembly/principal_moduli.h>
#include <kedge/base/groups.h>

namespace kedge
{
namespace
{
/// What a group holds of an element: mean moduli, sums of the terms of F-bar, and for each node these sums times its
/// mean gradient.
template <int dim> struct ElementMemory
{
  using Row = typename Lanes<dim>::Type;
  static constexpr int lanes = Lanes<dim>::size, n_moduli = dim * dim * dim * lanes, n_terms = 3 * dim * lanes,
                       n_of_node = 3 * dim;
  double *moduli, *terms, *of_nodes;

  KEDGE_FUNCTION explicit ElementMemory(double* const memory)
      : moduli(memory), terms(memory + n_moduli), of_nodes(memory + n_moduli + n_terms)
  {
  }
  static std::size_t size(const unsigned int max_nodes) { return n_moduli + n_terms + n_of_node * max_nodes; }
  KEDGE_FUNCTION Eigen::Map<Row> term(const int t, const int m) const
  {
    return Eigen::Map<Row>(terms + lanes * (dim * t + m));
  }
  /// Component i of term t.
  KEDGE_FUNCTION double& of_node(const unsigned int v, const int t, const int i) const
  {
    return of_nodes[n_of_node * v + dim * t + i];
  }
};

template <int dim> struct ElementKernel
{
  Elements elements;
  CellGroups cells;
  LinearisedForce derivative;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;

  using Memory = ElementMemory<dim>;
  using Row = typename Lanes<dim>::Type;
  static constexpr int lanes = Lanes<dim>::size, n_places = 1 << dim;

  KEDGE_FUNCTION void operator()(const GroupMember& group, double* const room, const unsigned int e) const
  {
    const Memory memory(room);
    average_moduli(group, e, memory);
    const int c = elements.cell(e);
    sum_terms(group, c, memory);
    const double modulus = c < 0 ? 0. : derivative.modulus(c) / (n_places * n_places),
                 spring = c < 0 ? 0. : derivative.spring(c) / (n_places * n_places);
    const unsigned int first = elements.node_begin(e), n = elements.node_begin(e + 1) - first;
    Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, n),
                         [&](const unsigned int v) { contract(memory, first, n, v); });
    Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, n),
                         [&](const unsigned int a) { add_row(memory, first, n, a, modulus, spring); });
  }

  /// A_imkl in row (l dim + k) dim + m.
  KEDGE_FUNCTION void average_moduli(const GroupMember& group, const unsigned int e, const Memory& memory) const
  {
    Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, Memory::n_moduli),
                         [&](const int entry) { memory.moduli[entry] = 0.; });
    for (unsigned int i = elements.part_begin(e); i < elements.part_begin(e + 1); ++i)
    {
      const double share = elements.share(i) / n_places;
      const PrincipalModuli<dim> moduli(&derivative.moduli(elements.particle(i), 0));
      Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, dim),
                           [&](const int k) { moduli.add_moduli(k, share, memory.moduli); });
    }
  }

  /// Of group c of F-bar, on the axes of space: its particles' stress, volume and dilation, row by row in lanes; zeros
  /// without a group.
  KEDGE_FUNCTION void sum_terms(const GroupMember& group, const int c, const Memory& memory) const
  {
    const unsigned int begin = c < 0 ? 0 : cells.particle_begin(c), end = c < 0 ? 0 : cells.particle_begin(c + 1);
    Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, dim),
                         [&](const int m)
                         {
                           Row stress = Row::Zero(), volume = Row::Zero(), dilation = Row::Zero();
                           for (unsigned int p = begin; p < end; ++p)
                           {
                             const PrincipalModuli<dim> moduli(&derivative.moduli(p, 0));
                             const CellModuli<dim> of_cell(&derivative.cell(p, 0));
                             for (int r = 0; r < dim; ++r)
                             {
                               const Row dyad = moduli.dyad(r, m);
                               stress += of_cell.stress(r) * dyad;
                               volume += of_cell.volume() * dyad;
                               dilation += of_cell.dilation(r) * dyad;
                             }
                           }
                           memory.term(0, m) = stress;
                           memory.term(1, m) = volume;
                           memory.term(2, m) = dilation;
                         });
  }

  /// The row of blocks of node a.
  KEDGE_FUNCTION void add_row(const Memory& memory, const unsigned int first, const unsigned int n,
                              const unsigned int a, const double modulus, const double spring) const
  {
    const unsigned int row = elements.nodes(first + a);
    const std::size_t begin = row_begin(row), length = row_begin(row + 1) - begin;
    std::size_t at = begin;
    for (unsigned int b = 0; b < n; ++b, ++at)
    {
      while (column(at) != elements.nodes(first + b)) // both lists ascend
        ++at;
      Row block[dim];
      for (int k = 0; k < dim; ++k)
        block[k].setZero();
      add_block(memory.moduli, first, n, a, b, block);
      for (int i = 0; i < dim; ++i)
        for (int k = 0; k < dim; ++k)
          add_to(values(std::size_t(dim) * (dim * begin + i * length + at - begin) + k),
                 block[k][i] + modulus * memory.of_node(a, 0, i) * memory.of_node(b, 2, k) -
                     spring * memory.of_node(a, 1, i) * memory.of_node(b, 1, k));
    }
  }

  /// Of node v, term t: sum over places and m of grad_m of the node times entry m, i of the term.
  KEDGE_FUNCTION void contract(const Memory& memory, const unsigned int first, const unsigned int n,
                               const unsigned int v) const
  {
    double g[dim] = {};
    for (int s = 0; s < n_places; ++s)
      for (int m = 0; m < dim; ++m)
        g[m] += elements.gradient(dim * (n_places * first + n * s + v) + m);
    for (int t = 0; t < 3; ++t)
      for (int i = 0; i < dim; ++i)
      {
        double sum = 0.;
        for (int m = 0; m < dim; ++m)
          sum += memory.term(t, m)[i] * g[m];
        memory.of_node(v, t, i) = sum;
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
  unsigned int max_nodes = 0;
  Kokkos::parallel_reduce(
      "largest element", Kokkos::RangePolicy<ExecutionSpace>(0, elements.n()),
      KOKKOS_LAMBDA(const unsigned int e, unsigned int& most) {
        const unsigned int n = elements.node_begin(e + 1) - elements.node_begin(e);
        most = n > most ? n : most;
      },
      Kokkos::Max<unsigned int>(max_nodes));
  for_each_in_groups("element stiffness", elements.n(), ElementMemory<dim>::size(max_nodes),
                     ElementKernel<dim>{elements, cells, derivative, graph.row_begin, graph.column, values});
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void add_element_stiffness<dim>(const Elements&, const CellGroups&, const LinearisedForce&,                 \
                                           const NodeGraph&, const View<double*>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
