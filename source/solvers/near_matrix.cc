#include <algorithm>
#include <cmath>
#include <kedge/solvers/near_matrix.h>

namespace kedge
{
namespace
{
using LocalMatrix = TpetraMatrix::local_matrix_device_type;

/// Both were found by trial on a plate pulled through cohesionless sand. With them GMRES needs a third of the
/// iterations that it needs with 0.5 and 0, and no more than with the full matrix.
constexpr double tolerated_loss = 0.05, reinforcement = 0.3;

/// Least diagonal, as a share of the other entries of the row. Soil with a non-associated flow rule has rows with
/// smaller and even negative diagonals, and Gauss-Seidel diverges on them. The bound does no harm: the exact inverse of
/// the near matrix is an equally good preconditioner with and without it.
constexpr double least_diagonal = 0.1;

/// Position and spacing of the nodes of all columns, block_size + 1 numbers per node.
std::vector<double> spread_places(const TpetraMatrix& matrix, const unsigned int block_size, const NodePlaces& places)
{
  const unsigned int width = block_size + 1;
  TpetraMultiVector owned(matrix.getRowMap(), width), all(matrix.getColMap(), width);
  {
    auto view = owned.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (std::size_t dof = 0; dof < view.extent(0); ++dof)
    {
      for (unsigned int d = 0; d < block_size; ++d)
        view(dof, d) = places.position[dof / block_size * block_size + d];
      view(dof, block_size) = places.spacing[dof / block_size];
    }
  }
  if (const auto importer = matrix.getGraph()->getImporter(); importer.is_null())
    Tpetra::deep_copy(all, owned);
  else
    all.doImport(owned, *importer, Tpetra::INSERT);

  const auto view = all.getLocalViewHost(Tpetra::Access::ReadOnly);
  std::vector<double> result;
  for (std::size_t dof = 0; dof < view.extent(0); dof += block_size)
    for (unsigned int i = 0; i < width; ++i)
      result.push_back(view(dof, i));
  return result;
}

/// Whether two nodes are at most one cell apart along every axis. The larger of the cells at both nodes counts.
bool are_near(const double* a, const double* b, const unsigned int dim)
{
  const double reach = 1.001 * std::max(a[dim], b[dim]);
  for (unsigned int d = 0; d < dim; ++d)
    if (std::fabs(a[d] - b[d]) > reach)
      return false;
  return true;
}
} // namespace

NearMatrix::NearMatrix(const Teuchos::RCP<const TpetraMatrix>& matrix, const unsigned int block_size,
                       const NodePlaces& places)
    : full(matrix)
{
  const std::vector<double> place = spread_places(*full, block_size, places);
  const auto graph = full->getLocalMatrixHost().graph;
  const std::size_t n_rows = graph.numRows(), width = block_size + 1;

  // Near entries keep their column. Far ones are marked first, because the diagonal of their row may come later.
  LocalMatrix::row_map_type::non_const_type begin("near rows", n_rows + 1);
  LocalMatrix::index_type::non_const_type column("near columns", graph.entries.extent(0));
  target = View<unsigned int*>("targets", graph.entries.extent(0));
  const auto host_begin = Kokkos::create_mirror_view(begin);
  const auto host_column = Kokkos::create_mirror_view(column);
  const auto host_target = Kokkos::create_mirror_view(target);
  unsigned int count = 0;
  std::vector<unsigned int> diagonal(block_size);
  for (std::size_t row = 0; row < n_rows; ++row)
  {
    const std::size_t node = row / block_size;
    constexpr unsigned int far = ~0u;
    for (std::size_t k = graph.row_map(row); k < graph.row_map(row + 1); ++k)
    {
      const std::size_t other = graph.entries(k) / block_size;
      if (!are_near(&place[width * node], &place[width * other], block_size))
      {
        host_target(k) = far;
        continue;
      }
      if (other == node)
        diagonal[graph.entries(k) % block_size] = count;
      host_column(count) = graph.entries(k);
      host_target(k) = count++;
    }
    for (std::size_t k = graph.row_map(row); k < graph.row_map(row + 1); ++k)
      if (host_target(k) == far)
        host_target(k) = diagonal[graph.entries(k) % block_size];
    host_begin(row + 1) = count;
  }
  Kokkos::deep_copy(begin, host_begin);
  Kokkos::deep_copy(column, host_column);
  Kokkos::deep_copy(target, host_target);
  Kokkos::resize(column, count);
  near = Teuchos::rcp(new TpetraMatrix(full->getRowMap(), full->getColMap(), begin, column,
                                       LocalMatrix::values_type("near values", count)));
  near->expertStaticFillComplete(full->getDomainMap(), full->getRangeMap(), full->getGraph()->getImporter());
  update();
}

void NearMatrix::update()
{
  const auto from = full->getLocalMatrixDevice();
  const auto to = near->getLocalMatrixDevice();
  const auto where = target;
  Kokkos::parallel_for(
      "near matrix", Kokkos::RangePolicy<ExecutionSpace>(0, from.numRows()), KOKKOS_LAMBDA(const std::size_t row) {
        for (std::size_t k = to.graph.row_map(row); k < to.graph.row_map(row + 1); ++k)
          to.values(k) = 0.;
        // Would the far entries weaken the diagonal entry too much?
        double diagonal = 0., far = 0.;
        const auto is_far = [&](const std::size_t k) { return from.graph.entries(k) != to.graph.entries(where(k)); };
        const auto goes_to_diagonal = [&](const std::size_t k)
        { return static_cast<std::size_t>(to.graph.entries(where(k))) == row; };
        for (std::size_t k = from.graph.row_map(row); k < from.graph.row_map(row + 1); ++k)
          if (goes_to_diagonal(k))
            (is_far(k) ? far : diagonal) += from.values(k);
        // Then a share of their magnitude goes to the diagonal entry, and the others are dropped.
        const bool weakens = far < -tolerated_loss * diagonal;
        for (std::size_t k = from.graph.row_map(row); k < from.graph.row_map(row + 1); ++k)
          if (!is_far(k) || !weakens)
            to.values(where(k)) += from.values(k);
          else if (goes_to_diagonal(k))
            to.values(where(k)) += reinforcement * Kokkos::Experimental::fabs(from.values(k));

        // Bound the diagonal entry from below.
        std::size_t at_diagonal = to.graph.row_map(row);
        double others = 0.;
        for (std::size_t k = to.graph.row_map(row); k < to.graph.row_map(row + 1); ++k)
          if (static_cast<std::size_t>(to.graph.entries(k)) == row)
            at_diagonal = k;
          else
            others += Kokkos::Experimental::fabs(to.values(k));
        if (to.values(at_diagonal) < least_diagonal * others)
          to.values(at_diagonal) = least_diagonal * others;
      });
}
} // namespace kedge
