#include <Teuchos_CommHelpers.hpp>
#include <kedge/solvers/border.h>
#include <vector>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;

/// This rank's part of B^T x, entry by entry: a product of tall matrices would take a hundred times as long on a GPU.
std::vector<double> multiply_local_rows(const TpetraMultiVector& rows, const TpetraMultiVector& x)
{
  const auto of_rows = rows.getLocalViewDevice(Tpetra::Access::ReadOnly),
             of_x = x.getLocalViewDevice(Tpetra::Access::ReadOnly);
  std::vector<double> result(of_rows.extent(1));
  for (std::size_t i = 0; i < result.size(); ++i)
    Kokkos::parallel_reduce(
        "border row", Policy(0, of_rows.extent(0)),
        KOKKOS_LAMBDA(const std::size_t k, double& sum) { sum += of_rows(k, i) * of_x(k, 0); }, result[i]);
  return result;
}
} // namespace

Eigen::VectorXd multiply_rows(const Border& border, const TpetraMultiVector& x)
{
  Eigen::VectorXd result(border.corner.rows());
  if (result.size() == 0)
    return result;
  const std::vector<double> mine = multiply_local_rows(*border.rows, x);
  Teuchos::reduceAll(*border.rows->getMap()->getComm(), Teuchos::REDUCE_SUM, static_cast<int>(mine.size()), mine.data(),
                     result.data()); // one reduction for all
  return result;
}

void add_columns(const Border& border, const double factor, const Eigen::VectorXd& y, TpetraMultiVector& x)
{
  for (Eigen::Index i = 0; i < y.size(); ++i)
    x.update(factor * y[i], *border.columns->getVector(i), 1.);
}
} // namespace kedge
