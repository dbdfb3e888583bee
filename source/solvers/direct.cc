#include <Eigen/UmfPackSupport>
#include <Teuchos_CommHelpers.hpp>
#include <kedge/solvers/direct.h>

namespace kedge
{
namespace
{
using Factors = Eigen::UmfPackLU<Eigen::SparseMatrix<double>>;

/// Over all ranks.
std::size_t find_longest_row(const TpetraMatrix& matrix)
{
  const auto graph = matrix.getLocalMatrixHost().graph;
  unsigned long long here = 0, longest = 0;
  for (LocalOrdinal row = 0; row < static_cast<LocalOrdinal>(graph.numRows()); ++row)
    here = std::max<unsigned long long>(here, graph.row_map(row + 1) - graph.row_map(row));
  Teuchos::reduceAll(*matrix.getComm(), Teuchos::REDUCE_MAX, here, Teuchos::outArg(longest));
  return longest;
}

/// A matrix whose rows all lie on this rank. Its transpose is what its rows look like to a solver that takes columns.
Eigen::SparseMatrix<double> copy_transposed(const TpetraMatrix& matrix)
{
  const auto n = static_cast<Eigen::Index>(matrix.getGlobalNumRows());
  const std::size_t longest = matrix.getGlobalMaxNumRowEntries();
  TpetraMatrix::nonconst_global_inds_host_view_type columns("columns", longest);
  TpetraMatrix::nonconst_values_host_view_type values("values", longest);
  std::vector<std::pair<GlobalOrdinal, double>> row;
  Eigen::SparseMatrix<double> transposed(n, n);
  transposed.reserve(matrix.getGlobalNumEntries());
  for (Eigen::Index i = 0; i < n; ++i)
  {
    std::size_t length = 0;
    matrix.getGlobalRowCopy(i, columns, values, length);
    row.clear();
    for (std::size_t k = 0; k < length; ++k)
      row.emplace_back(columns(k), values(k));
    std::sort(row.begin(), row.end());
    transposed.startVec(i);
    for (const auto& [column, value] : row)
      transposed.insertBack(column, i) = value;
  }
  transposed.finalize();
  return transposed;
}

/// False where the matrix is singular. All rows and entries lie on this rank.
bool factorise_and_solve(const TpetraMatrix& matrix, const TpetraMultiVector& b, TpetraMultiVector& x)
{
  const Eigen::SparseMatrix<double> columns = copy_transposed(matrix).transpose();
  Factors factors;
  factors.umfpackControl()(UMFPACK_IRSTEP) = 0; // steps of refinement cost more than the solution itself
  factors.compute(columns);
  if (factors.info() != Eigen::Success)
    return false;
  const auto from = b.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto to = x.getLocalViewHost(Tpetra::Access::OverwriteAll);
  Eigen::VectorXd side(columns.rows()), solution;
  for (std::size_t j = 0; j < b.getNumVectors(); ++j)
  {
    for (Eigen::Index i = 0; i < side.size(); ++i)
      side[i] = from(i, j);
    solution = factors.solve(side);
    for (Eigen::Index i = 0; i < side.size(); ++i)
      to(i, j) = solution[i];
    if (!solution.allFinite())
      return false;
  }
  return true;
}
} // namespace

bool solve_directly(const TpetraMatrix& matrix, const TpetraMultiVector& b, TpetraMultiVector& x)
{
  const auto communicator = matrix.getComm();
  if (communicator->getSize() == 1)
    return factorise_and_solve(matrix, b, x);

  const std::size_t n = matrix.getGlobalNumRows(), n_sides = b.getNumVectors();
  const bool first = communicator->getRank() == 0;
  const auto map = Teuchos::rcp(new TpetraMap(n, first ? n : 0, 0, communicator));
  const TpetraImport to_first(matrix.getRowMap(), map);
  TpetraMatrix gathered(map, map, find_longest_row(matrix));
  gathered.doImport(matrix, to_first, Tpetra::INSERT);
  gathered.fillComplete();
  TpetraMultiVector gathered_b(map, n_sides), gathered_x(map, n_sides);
  gathered_b.doImport(b, to_first, Tpetra::INSERT);
  int solved = 1;
  if (first)
    solved = factorise_and_solve(gathered, gathered_b, gathered_x);
  Teuchos::broadcast(*communicator, 0, &solved);
  x.doExport(gathered_x, to_first, Tpetra::INSERT);
  return solved != 0;
}
} // namespace kedge
