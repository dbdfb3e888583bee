#include <algorithm>
#include <kedge/base/communication.h>
#include <kedge/basis/gimp.h>
#include <kedge/soil/node_questions.h>
#include <kedge/soil/prediction.h>
#include <unordered_map>

namespace kedge
{
namespace
{
template <int dim> using Vector = std::array<double, dim>;

/// Of a leaf at x, m.
template <int dim>
Vector<dim> interpolate(const std::vector<double>& prediction, const LeafTable<dim>& table, const int leaf,
                        const Vector<dim>& x)
{
  std::vector<NodeShare<dim>> shares;
  add_leaf_shape<dim>(table, leaf, x, 1., shares);
  Vector<dim> increment{};
  for (const NodeShare<dim>& share : shares)
    for (unsigned int d = 0; d < dim; ++d)
      increment[d] += share.value * prediction[dim * share.node + d];
  return increment;
}

/// Gives nodes of other ranks the increments that their owners have: a rank knows those of its own nodes and of nodes
/// around its soil, but not of all nodes of its leaves without soil.
template <int dim>
void complete(std::vector<double>& prediction, const LeafTable<dim>& table, const MPI_Comm communicator)
{
  const std::vector<long long> begin =
      gather_everywhere(std::vector<long long>{sum_over_lower_ranks(table.n_owned_nodes, communicator)}, communicator);
  std::vector<std::vector<NodeQuestion<long long>>> questions(begin.size());
  std::unordered_map<long long, std::size_t> owned;
  for (std::size_t node = 0; node < table.node_ids.size(); ++node)
    if (const long long id = table.node_ids[node]; table.node_owner_is_me[node])
      owned.emplace(id, node);
    else
      questions[std::upper_bound(begin.begin(), begin.end(), id) - begin.begin() - 1].push_back({node, id});
  const auto find = [&](const long long id) -> std::optional<Vector<dim>>
  {
    const auto found = owned.find(id);
    if (found == owned.end())
      return {};
    Vector<dim> increment;
    std::copy_n(prediction.begin() + dim * found->second, dim, increment.begin());
    return increment;
  };
  ask_for_increments<dim>(questions, find, communicator, prediction);
}

/// Asks the former owners for the increments at nodes in leaves that were not this rank's.
template <int dim>
void ask_others(const std::vector<double>& prediction, const LeafTable<dim>& from, const LeafTable<dim>& to,
                const std::vector<std::size_t>& nodes, const MPI_Comm communicator, std::vector<double>& result)
{
  std::vector<std::vector<NodeQuestion<Vector<dim>>>> questions(size_of(communicator));
  for (const std::size_t node : nodes)
    if (const int owner = from.find_owner(to.node_position[node]); owner >= 0)
      questions[owner].push_back({node, to.node_position[node]});
  const auto find = [&](const Vector<dim>& x) -> std::optional<Vector<dim>>
  {
    const int leaf = from.find_leaf(x);
    return leaf < 0 ? std::nullopt : std::make_optional(interpolate<dim>(prediction, from, leaf, x));
  };
  ask_for_increments<dim>(questions, find, communicator, result);
}
} // namespace

template <int dim>
Prediction transfer_prediction(const Prediction& prediction, const LeafTable<dim>& from, const LeafTable<dim>& to,
                               const MPI_Comm communicator)
{
  if (!prediction)
    return {};
  std::vector<double> known = *prediction;
  if (size_of(communicator) > 1)
    complete<dim>(known, from, communicator);
  std::vector<double> result(dim * to.node_position.size(), 0.);
  std::vector<std::size_t> of_others;
  for (std::size_t node = 0; node < to.node_position.size(); ++node)
    if (const int leaf = from.find_leaf(to.node_position[node]); leaf >= 0 && from.leaves[leaf].owned)
    {
      const Vector<dim> increment = interpolate<dim>(known, from, leaf, to.node_position[node]);
      std::copy(increment.begin(), increment.end(), result.begin() + dim * node);
    }
    else
      of_others.push_back(node);
  if (size_of(communicator) > 1)
    ask_others<dim>(known, from, to, of_others, communicator, result);
  return result;
}

template Prediction transfer_prediction<2>(const Prediction&, const LeafTable<2>&, const LeafTable<2>&, MPI_Comm);
template Prediction transfer_prediction<3>(const Prediction&, const LeafTable<3>&, const LeafTable<3>&, MPI_Comm);
} // namespace kedge
