#include <Eigen/Core>
#include <KokkosGraph_Distance1Color.hpp>
#include <KokkosKernels_Handle.hpp>
#include <kedge/base/groups.h>
#include <kedge/solvers/block_gauss_seidel.h>

namespace kedge
{
/// Numbers of a node, which some threads add up.
struct NodeSum
{
  Eigen::Array<double, block_lanes, 1> value;

  KEDGE_FUNCTION NodeSum() { value.setZero(); }
  KEDGE_FUNCTION NodeSum& operator+=(const NodeSum& other)
  {
    value += other.value;
    return *this;
  }
};
} // namespace kedge

namespace Kokkos
{
template <> struct reduction_identity<kedge::NodeSum>
{
  KOKKOS_FORCEINLINE_FUNCTION static kedge::NodeSum sum() { return {}; }
};
} // namespace Kokkos

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;
constexpr int lanes = block_lanes;
using Lanes = Eigen::Array<double, lanes, 1>;
using StoredLanes = Eigen::Map<const Eigen::Array<float, lanes, 1>>;
using Vector = Kokkos::View<double*, Kokkos::LayoutLeft, MemorySpace>;
using ConstVector = Kokkos::View<const double*, Kokkos::LayoutLeft, MemorySpace>;

/// What the sweeps work on.
struct Sweep
{
  NodeBlocks matrix;
  View<double*> values; ///< of owned nodes, then ghosts, in lanes
  View<int*> order;     ///< the nodes, colour by colour
};

/// sum += block x, in one addition: the next block waits for no other.
template <int size> KEDGE_FUNCTION void add_product(const float* block, const double* x, Lanes& sum)
{
  Lanes product = x[0] * StoredLanes(block).template cast<double>();
  for (int k = 1; k < size; ++k)
    product += x[k] * StoredLanes(block + lanes * k).template cast<double>();
  sum += product;
}

/// Solves the equations of node v for its unknowns, with the present values of all others.
template <int size>
KEDGE_FUNCTION void solve_node(const GroupMember& group, const Sweep& at, const ConstVector& side, const int v)
{
  const int begin = at.matrix.row_begin(v), n = at.matrix.row_begin(v + 1) - begin;
  NodeSum of_others;
  Kokkos::parallel_reduce(
      Kokkos::ThreadVectorRange(group, n),
      [&](const int k, NodeSum& sum)
      {
        add_product<size>(at.matrix.block(begin + k), &at.values(std::size_t(lanes) * at.matrix.column(begin + k)),
                          sum.value);
      },
      of_others);
  Kokkos::single(Kokkos::PerThread(group),
                 [&]
                 {
                   Lanes rest = -of_others.value, solution = Lanes::Zero();
                   for (int i = 0; i < size; ++i)
                     rest[i] += side(size * v + i);
                   add_product<size>(&at.matrix.inverse(std::size_t(lanes) * size * v), rest.data(), solution);
                   Eigen::Map<Lanes>(&at.values(std::size_t(lanes) * v)) = solution;
                 });
}

template <int size> struct SweepKernel
{
  Sweep at;
  ConstVector side;
  int first, step; ///< in at.order

  KEDGE_FUNCTION void operator()(const GroupMember& group, const double*, const unsigned int i) const
  {
    solve_node<size>(group, at, side, at.order(first + step * static_cast<int>(i)));
  }
};

void read_into_lanes(const ConstVector& from, const int size, const View<double*>& values)
{
  Kokkos::parallel_for(
      "read into lanes", Policy(0, from.extent(0)),
      KOKKOS_LAMBDA(const int dof) { values(lanes * (dof / size) + dof % size) = from(dof); });
}

void write_from_lanes(const View<double*>& values, const int size, const Vector& to)
{
  Kokkos::parallel_for(
      "write from lanes", Policy(0, to.extent(0)),
      KOKKOS_LAMBDA(const int dof) { to(dof) = values(lanes * (dof / size) + dof % size); });
}

template <int size>
void sweep_to_and_fro(const Sweep& at, const std::vector<int>& colour_begin, const ConstVector& side)
{
  const std::size_t n_colours = colour_begin.size() - 1;
  for (std::size_t c = 0; c < n_colours; ++c)
    for_each_in_groups("sweep to", colour_begin[c + 1] - colour_begin[c], 0,
                       SweepKernel<size>{at, side, colour_begin[c], 1});
  for (std::size_t c = n_colours; c-- > 0;)
    for_each_in_groups("sweep fro", colour_begin[c + 1] - colour_begin[c], 0,
                       SweepKernel<size>{at, side, colour_begin[c + 1] - 1, -1});
}

auto read(const TpetraVector& vector)
{
  return Kokkos::subview(vector.getLocalViewDevice(Tpetra::Access::ReadOnly), Kokkos::ALL(), 0);
}
} // namespace

SweepOrder sweep_order() { return one_thread ? SweepOrder::by_number : SweepOrder::by_colour; }

BlockGaussSeidel::BlockGaussSeidel(const TpetraMatrix& matrix, const NodeBlocks& blocks_, const SweepOrder sweep_order)
    : blocks(blocks_),
      column_map(matrix.getColMap()),
      importer(matrix.getGraph()->getImporter()),
      values("values", lanes * blocks_.n_columns)
{
  set_order(sweep_order);
}

/// By number is one colour in which nodes follow each other.
void BlockGaussSeidel::set_order(const SweepOrder kind)
{
  const int n = static_cast<int>(blocks.n_nodes);
  std::vector<int> nodes(n), colour(n, 0);
  if (kind == SweepOrder::by_colour && n > 0)
  {
    using Handle =
        KokkosKernels::Experimental::KokkosKernelsHandle<int, int, float, ExecutionSpace, MemorySpace, MemorySpace>;
    Handle handle;
    // On the host, but the same colours in every run; the parallel algorithm with that quality has too few colours for
    // nodes that are all coupled (Kokkos Kernels 3.4). Columns of other ranks are no nodes here and have no colour.
    handle.create_graph_coloring_handle(KokkosGraph::COLORING_SERIAL);
    KokkosGraph::Experimental::graph_color(&handle, n, static_cast<int>(blocks.n_columns), blocks.row_begin,
                                           blocks.column);
    const auto of_nodes = handle.get_graph_coloring_handle()->get_vertex_colors(); // from 1 on
    const auto on_host = copy_to_host(of_nodes);
    for (int v = 0; v < n; ++v)
      colour[v] = static_cast<int>(on_host(v)) - 1;
    handle.destroy_graph_coloring_handle();
  }
  colour_begin.assign(2, 0);
  for (const int c : colour)
  {
    if (c + 2 > static_cast<int>(colour_begin.size()))
      colour_begin.resize(c + 2, 0);
    ++colour_begin[c + 1];
  }
  for (std::size_t c = 1; c < colour_begin.size(); ++c)
    colour_begin[c] += colour_begin[c - 1];
  std::vector<int> next(colour_begin);
  for (int v = 0; v < n; ++v)
    nodes[next[colour[v]]++] = v;
  order = upload(nodes, "order of nodes");
}

void BlockGaussSeidel::sweep(const TpetraVector& b, TpetraVector& x) const
{
  const int size = static_cast<int>(blocks.block_size);
  if (importer.is_null())
    read_into_lanes(read(x), size, values);
  else
  {
    TpetraVector with_ghosts(column_map);
    with_ghosts.doImport(x, *importer, Tpetra::INSERT);
    read_into_lanes(read(with_ghosts), size, values);
  }
  const Sweep at{blocks, values, order};
  if (size == 2)
    sweep_to_and_fro<2>(at, colour_begin, read(b));
  else
    sweep_to_and_fro<3>(at, colour_begin, read(b));
  write_from_lanes(values, size, Kokkos::subview(x.getLocalViewDevice(Tpetra::Access::OverwriteAll), Kokkos::ALL(), 0));
}
} // namespace kedge
