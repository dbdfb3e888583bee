#include <cmath>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/system.h>
#include <kedge/base/communication.h>

namespace kedge
{
namespace
{
/// Whether an entry is 1, not 0.
View<unsigned char*> flags_of(const NodalVector& mark)
{
  const View<unsigned char*> flags("constrained", mark.extent(0));
  Kokkos::parallel_for(
      "mark constrained", Kokkos::RangePolicy<ExecutionSpace>(0, mark.extent(0)),
      KOKKOS_LAMBDA(const std::size_t dof) { flags(dof) = mark(dof) > 0.5; });
  return flags;
}
} // namespace

System::System(const unsigned int dim, const NodeNumbering& numbering, const std::vector<NodeLists>& couplings,
               const std::vector<unsigned char>& constrained)
    : node_graph(build_node_graph(dim, numbering, couplings)),
      exchange(std::size_t(dim) * node_graph.n_columns, node_graph.row_map, node_graph.column_map,
               node_graph.matrix_graph->getImporter()),
      all_values("matrix values", node_graph.n_values())
{
  const std::size_t n_owned_values = node_graph.matrix_graph->getLocalGraphDevice().entries.extent(0);
  using LocalMatrix = TpetraMatrix::local_matrix_device_type;
  const typename LocalMatrix::values_type owned_values =
      Kokkos::subview(all_values, std::make_pair(std::size_t(0), n_owned_values));
  owned_matrix = Teuchos::rcp(new TpetraMatrix(node_graph.matrix_graph, owned_values));
  owned_matrix->fillComplete(node_graph.row_map, node_graph.row_map);

  // Columns may be ghosts that this rank's particles do not see: only their owners know whether they are constrained.
  TpetraVector owned_mark(node_graph.row_map);
  {
    auto view = owned_mark.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (std::size_t dof = 0; dof < view.extent(0); ++dof)
      view(dof, 0) = constrained[dof];
  }
  constrained_column = flags_of(spread(owned_mark));
}

void System::zero_constrained(TpetraVector& owned) const
{
  const auto view = Kokkos::subview(owned.getLocalViewDevice(Tpetra::Access::ReadWrite), Kokkos::ALL(), 0);
  const auto column = constrained_column;
  Kokkos::parallel_for(
      "zero constrained", Kokkos::RangePolicy<ExecutionSpace>(0, view.extent(0)), KOKKOS_LAMBDA(const std::size_t dof) {
        if (column(dof))
          view(dof) = 0.;
      });
}

void System::keep_constrained(const TpetraVector& from, TpetraVector& result) const
{
  const auto kept = Kokkos::subview(from.getLocalViewDevice(Tpetra::Access::ReadOnly), Kokkos::ALL(), 0);
  const auto view = Kokkos::subview(result.getLocalViewDevice(Tpetra::Access::ReadWrite), Kokkos::ALL(), 0);
  const auto column = constrained_column;
  Kokkos::parallel_for(
      "keep constrained", Kokkos::RangePolicy<ExecutionSpace>(0, view.extent(0)), KOKKOS_LAMBDA(const std::size_t dof) {
        if (column(dof))
          view(dof) = kept(dof);
      });
}

void System::clear_matrix() { Kokkos::deep_copy(all_values, 0.); }

void System::finish_matrix()
{
  send_ghost_rows(node_graph, all_values);
  const auto local = owned_matrix->getLocalMatrixDevice();
  const auto column = constrained_column;
  const std::size_t n_rows = local.numRows();

  // The identity rows get the mean diagonal of the free dofs, so that they do not spoil the conditioning.
  double sums[2] = {0., 0.};
  Kokkos::parallel_reduce(
      "diagonal", Kokkos::RangePolicy<ExecutionSpace>(0, n_rows),
      KOKKOS_LAMBDA(const std::size_t row, double& sum, double& count) {
        if (column(row))
          return;
        for (std::size_t k = local.graph.row_map(row); k < local.graph.row_map(row + 1); ++k)
          if (static_cast<std::size_t>(local.graph.entries(k)) == row)
            sum += Kokkos::Experimental::fabs(local.values(k));
        count += 1.;
      },
      sums[0], sums[1]);
  const double total = sum_over_ranks(sums[0], node_graph.communicator);
  const double count = sum_over_ranks(sums[1], node_graph.communicator);
  const double scale = total > 0. ? total / count : 1.;

  Kokkos::parallel_for(
      "constrain matrix", Kokkos::RangePolicy<ExecutionSpace>(0, n_rows), KOKKOS_LAMBDA(const std::size_t row) {
        for (std::size_t k = local.graph.row_map(row); k < local.graph.row_map(row + 1); ++k)
        {
          const std::size_t other = local.graph.entries(k);
          if (column(row) || column(other))
            local.values(k) = row == other ? scale : 0.;
        }
      });
}
} // namespace kedge
