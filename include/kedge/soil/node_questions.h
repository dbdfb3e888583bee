// Ranks ask each other for the increments of nodes.
#pragma once

#include <algorithm>
#include <array>
#include <kedge/base/communication.h>
#include <optional>

namespace kedge
{
/// What a rank asks of a node: how the other rank knows it.
template <typename Key> struct NodeQuestion
{
  std::size_t node; ///< of the rank that asks
  Key key;
};

/// Sends questions[r] to rank r, which answers with find(key), a std::optional of dim increments, and enters what comes
/// back for each node into `increments` (dim per node). Nodes without an answer stay as they are. Collective.
template <int dim, typename Key, typename Find>
void ask_for_increments(const std::vector<std::vector<NodeQuestion<Key>>>& questions, const Find& find,
                        const MPI_Comm communicator, std::vector<double>& increments)
{
  struct Answer
  {
    std::size_t node;
    std::array<double, dim> increment;
  };
  const auto asked = exchange_between_ranks(questions, communicator);
  std::vector<std::vector<Answer>> answers(asked.size());
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const NodeQuestion<Key>& question : asked[r])
      if (const std::optional<std::array<double, dim>> found = find(question.key))
        answers[r].push_back({question.node, *found});
  for (const auto& part : exchange_between_ranks(answers, communicator))
    for (const Answer& answer : part)
      std::copy(answer.increment.begin(), answer.increment.end(), increments.begin() + dim * answer.node);
}
} // namespace kedge
