#include <algorithm>
#include <kedge/base/communication.h>
#include <kedge/basis/active_nodes.h>

namespace kedge
{
namespace
{
/// deal.II hands out node numbers in contiguous ranges, rank by rank.
std::vector<long long> find_owned_ranges(const long long n_owned, const MPI_Comm communicator)
{
  std::vector<long long> begin(1, 0);
  for (const long long n : gather_everywhere(std::vector<long long>{n_owned}, communicator))
    begin.push_back(begin.back() + n);
  return begin;
}
} // namespace

template <int dim>
ActiveNodes number_active_nodes(const LeafTable<dim>& table, const std::vector<unsigned char>& used,
                                const MPI_Comm communicator)
{
  // Global numbers tell the owner of a node, because each rank owns a contiguous range of them.
  const unsigned int n_nodes = table.node_ids.size();
  const int n_ranks = size_of(communicator);
  const long long n_owned_nodes = table.n_owned_nodes;
  const std::vector<long long> range = find_owned_ranges(n_owned_nodes, communicator);
  const long long first_owned = range[rank_of(communicator)];

  // Tell the owners which of their nodes are used here.
  std::vector<std::vector<long long>> wanted(n_ranks);
  std::vector<std::vector<unsigned int>> wanted_nodes(n_ranks);
  std::vector<unsigned int> owned_node(n_owned_nodes, ActiveNodes::inactive);
  std::vector<unsigned char> active(n_owned_nodes, 0);
  for (unsigned int i = 0; i < n_nodes; ++i)
    if (table.node_owner_is_me[i])
    {
      owned_node[table.node_ids[i] - first_owned] = i;
      active[table.node_ids[i] - first_owned] = used[i];
    }
    else if (used[i])
    {
      const int owner = std::upper_bound(range.begin(), range.end(), table.node_ids[i]) - range.begin() - 1;
      wanted[owner].push_back(table.node_ids[i]);
      wanted_nodes[owner].push_back(i);
    }
  std::vector<std::vector<long long>> asked = exchange_between_ranks(wanted, communicator);
  for (const auto& ids : asked)
    for (const long long id : ids)
      active[id - first_owned] = 1;

  // Number the owned nodes that some rank uses.
  ActiveNodes nodes;
  nodes.communicator = communicator;
  nodes.number.assign(n_nodes, ActiveNodes::inactive);
  for (long long i = 0; i < n_owned_nodes; ++i)
    if (active[i])
    {
      nodes.number[owned_node[i]] = nodes.mesh_node.size();
      nodes.mesh_node.push_back(owned_node[i]);
    }
  nodes.n_owned = nodes.mesh_node.size();
  const long long first = sum_over_lower_ranks(nodes.n_owned, communicator);
  nodes.n_global = sum_over_ranks(static_cast<long long>(nodes.n_owned), communicator);
  for (unsigned int i = 0; i < nodes.n_owned; ++i)
    nodes.global.push_back(first + i);

  // Answer with the new numbers.
  for (auto& ids : asked)
    for (long long& id : ids)
      id = first + nodes.number[owned_node[id - first_owned]];
  const std::vector<std::vector<long long>> answer = exchange_between_ranks(asked, communicator);
  // Ghosts follow behind the owned nodes, grouped by owner.
  for (int r = 0; r < n_ranks; ++r)
  {
    nodes.ghost_begin.push_back(nodes.mesh_node.size());
    for (std::size_t i = 0; i < answer[r].size(); ++i)
    {
      nodes.number[wanted_nodes[r][i]] = nodes.mesh_node.size();
      nodes.mesh_node.push_back(wanted_nodes[r][i]);
      nodes.global.push_back(answer[r][i]);
    }
  }
  nodes.ghost_begin.push_back(nodes.mesh_node.size());
  return nodes;
}

template ActiveNodes number_active_nodes<2>(const LeafTable<2>&, const std::vector<unsigned char>&, MPI_Comm);
template ActiveNodes number_active_nodes<3>(const LeafTable<3>&, const std::vector<unsigned char>&, MPI_Comm);
} // namespace kedge
