#include <Eigen/Core>
#include <Eigen/LU>
#include <KokkosGraph_Distance1Color.hpp>
#include <KokkosKernels_Handle.hpp>
#include <cmath>
#include <kedge/solvers/block_gauss_seidel.h>
#include <limits>
#include <type_traits>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;
/// Numbers of a column of a block, or of a node in a vector: whole SIMD registers.
constexpr int lanes = 4;
using Lanes = Eigen::Array<double, lanes, 1>;
using StoredLanes = Eigen::Map<const Eigen::Array<float, lanes, 1>>;

/// A determinant of less than this share of the product of the diagonal entries counts as zero: then only these are
/// inverted.
constexpr double least_determinant = 1e-3;

template <int size> KEDGE_FUNCTION void write_inverse(const Eigen::Matrix<double, size, size>& block, float* const to)
{
  const double of_diagonal = block.diagonal().prod();
  Eigen::Matrix<double, size, size> inverse = Eigen::Matrix<double, size, size>::Zero();
  for (int i = 0; i < size; ++i)
    inverse(i, i) = 1. / block(i, i);
  if (std::fabs(block.determinant()) > least_determinant * std::fabs(of_diagonal))
    inverse = block.inverse();
  for (int k = 0; k < size; ++k)
    for (int i = 0; i < size; ++i)
      to[lanes * k + i] = static_cast<float>(inverse(i, k));
}

using Vector = Kokkos::View<double*, Kokkos::LayoutLeft, MemorySpace>;
using ConstVector = Kokkos::View<const double*, Kokkos::LayoutLeft, MemorySpace>;
using LocalMatrix = TpetraMatrix::local_matrix_device_type;

/// Calls visit(w, block) for every node w that the rows of node v couple, ascending.
template <int size, typename Visit>
KEDGE_FUNCTION void visit_blocks(const LocalMatrix& local, const int v, const Visit& visit)
{
  std::size_t k[size], end[size];
  for (int i = 0; i < size; ++i)
  {
    k[i] = local.graph.row_map(size * v + i);
    end[i] = local.graph.row_map(size * v + i + 1);
  }
  constexpr int none = std::numeric_limits<int>::max();
  while (true)
  {
    int w = none;
    for (int i = 0; i < size; ++i)
      if (k[i] < end[i] && local.graph.entries(k[i]) / size < w)
        w = local.graph.entries(k[i]) / size;
    if (w == none)
      return;
    Eigen::Matrix<double, size, size> block = Eigen::Matrix<double, size, size>::Zero();
    for (int i = 0; i < size; ++i)
      for (; k[i] < end[i] && local.graph.entries(k[i]) / size == w; ++k[i])
        block(i, local.graph.entries(k[i]) % size) = local.values(k[i]);
    visit(w, block);
  }
}

/// Off the diagonal.
template <int size> struct CountBlocks
{
  LocalMatrix local;
  View<int*> row_begin;

  KEDGE_FUNCTION void operator()(const int v, int& sum, const bool last) const
  {
    if (last)
      row_begin(v) = sum;
    if (v < local.numRows() / size)
      visit_blocks<size>(local, v, [&](const int w, const auto&) { sum += w != v; });
  }
};

template <int size> struct CopyBlocks
{
  LocalMatrix local;
  NodeBlocks held;

  KEDGE_FUNCTION void operator()(const int v) const
  {
    int to = held.row_begin(v);
    visit_blocks<size>(local, v,
                       [&](const int w, const auto& block)
                       {
                         if (w == v)
                         {
                           write_inverse<size>(block, &held.inverse(std::size_t(lanes) * size * v));
                           return;
                         }
                         held.column(to) = w;
                         float* const entry = &held.blocks(std::size_t(lanes) * size * to++);
                         for (int j = 0; j < size; ++j)
                           for (int i = 0; i < size; ++i)
                             entry[lanes * j + i] = static_cast<float>(block(i, j));
                       });
  }
};

/// Room for the blocks of a matrix.
template <int size> NodeBlocks make_room(const LocalMatrix& local, const std::size_t n_columns)
{
  NodeBlocks held;
  const int n = local.numRows() / size;
  held.row_begin = View<int*>("row begin", n + 1);
  int n_blocks = 0;
  Kokkos::parallel_scan("count blocks", Policy(0, n + 1), CountBlocks<size>{local, held.row_begin}, n_blocks);
  held.column = View<int*>("columns", n_blocks);
  held.blocks = View<float*>("blocks", std::size_t(lanes) * size * n_blocks); // with zeros in idle lanes
  held.inverse = View<float*>("inverses", std::size_t(lanes) * size * n);
  held.values = View<double*>("values", lanes * n_columns);
  return held;
}

/// sum -= block x
template <int size> KEDGE_FUNCTION void subtract_product(const float* block, const double* x, Lanes& sum)
{
  for (int k = 0; k < size; ++k)
    sum -= x[k] * StoredLanes(block + lanes * k).template cast<double>();
}

/// Solves the equations of node v for its unknowns, with the present values of all others.
template <int size> KEDGE_FUNCTION void solve_node(const NodeBlocks& held, const ConstVector& side, const int v)
{
  Lanes rest = Lanes::Zero();
  for (int i = 0; i < size; ++i)
    rest[i] = side(size * v + i);
  for (int k = held.row_begin(v); k < held.row_begin(v + 1); ++k)
    subtract_product<size>(&held.blocks(std::size_t(lanes) * size * k),
                           &held.values(std::size_t(lanes) * held.column(k)), rest);
  Lanes solution = Lanes::Zero();
  rest = -rest;
  subtract_product<size>(&held.inverse(std::size_t(lanes) * size * v), rest.data(), solution);
  Eigen::Map<Lanes> into(&held.values(std::size_t(lanes) * v));
  into = solution;
}

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
void sweep_to_and_fro(const NodeBlocks& held, const std::vector<int>& colour_begin, const ConstVector& side)
{
  const std::size_t n_colours = colour_begin.size() - 1;
  for (std::size_t c = 0; c < n_colours; ++c)
    Kokkos::parallel_for(
        "sweep to", Policy(colour_begin[c], colour_begin[c + 1]),
        KOKKOS_LAMBDA(const int i) { solve_node<size>(held, side, held.order(i)); });
  for (std::size_t c = n_colours; c-- > 0;)
  {
    const int ends = colour_begin[c] + colour_begin[c + 1] - 1;
    Kokkos::parallel_for(
        "sweep fro", Policy(colour_begin[c], colour_begin[c + 1]),
        KOKKOS_LAMBDA(const int i) { solve_node<size>(held, side, held.order(ends - i)); });
  }
}

auto read(const TpetraVector& vector)
{
  return Kokkos::subview(vector.getLocalViewDevice(Tpetra::Access::ReadOnly), Kokkos::ALL(), 0);
}
} // namespace

SweepOrder sweep_order()
{
#ifdef KOKKOS_ENABLE_SERIAL
  if (std::is_same_v<ExecutionSpace, Kokkos::Serial>)
    return SweepOrder::by_number;
#endif
  return SweepOrder::by_colour;
}

BlockGaussSeidel::BlockGaussSeidel(const TpetraMatrix& matrix, const unsigned int block_size_, const SweepOrder order)
    : block_size(block_size_), column_map(matrix.getColMap()), importer(matrix.getGraph()->getImporter())
{
  const auto local = matrix.getLocalMatrixDevice();
  n_nodes = local.numRows() / block_size;
  n_columns = local.numCols() / block_size;
  held = block_size == 2 ? make_room<2>(local, n_columns) : make_room<3>(local, n_columns);
  renew(matrix);
  set_order(order);
}

/// By number is one colour in which nodes follow each other.
void BlockGaussSeidel::set_order(const SweepOrder kind)
{
  const int n = static_cast<int>(n_nodes);
  std::vector<int> nodes(n), colour(n, 0);
  if (kind == SweepOrder::by_colour && n > 0)
  {
    using Handle =
        KokkosKernels::Experimental::KokkosKernelsHandle<int, int, float, ExecutionSpace, MemorySpace, MemorySpace>;
    Handle handle;
    // On the host, but the same colours in every run; the parallel algorithm with that quality has too few colours for
    // nodes that are all coupled (Kokkos Kernels 3.4). Columns of other ranks are no nodes here and have no colour.
    handle.create_graph_coloring_handle(KokkosGraph::COLORING_SERIAL);
    KokkosGraph::Experimental::graph_color(&handle, n, static_cast<int>(n_columns), held.row_begin, held.column);
    const auto of_nodes = handle.get_graph_coloring_handle()->get_vertex_colors(); // from 1 on
    const auto on_host = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), of_nodes);
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
  held.order = upload(nodes, "order of nodes");
}

void BlockGaussSeidel::renew(const TpetraMatrix& matrix)
{
  const auto local = matrix.getLocalMatrixDevice();
  if (block_size == 2)
    Kokkos::parallel_for("copy blocks", Policy(0, n_nodes), CopyBlocks<2>{local, held});
  else
    Kokkos::parallel_for("copy blocks", Policy(0, n_nodes), CopyBlocks<3>{local, held});
}

void BlockGaussSeidel::sweep(const TpetraVector& b, TpetraVector& x) const
{
  const int size = static_cast<int>(block_size);
  if (importer.is_null())
    read_into_lanes(read(x), size, held.values);
  else
  {
    TpetraVector with_ghosts(column_map);
    with_ghosts.doImport(x, *importer, Tpetra::INSERT);
    read_into_lanes(read(with_ghosts), size, held.values);
  }
  if (size == 2)
    sweep_to_and_fro<2>(held, colour_begin, read(b));
  else
    sweep_to_and_fro<3>(held, colour_begin, read(b));
  write_from_lanes(held.values, size,
                   Kokkos::subview(x.getLocalViewDevice(Tpetra::Access::OverwriteAll), Kokkos::ALL(), 0));
}
} // namespace kedge
