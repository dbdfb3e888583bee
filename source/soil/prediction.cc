#include <algorithm>
#include <kedge/base/communication.h>
#include <kedge/basis/gimp.h>
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

/// What another rank says of a node.
template <int dim> struct Answer
{
  std::size_t node; ///< of the rank that asks
  Vector<dim> increment;
};

/// Gives nodes of other ranks the increments that their owners have: a rank knows those of its own nodes and of nodes
/// around its soil, but not of all nodes of its leaves without soil.
template <int dim>
void complete(std::vector<double>& prediction, const LeafTable<dim>& table, const MPI_Comm communicator)
{
  struct Question
  {
    std::size_t node; ///< of the rank that asks
    long long id;
  };
  const int n_ranks = size_of(communicator);
  const std::vector<long long> begin =
      gather_everywhere(std::vector<long long>{sum_over_lower_ranks(table.n_owned_nodes, communicator)}, communicator);
  std::vector<std::vector<Question>> questions(n_ranks);
  std::unordered_map<long long, std::size_t> owned;
  for (std::size_t node = 0; node < table.node_ids.size(); ++node)
    if (const long long id = table.node_ids[node]; table.node_owner_is_me[node])
      owned.emplace(id, node);
    else
      questions[std::upper_bound(begin.begin(), begin.end(), id) - begin.begin() - 1].push_back({node, id});
  const std::vector<std::vector<Question>> asked = exchange_between_ranks(questions, communicator);
  std::vector<std::vector<Answer<dim>>> answers(n_ranks);
  for (int r = 0; r < n_ranks; ++r)
    for (const Question& question : asked[r])
      if (const auto found = owned.find(question.id); found != owned.end())
      {
        Answer<dim>& answer = answers[r].emplace_back();
        answer.node = question.node;
        std::copy_n(prediction.begin() + dim * found->second, dim, answer.increment.begin());
      }
  for (const auto& from_rank : exchange_between_ranks(answers, communicator))
    for (const Answer<dim>& answer : from_rank)
      std::copy(answer.increment.begin(), answer.increment.end(), prediction.begin() + dim * answer.node);
}

/// Asks the former owners for the increments at nodes in leaves that were not this rank's.
template <int dim>
void ask_others(const std::vector<double>& prediction, const LeafTable<dim>& from, const LeafTable<dim>& to,
                const std::vector<std::size_t>& nodes, const MPI_Comm communicator, std::vector<double>& result)
{
  struct Question
  {
    std::size_t node;
    Vector<dim> x;
  };
  const int n_ranks = size_of(communicator);
  std::vector<std::vector<Question>> questions(n_ranks);
  for (const std::size_t node : nodes)
    if (const int owner = from.find_owner(to.node_position[node]); owner >= 0)
      questions[owner].push_back({node, to.node_position[node]});
  const std::vector<std::vector<Question>> asked = exchange_between_ranks(questions, communicator);
  std::vector<std::vector<Answer<dim>>> answers(n_ranks);
  for (int r = 0; r < n_ranks; ++r)
    for (const Question& question : asked[r])
      if (const int leaf = from.find_leaf(question.x); leaf >= 0)
        answers[r].push_back({question.node, interpolate<dim>(prediction, from, leaf, question.x)});
  for (const auto& from_rank : exchange_between_ranks(answers, communicator))
    for (const Answer<dim>& answer : from_rank)
      std::copy(answer.increment.begin(), answer.increment.end(), result.begin() + dim * answer.node);
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
