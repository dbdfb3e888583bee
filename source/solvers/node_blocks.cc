#include <Eigen/LU>
#include <cmath>
#include <kedge/base/groups.h>
#include <kedge/solvers/node_blocks.h>
#include <limits>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;
using LocalMatrix = TpetraMatrix::local_matrix_device_type;
constexpr int lanes = block_lanes;

/// A determinant of less than this share of the product of the diagonal entries counts as zero: then only these are
/// inverted.
constexpr double least_determinant = 1e-3;

template <int size> KEDGE_FUNCTION void write_block(const Eigen::Matrix<double, size, size>& block, float* const to)
{
  for (int k = 0; k < size; ++k)
    for (int i = 0; i < size; ++i)
      to[lanes * k + i] = static_cast<float>(block(i, k));
}

template <int size>
KEDGE_FUNCTION Eigen::Matrix<double, size, size> safe_inverse(const Eigen::Matrix<double, size, size>& block)
{
  const double of_diagonal = block.diagonal().prod();
  Eigen::Matrix<double, size, size> inverse = Eigen::Matrix<double, size, size>::Zero();
  for (int i = 0; i < size; ++i)
    inverse(i, i) = 1. / block(i, i);
  if (std::fabs(block.determinant()) > least_determinant * std::fabs(of_diagonal))
    inverse = block.inverse();
  return inverse;
}

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

  using Block = Eigen::Matrix<double, size, size>;

  KEDGE_FUNCTION void operator()(const GroupMember& group, const double*, const unsigned int v) const
  {
    const int begin = held.row_begin(v), n = held.row_begin(v + 1) - begin + 1;
    if (!is_full(v, n))
    {
      Kokkos::single(Kokkos::PerThread(group), [&] { copy_in_turn(static_cast<int>(v)); });
      return;
    }
    const std::size_t first = local.graph.row_map(size * v), length = std::size_t(size) * n;
    Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, n),
                         [&](const int k)
                         {
                           const int w = local.graph.entries(first + size * k) / size;
                           Block block;
                           for (int i = 0; i < size; ++i)
                             for (int j = 0; j < size; ++j)
                               block(i, j) = local.values(first + i * length + size * k + j);
                           write(static_cast<int>(v), w, begin + k - (w > static_cast<int>(v)), block);
                         });
  }

  /// Whether the rows of node v hold n whole blocks, so that each begins at a multiple of `size`.
  KEDGE_FUNCTION bool is_full(const unsigned int v, const int n) const
  {
    bool full = true;
    for (int i = 0; i < size; ++i)
      full = full && local.graph.row_map(size * v + i + 1) - local.graph.row_map(size * v + i) == std::size_t(size) * n;
    return full;
  }

  KEDGE_FUNCTION void copy_in_turn(const int v) const
  {
    int to = held.row_begin(v);
    visit_blocks<size>(local, v,
                       [&](const int w, const Block& block)
                       {
                         write(v, w, to, block);
                         to += w != v;
                       });
  }

  KEDGE_FUNCTION void write(const int v, const int w, const int to, const Block& block) const
  {
    if (w == v)
    {
      const std::size_t at = std::size_t(lanes) * size * v;
      write_block<size>(block, &held.diagonal(at));
      write_block<size>(safe_inverse<size>(block), &held.inverse(at));
      return;
    }
    held.column(to) = w;
    write_block<size>(block, &held.blocks(std::size_t(lanes) * size * to));
  }
};

template <int size> View<int*> count_blocks(const LocalMatrix& local, int& n_blocks)
{
  const int n = local.numRows() / size;
  const View<int*> row_begin("row begin", n + 1);
  Kokkos::parallel_scan("count blocks", Policy(0, n + 1), CountBlocks<size>{local, row_begin}, n_blocks);
  return row_begin;
}
} // namespace

NodeBlocks make_node_blocks(const TpetraMatrix& matrix, const unsigned int block_size)
{
  const auto local = matrix.getLocalMatrixDevice();
  NodeBlocks held;
  held.block_size = block_size;
  held.n_nodes = local.numRows() / block_size;
  held.n_columns = local.numCols() / block_size;
  int n_blocks = 0;
  held.row_begin = block_size == 2 ? count_blocks<2>(local, n_blocks) : count_blocks<3>(local, n_blocks);
  const std::size_t numbers = std::size_t(lanes) * block_size;
  held.column = View<int*>("columns", n_blocks);
  held.blocks = View<float*>("blocks", numbers * n_blocks); // with zeros in idle lanes
  held.diagonal = View<float*>("diagonal blocks", numbers * held.n_nodes);
  held.inverse = View<float*>("inverses", numbers * held.n_nodes);
  renew_node_blocks(matrix, held);
  return held;
}

void renew_node_blocks(const TpetraMatrix& matrix, const NodeBlocks& blocks)
{
  const auto local = matrix.getLocalMatrixDevice();
  if (blocks.block_size == 2)
    for_each_in_groups("copy blocks", blocks.n_nodes, 0, CopyBlocks<2>{local, blocks});
  else
    for_each_in_groups("copy blocks", blocks.n_nodes, 0, CopyBlocks<3>{local, blocks});
}
} // namespace kedge
