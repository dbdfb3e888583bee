// The graph of a matrix that consists of square blocks.
#pragma once

#include <kedge/base/tpetra.h>

namespace kedge
{
/// Row v of blocks, of n_rows, has the columns column[row_begin[v] .. row_begin[v + 1]), n_blocks in all, ascending.
/// Each block stands for size x size entries of the graph on the maps. Written on the device. Collective.
template <typename Begin, typename Column>
Teuchos::RCP<TpetraGraph> make_block_graph(const int size, const int n_rows, const std::size_t n_blocks,
                                           const Begin& row_begin, const Column& column,
                                           const Teuchos::RCP<const TpetraMap>& row_map,
                                           const Teuchos::RCP<const TpetraMap>& column_map)
{
  using LocalGraph = TpetraGraph::local_graph_device_type;
  const typename LocalGraph::row_map_type::non_const_type begin("row begin", std::size_t(size) * n_rows + 1);
  const typename LocalGraph::entries_type::non_const_type entries(
      Kokkos::view_alloc("columns", Kokkos::WithoutInitializing), size * size * n_blocks);
  Kokkos::parallel_for(
      "rows of matrix", Kokkos::RangePolicy<ExecutionSpace>(0, n_rows), KOKKOS_LAMBDA(const int v) {
        const std::size_t first = row_begin(v), length = row_begin(v + 1) - first;
        for (int i = 0; i < size; ++i)
        {
          const std::size_t row = size * (size * first + i * length);
          begin(size * v + i + 1) = row + size * length;
          for (std::size_t k = 0; k < length; ++k)
            for (int j = 0; j < size; ++j)
              entries(row + size * k + j) = static_cast<LocalOrdinal>(size * column(first + k) + j);
        }
      });
  const auto graph = Teuchos::rcp(new TpetraGraph(row_map, column_map, begin, entries));
  graph->expertStaticFillComplete(row_map, row_map);
  return graph;
}
} // namespace kedge
