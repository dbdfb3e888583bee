#include <algorithm>
#include <kedge/assembly/node_graph.h>
#include <kedge/base/block_graph.h>
#include <kedge/base/communication.h>
#include <type_traits>
#include <unordered_map>

namespace kedge
{
namespace
{
using Rows = std::vector<std::vector<unsigned int>>;

/// Columns of every local row that follow from the lists of this rank, ascending.
Rows couple_local_nodes(const unsigned int n_nodes, const std::vector<NodeLists>& couplings)
{
  // Invert the lists first, to know the lists of each node.
  struct HostLists
  {
    HostView<unsigned int*> begin, nodes;
    std::vector<unsigned int> node_begin, lists_of_node;
  };
  std::vector<HostLists> groups;
  for (const NodeLists& coupling : couplings)
  {
    HostLists group;
    group.begin = copy_to_host(coupling.begin);
    group.nodes = copy_to_host(coupling.nodes);
    group.node_begin.assign(n_nodes + 1, 0);
    for (std::size_t i = 0; i < group.nodes.extent(0); ++i)
      ++group.node_begin[group.nodes(i) + 1];
    for (unsigned int v = 0; v < n_nodes; ++v)
      group.node_begin[v + 1] += group.node_begin[v];
    group.lists_of_node.resize(group.nodes.extent(0));
    std::vector<unsigned int> next(group.node_begin.begin(), group.node_begin.end() - 1);
    for (std::size_t k = 0; k + 1 < group.begin.extent(0); ++k)
      for (unsigned int i = group.begin(k); i < group.begin(k + 1); ++i)
        group.lists_of_node[next[group.nodes(i)]++] = k;
    groups.push_back(std::move(group));
  }

  // A row is the union of its node's lists; last_seen marks the columns that it holds already.
  Rows rows(n_nodes);
  std::vector<unsigned int> last_seen(n_nodes, ~0u), row;
  for (unsigned int v = 0; v < n_nodes; ++v)
  {
    row.assign(1, v); // the diagonal is always there
    last_seen[v] = v;
    for (const HostLists& group : groups)
      for (unsigned int l = group.node_begin[v]; l < group.node_begin[v + 1]; ++l)
      {
        const unsigned int k = group.lists_of_node[l];
        for (unsigned int i = group.begin(k); i < group.begin(k + 1); ++i)
          if (const unsigned int w = group.nodes(i); last_seen[w] != v)
          {
            last_seen[w] = v;
            row.push_back(w);
          }
      }
    std::sort(row.begin(), row.end());
    rows[v] = row;
  }
  return rows;
}

NodeGraph start_graph(const unsigned int dim, const NodeNumbering& numbering)
{
  NodeGraph graph;
  graph.dim = dim;
  graph.communicator = numbering.communicator;
  graph.n_owned = numbering.n_owned;
  graph.n_rows = numbering.global.size();
  return graph;
}

/// Returns the begin of each row.
std::vector<std::size_t> upload_rows(const Rows& rows, NodeGraph& graph)
{
  std::vector<std::size_t> begin(graph.n_rows + 1, 0);
  for (unsigned int v = 0; v < graph.n_rows; ++v)
    begin[v + 1] = begin[v] + rows[v].size();
  graph.row_begin = upload(begin, "row begin");
  graph.column = View<unsigned int*>(Kokkos::view_alloc("columns", Kokkos::WithoutInitializing), begin.back());
  const auto host_column = make_mirror(graph.column);
  for (unsigned int v = 0; v < graph.n_rows; ++v)
    std::copy(rows[v].begin(), rows[v].end(), host_column.data() + begin[v]);
  Kokkos::deep_copy(graph.column, host_column);
  return begin;
}

/// A ghost row, after its owner has received it.
struct ReceivedRow
{
  unsigned int row;                  ///< owned node
  std::size_t offset;                ///< of its first block in the sender's message
  std::vector<unsigned int> columns; ///< local numbers here
};

/// Sends the columns of ghost rows to their owners. These add them to their own rows and number the new columns.
std::vector<std::vector<ReceivedRow>> exchange_ghost_rows(const NodeNumbering& numbering, Rows& rows,
                                                          std::vector<long long>& column_global)
{
  // A message holds, for each row, its global number, its length and its columns.
  const int n_ranks = size_of(numbering.communicator);
  std::vector<std::vector<long long>> message(n_ranks);
  for (int r = 0; r < n_ranks; ++r)
    for (unsigned int v = numbering.ghost_begin[r]; v < numbering.ghost_begin[r + 1]; ++v)
    {
      message[r].push_back(numbering.global[v]);
      message[r].push_back(rows[v].size());
      for (const unsigned int w : rows[v])
        message[r].push_back(numbering.global[w]);
    }
  const auto received = exchange_between_ranks(message, numbering.communicator);

  // Columns that this rank does not know yet get the next local numbers.
  std::unordered_map<long long, unsigned int> local;
  for (unsigned int v = 0; v < column_global.size(); ++v)
    local.emplace(column_global[v], v);
  std::vector<std::vector<ReceivedRow>> result(n_ranks);
  for (int r = 0; r < n_ranks; ++r)
  {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < received[r].size();)
    {
      ReceivedRow row;
      row.row = local.at(received[r][i++]);
      row.offset = offset;
      const long long length = received[r][i++];
      offset += length;
      for (long long k = 0; k < length; ++k, ++i)
      {
        const auto [entry, is_new] = local.emplace(received[r][i], column_global.size());
        if (is_new)
          column_global.push_back(received[r][i]);
        row.columns.push_back(entry->second);
      }
      rows[row.row].insert(rows[row.row].end(), row.columns.begin(), row.columns.end());
      result[r].push_back(std::move(row));
    }
  }
  // A column may have come from several ranks.
  for (unsigned int v = 0; v < numbering.n_owned; ++v)
  {
    std::sort(rows[v].begin(), rows[v].end());
    rows[v].erase(std::unique(rows[v].begin(), rows[v].end()), rows[v].end());
  }
  return result;
}

void fill_targets(NodeGraph& graph, const Rows& rows, const std::vector<std::size_t>& begin,
                  const std::vector<std::vector<ReceivedRow>>& received)
{
  for (const auto& from_rank : received)
  {
    std::size_t count = 0;
    for (const ReceivedRow& row : from_rank)
    {
      const std::vector<unsigned int>& columns = rows[row.row];
      for (unsigned int k = 0; k < row.columns.size(); ++k)
      {
        const unsigned int position =
            std::lower_bound(columns.begin(), columns.end(), row.columns[k]) - columns.begin();
        graph.targets.push_back({begin[row.row], row.offset, static_cast<unsigned int>(columns.size()), position,
                                 static_cast<unsigned int>(row.columns.size()), k});
      }
      count += row.columns.size();
    }
    graph.receive_count.push_back(count);
  }
}
} // namespace

Teuchos::RCP<const TpetraMap> make_dof_map(const unsigned int dim, const std::vector<long long>& node,
                                           const std::size_t n)
{
  std::vector<GlobalOrdinal> dofs(dim * n);
  for (std::size_t v = 0; v < n; ++v)
    for (unsigned int d = 0; d < dim; ++d)
      dofs[dim * v + d] = dim * node[v] + d;
  return Teuchos::rcp(new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(),
                                    Teuchos::ArrayView<const GlobalOrdinal>(dofs.data(), dofs.size()), 0,
                                    Tpetra::getDefaultComm()));
}

NodeGraph build_local_graph(const unsigned int dim, const NodeNumbering& numbering,
                            const std::vector<NodeLists>& couplings)
{
  NodeGraph graph = start_graph(dim, numbering);
  graph.n_columns = graph.n_rows;
  upload_rows(couple_local_nodes(graph.n_rows, couplings), graph);
  return graph;
}

NodeGraph build_node_graph(const unsigned int dim, const NodeNumbering& numbering,
                           const std::vector<NodeLists>& couplings)
{
  NodeGraph graph = start_graph(dim, numbering);
  Rows rows = couple_local_nodes(graph.n_rows, couplings);
  std::vector<long long> column_global = numbering.global;
  const auto received = exchange_ghost_rows(numbering, rows, column_global);
  graph.n_columns = column_global.size();

  // Rows of ghosts lie behind the owned ones, grouped by owner, so each rank's message is one range.
  const std::vector<std::size_t> begin = upload_rows(rows, graph);
  for (const unsigned int v : numbering.ghost_begin)
    graph.send_begin.push_back(begin[v]);
  fill_targets(graph, rows, begin, received);

  // Numbers that follow each other over the ranks tell everybody whose they are. A map of a list would ask for it in
  // each step, ranks that are no neighbours, too.
  graph.row_map = Teuchos::rcp(new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(),
                                             std::size_t(dim) * graph.n_owned, 0, Tpetra::getDefaultComm()));
  graph.column_map = make_dof_map(dim, column_global, graph.n_columns);
  graph.matrix_graph = make_block_graph(static_cast<int>(dim), static_cast<int>(graph.n_owned), begin[graph.n_owned],
                                        graph.row_begin, graph.column, graph.row_map, graph.column_map);
  return graph;
}

void send_ghost_rows(const NodeGraph& graph, const View<double*>& values)
{
  const int n_ranks = size_of(graph.communicator);
  if (n_ranks == 1)
    return;
  const unsigned int block = graph.dim * graph.dim;
  const auto host = copy_to_host(values);
  std::vector<int> send_count(n_ranks), receive_count(n_ranks);
  for (int r = 0; r < n_ranks; ++r)
  {
    send_count[r] = static_cast<int>(graph.send_begin[r + 1] - graph.send_begin[r]);
    receive_count[r] = static_cast<int>(graph.receive_count[r]);
  }
  const std::vector<int> send_begin = begin_of_parts(send_count), receive_begin = begin_of_parts(receive_count);
  std::vector<double> received(std::size_t(block) * receive_begin[n_ranks]);
  exchange_known_parts(host.data() + block * graph.send_begin[0], send_begin, received.data(), receive_begin, block,
                       graph.communicator);

  // The same block lies elsewhere in the sender's row and in this rank's, which may have more columns.
  std::size_t t = 0;
  for (int r = 0; r < n_ranks; ++r)
    for (std::size_t k = 0; k < graph.receive_count[r]; ++k, ++t)
    {
      const NodeGraph::Target& target = graph.targets[t];
      const double* source = received.data() + block * (receive_begin[r] + target.sender_offset);
      double* row = host.data() + block * target.row_begin;
      for (unsigned int i = 0; i < graph.dim; ++i)
        for (unsigned int j = 0; j < graph.dim; ++j)
          row[graph.dim * (i * target.length + target.position) + j] +=
              source[graph.dim * (i * target.sender_length + target.sender_position) + j];
    }
  Kokkos::deep_copy(values, host);
}
} // namespace kedge
