#include <Eigen/Core>
#include <kedge/base/block_graph.h>
#include <kedge/solvers/coarse_nodes.h>
#include <kedge/solvers/coarsening.h>

namespace kedge
{
namespace
{
Teuchos::RCP<TpetraMatrix> make_matrix(const CoarseNodes& at, const ProductPlan& plan)
{
  const int n = at.aggregates.n, m = static_cast<int>(at.modes);
  std::vector<GlobalOrdinal> column_dofs;
  const auto add_column = [&](const GlobalOrdinal aggregate)
  {
    for (int a = 0; a < m; ++a)
      column_dofs.push_back(m * aggregate + a);
  };
  for (int aggregate = 0; aggregate < n; ++aggregate)
    add_column(at.first() + aggregate);
  for (const GlobalOrdinal aggregate : at.ghosts)
    add_column(aggregate);
  const auto column_map = Teuchos::rcp(new TpetraMap(
      Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(),
      Teuchos::ArrayView<const GlobalOrdinal>(column_dofs.data(), column_dofs.size()), 0, at.map->getComm()));
  const auto graph = make_block_graph(m, n, plan.row.extent(0), plan.row_begin, plan.column, at.map, column_map);
  const auto matrix = Teuchos::rcp(new TpetraMatrix(graph));
  matrix->fillComplete(at.map, at.map);
  return matrix;
}

View<float*> rows_in_lanes(const TpetraMultiVector& prolongator)
{
  const auto from = prolongator.getLocalViewHost(Tpetra::Access::ReadOnly);
  const std::size_t lanes = mode_lanes(static_cast<unsigned int>(from.extent(1)));
  std::vector<float> rows(lanes * from.extent(0), 0.F);
  for (std::size_t a = 0; a < from.extent(1); ++a)
    for (std::size_t dof = 0; dof < from.extent(0); ++dof)
      rows[lanes * dof + a] = static_cast<float>(from(dof, a));
  return upload(rows, "prolongator");
}

template <int size, int modes> struct GalerkinKernel
{
  NodeBlocks fine;
  Prolongator prolongator;
  ProductPlan plan;
  TpetraMatrix::local_matrix_device_type::values_type values;

  static constexpr int lanes = mode_lanes(modes);
  using Row = Eigen::Array<float, lanes, 1>;

  KEDGE_FUNCTION const float* row_of(const int v, const int i) const
  {
    return &prolongator.rows(std::size_t(lanes) * (size * v + i));
  }

  KEDGE_FUNCTION void operator()(const int c) const
  {
    Row sum[modes];
    for (int a = 0; a < modes; ++a)
      sum[a].setZero();
    for (int s = plan.part_begin(c); s < plan.part_begin(c + 1); ++s)
    {
      const int v = plan.node(s);
      Row product[size]; // A P
      for (int i = 0; i < size; ++i)
        product[i].setZero();
      for (int e = plan.block_begin(s); e < plan.block_begin(s + 1); ++e)
      {
        const int k = plan.block(e), w = k < 0 ? v : fine.column(k);
        const float* block = k < 0 ? fine.diagonal_of(v) : fine.block(k);
        for (int j = 0; j < size; ++j)
        {
          const Row of_w = Eigen::Map<const Row>(row_of(w, j));
          for (int i = 0; i < size; ++i)
            product[i] += block[block_lanes * j + i] * of_w;
        }
      }
      for (int i = 0; i < size; ++i)
        for (int a = 0; a < modes; ++a)
          sum[a] += row_of(v, i)[a] * product[i];
    }
    const int row = plan.row(c), begin = plan.row_begin(row), length = plan.row_begin(row + 1) - begin;
    for (int a = 0; a < modes; ++a)
    {
      if (plan.column(c) == row && sum[a][a] == 0.F) // the aggregate does not have this mode
        sum[a][a] = 1.F;
      double* const to = &values(std::size_t(modes) * (std::size_t(modes) * begin + a * length + c - begin));
      for (int b = 0; b < modes; ++b)
        to[b] = sum[a][b];
    }
  }
};

using Policy = Kokkos::RangePolicy<ExecutionSpace>;

/// Calls work with the block size and the number of modes as constants.
template <typename Work> void with_sizes(const unsigned int size, const Work& work)
{
  if (size == 2)
    work(std::integral_constant<int, 2>(), std::integral_constant<int, 3>());
  else
    work(std::integral_constant<int, 3>(), std::integral_constant<int, 6>());
}

template <int size, int modes>
void multiply(const NodeBlocks& fine, const Prolongator& prolongator, const ProductPlan& plan, TpetraMatrix& coarse)
{
  Kokkos::parallel_for("coarse matrix", Policy(0, plan.row.extent(0)),
                       GalerkinKernel<size, modes>{fine, prolongator, plan, coarse.getLocalMatrixDevice().values});
}
} // namespace

Coarsening::Coarsening(const TpetraMatrix& matrix, const NodeBlocks& blocks_, const TpetraMultiVector& modes)
    : blocks(blocks_)
{
  const CoarseNodes at = make_coarse_nodes(matrix, blocks, modes);
  const auto owned_rows = Teuchos::rcp(new TpetraMultiVector(matrix.getRowMap(), at.modes));
  coarse_modes = Teuchos::rcp(new TpetraMultiVector(at.map, at.modes));
  make_prolongator(at, modes, *owned_rows, *coarse_modes);
  prolongator = {at.modes,
                 at.aggregates.n,
                 upload(at.aggregate_of_column, "aggregates"),
                 rows_in_lanes(*with_ghosts(matrix, owned_rows)),
                 upload(at.node_begin, "node begin"),
                 upload(at.nodes, "nodes of aggregates")};

  const ProductLists lists = list_products(at);
  plan = {upload(lists.row_begin, "row begin"), upload(lists.row, "row"),
          upload(lists.column, "column"),       upload(lists.part_begin, "part begin"),
          upload(lists.node, "node"),           upload(lists.block_begin, "block begin"),
          upload(lists.block, "block")};
  coarse_matrix = make_matrix(at, plan);
  renew();
}

void Coarsening::renew()
{
  with_sizes(blocks.block_size, [&](const auto size, const auto modes)
             { multiply<decltype(size)::value, decltype(modes)::value>(blocks, prolongator, plan, *coarse_matrix); });
}

void Coarsening::restrict(const TpetraVector& from, TpetraVector& to) const
{
  const auto fine = Kokkos::subview(from.getLocalViewDevice(Tpetra::Access::ReadOnly), Kokkos::ALL(), 0);
  const auto coarse = Kokkos::subview(to.getLocalViewDevice(Tpetra::Access::OverwriteAll), Kokkos::ALL(), 0);
  const Prolongator& by = prolongator;
  const int size = static_cast<int>(blocks.block_size), modes = static_cast<int>(by.n_modes);
  const std::size_t lanes = mode_lanes(by.n_modes);
  Kokkos::parallel_for(
      "restrict", Policy(0, std::size_t(modes) * by.n_aggregates), KOKKOS_LAMBDA(const int dof) {
        const int aggregate = dof / modes, a = dof % modes;
        double sum = 0.;
        for (int k = by.node_begin(aggregate); k < by.node_begin(aggregate + 1); ++k)
          for (int i = 0; i < size; ++i)
          {
            const int row = size * by.nodes(k) + i;
            sum += static_cast<double>(by.rows(lanes * row + a)) * fine(row);
          }
        coarse(dof) = sum;
      });
}

void Coarsening::add_prolonged(const TpetraVector& from, TpetraVector& to) const
{
  const auto coarse = Kokkos::subview(from.getLocalViewDevice(Tpetra::Access::ReadOnly), Kokkos::ALL(), 0);
  const auto fine = Kokkos::subview(to.getLocalViewDevice(Tpetra::Access::ReadWrite), Kokkos::ALL(), 0);
  const Prolongator& by = prolongator;
  const int size = static_cast<int>(blocks.block_size), modes = static_cast<int>(by.n_modes);
  const std::size_t lanes = mode_lanes(by.n_modes);
  Kokkos::parallel_for(
      "prolong", Policy(0, fine.extent(0)), KOKKOS_LAMBDA(const int row) {
        const int aggregate = by.aggregate(row / size);
        if (aggregate < 0)
          return;
        double sum = 0.;
        for (int a = 0; a < modes; ++a)
          sum += static_cast<double>(by.rows(lanes * row + a)) * coarse(modes * aggregate + a);
        fine(row) += sum;
      });
}
} // namespace kedge
