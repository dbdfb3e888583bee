#include <Eigen/UmfPackSupport>
#include <Teuchos_CommHelpers.hpp>
#include <algorithm>
#include <kedge/base/kokkos.h>
#include <kedge/solvers/direct.h>
#include <new>
#include <vector>

namespace kedge
{
namespace
{
using Factors = Eigen::UmfPackLU<Eigen::SparseMatrix<double>>;

/// Copies a matrix whose rows all lie on this rank.
Eigen::SparseMatrix<double, Eigen::RowMajor> copy_rows(const TpetraMatrix& matrix)
{
  const auto n = static_cast<Eigen::Index>(matrix.getGlobalNumRows());
  const auto local = matrix.getLocalMatrixDevice();
  const auto begin = copy_to_host(local.graph.row_map);
  const auto columns = copy_to_host(local.graph.entries);
  const auto values = copy_to_host(local.values);
  const TpetraMap &row_map = *matrix.getRowMap(), &column_map = *matrix.getColMap();
  std::vector<std::pair<GlobalOrdinal, double>> row;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows(n, n);
  rows.reserve(matrix.getGlobalNumEntries());
  for (Eigen::Index i = 0; i < n; ++i)
  {
    const LocalOrdinal here = row_map.getLocalElement(i);
    row.clear();
    for (std::size_t k = begin(here); k < begin(here + 1); ++k)
      row.emplace_back(column_map.getGlobalElement(columns(k)), values(k));
    std::sort(row.begin(), row.end());
    rows.startVec(i);
    for (const auto& [column, value] : row)
      rows.insertBack(i, column) = value;
  }
  rows.finalize();
  return rows;
}

enum class Outcome : int
{
  singular,
  solved,
  out_of_memory
};

/// All rows and entries lie on this rank.
Outcome factorise_and_solve(const TpetraMatrix& matrix, const TpetraMultiVector& b, TpetraMultiVector& x)
{
  const Eigen::SparseMatrix<double> columns = copy_rows(matrix);
  Factors factors;
  factors.umfpackControl()(UMFPACK_IRSTEP) = 0; // a step of refinement costs more than the solution itself
  factors.compute(columns);
  if (factors.info() != Eigen::Success) // of its errors, memory is the only one that a sound matrix can have
    return factors.umfpackFactorizeReturncode() < 0 ? Outcome::out_of_memory : Outcome::singular;
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
      return Outcome::singular;
  }
  return Outcome::solved;
}

/// Throws where memory was short.
bool is_solved(const Outcome outcome)
{
  if (outcome == Outcome::out_of_memory)
    throw std::bad_alloc();
  return outcome == Outcome::solved;
}
} // namespace

bool solve_directly(const TpetraMatrix& matrix, const TpetraMultiVector& b, TpetraMultiVector& x)
{
  if (matrix.getGlobalNumRows() == 0)
    return true;
  const auto communicator = matrix.getComm();
  if (communicator->getSize() == 1)
    return is_solved(factorise_and_solve(matrix, b, x));

  // Rows are packed on the host, which Tpetra refuses while somebody else, as System, holds their values on the device.
  const TpetraMatrix own(matrix, Teuchos::Copy);
  const std::size_t n = matrix.getGlobalNumRows(), n_sides = b.getNumVectors();
  const bool first = communicator->getRank() == 0;
  const auto map = Teuchos::rcp(new TpetraMap(n, first ? n : 0, 0, communicator));
  const TpetraImport to_first(matrix.getRowMap(), map);
  TpetraMatrix gathered(map, map, matrix.getGlobalMaxNumRowEntries());
  gathered.doImport(own, to_first, Tpetra::INSERT);
  gathered.fillComplete();
  TpetraMultiVector gathered_b(map, n_sides), gathered_x(map, n_sides);
  gathered_b.doImport(b, to_first, Tpetra::INSERT);
  int outcome = 0;
  if (first)
    outcome = static_cast<int>(factorise_and_solve(gathered, gathered_b, gathered_x));
  Teuchos::broadcast(*communicator, 0, &outcome);
  x.doExport(gathered_x, to_first, Tpetra::INSERT);
  return is_solved(static_cast<Outcome>(outcome));
}
} // namespace kedge
