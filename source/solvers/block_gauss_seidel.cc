#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <kedge/solvers/block_gauss_seidel.h>

namespace kedge
{
namespace
{
using Lanes = Eigen::Array<double, 4, 1>;
using StoredLanes = Eigen::Map<const Eigen::Array<float, 4, 1>>;

/// sum -= block x
template <int size> [[gnu::always_inline]] inline void subtract_product(const float* block, const double* x, Lanes& sum)
{
  for (int k = 0; k < size; ++k)
    sum -= x[k] * StoredLanes(block + 4 * k).cast<double>();
}

/// A determinant of less than this share of the product of the diagonal entries counts as zero: then only these are
/// inverted.
constexpr double least_determinant = 1e-3;

template <int size> void write_inverse(const Eigen::Matrix<double, size, size>& block, float* to)
{
  Eigen::Matrix<double, size, size> inverse = block.diagonal().cwiseInverse().asDiagonal();
  if (std::fabs(block.determinant()) > least_determinant * std::fabs(block.diagonal().prod()))
    inverse = block.inverse();
  for (int k = 0; k < size; ++k)
    for (int i = 0; i < size; ++i)
      to[4 * k + i] = static_cast<float>(inverse(i, k));
}
} // namespace

BlockGaussSeidel::BlockGaussSeidel(const TpetraMatrix& matrix, const unsigned int block_size_)
    : block_size(block_size_), column_map(matrix.getColMap()), importer(matrix.getGraph()->getImporter())
{
  if (block_size == 2)
    copy<2>(matrix);
  else
    copy<3>(matrix);
}

template <int size> void BlockGaussSeidel::copy(const TpetraMatrix& matrix)
{
  const auto local = matrix.getLocalMatrixHost();
  const std::size_t n = local.numRows() / size, n_blocks = local.graph.entries.extent(0) / (size * size);
  row_begin.assign(1, 0);
  column.reserve(n_blocks);
  blocks.reserve(std::size_t(lanes) * size * n_blocks);
  inverse.assign(std::size_t(lanes) * size * n, 0.f);
  constexpr unsigned int none = ~0u;
  n_columns = local.numCols() / size;
  std::vector<unsigned int> position(n_columns, none); // of a column's block in the row
  for (std::size_t v = 0; v < n; ++v)
  {
    Eigen::Matrix<double, size, size> diagonal = Eigen::Matrix<double, size, size>::Zero();
    for (int i = 0; i < size; ++i)
      for (std::size_t k = local.graph.row_map(size * v + i); k < local.graph.row_map(size * v + i + 1); ++k)
      {
        const unsigned int node = local.graph.entries(k) / size, j = local.graph.entries(k) % size;
        if (node == v)
        {
          diagonal(i, j) += local.values(k);
          continue;
        }
        if (position[node] == none)
        {
          position[node] = column.size();
          column.push_back(node);
          blocks.resize(blocks.size() + lanes * size, 0.f);
        }
        blocks[lanes * (size * std::size_t(position[node]) + j) + i] += static_cast<float>(local.values(k));
      }
    write_inverse<size>(diagonal, &inverse[std::size_t(lanes) * size * v]);
    for (unsigned int k = row_begin.back(); k < column.size(); ++k)
      position[column[k]] = none;
    row_begin.push_back(column.size());
  }
}

void BlockGaussSeidel::sweep(const TpetraVector& b, TpetraVector& x) const
{
  if (block_size == 2)
    sweep_blocks<2>(b, x);
  else
    sweep_blocks<3>(b, x);
}

template <int size> void BlockGaussSeidel::sweep_blocks(const TpetraVector& b, TpetraVector& x) const
{
  const std::size_t n = row_begin.size() - 1;
  std::vector<double> values(lanes * n_columns); // of owned nodes, then ghosts
  const auto read = [&](const TpetraVector& from)
  {
    const auto view = from.getLocalViewHost(Tpetra::Access::ReadOnly);
    for (std::size_t dof = 0; dof < view.extent(0); ++dof)
      values[lanes * (dof / size) + dof % size] = view(dof, 0);
  };
  if (importer.is_null())
    read(x);
  else
  {
    TpetraVector all(column_map);
    all.doImport(x, *importer, Tpetra::INSERT);
    read(all);
  }

  const auto side = b.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto solve_node = [&](const std::size_t v)
  {
    Lanes rest = Lanes::Zero();
    for (int i = 0; i < size; ++i)
      rest[i] = side(size * v + i, 0);
    for (unsigned int k = row_begin[v]; k < row_begin[v + 1]; ++k)
      subtract_product<size>(&blocks[std::size_t(lanes) * size * k], &values[std::size_t(lanes) * column[k]], rest);
    Lanes solution = Lanes::Zero();
    rest = -rest;
    subtract_product<size>(&inverse[std::size_t(lanes) * size * v], rest.data(), solution);
    Eigen::Map<Lanes> into(&values[lanes * v]);
    into = solution;
  };
  for (std::size_t v = 0; v < n; ++v)
    solve_node(v);
  for (std::size_t v = n; v-- > 0;)
    solve_node(v);

  const auto result = x.getLocalViewHost(Tpetra::Access::OverwriteAll);
  for (std::size_t dof = 0; dof < result.extent(0); ++dof)
    result(dof, 0) = values[lanes * (dof / size) + dof % size];
}
} // namespace kedge
