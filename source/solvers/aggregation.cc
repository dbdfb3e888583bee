#include <algorithm>
#include <kedge/solvers/aggregation.h>

namespace kedge
{
namespace
{
constexpr int none = -1;

struct Graph
{
  const std::vector<int>& row_begin;
  const std::vector<int>& column;
  const std::vector<unsigned char>& taken;

  int n() const { return static_cast<int>(taken.size()); }

  template <typename Visit> void visit_neighbours(const int v, const Visit& visit) const
  {
    for (int k = row_begin[v]; k < row_begin[v + 1]; ++k)
      if (column[k] < n() && taken[column[k]] != 0)
        visit(column[k]);
  }
};

/// Node v and those of its neighbours that are free become an aggregate.
void take_star(const Graph& graph, const int v, Aggregates& aggregates)
{
  aggregates.of_node[v] = aggregates.n;
  graph.visit_neighbours(v,
                         [&](const int w)
                         {
                           if (aggregates.of_node[w] == none)
                             aggregates.of_node[w] = aggregates.n;
                         });
  ++aggregates.n;
}

/// The aggregate, of those in `of_node`, that most of the neighbours belong to.
int most_touched(const Graph& graph, const int v, const std::vector<int>& of_node, std::vector<int>& touched)
{
  touched.clear();
  graph.visit_neighbours(v,
                         [&](const int w)
                         {
                           if (of_node[w] != none)
                             touched.push_back(of_node[w]);
                         });
  std::sort(touched.begin(), touched.end());
  int best = none;
  std::ptrdiff_t most = 0;
  for (auto begin = touched.begin(); begin != touched.end();)
  {
    const auto end = std::upper_bound(begin, touched.end(), *begin);
    if (end - begin > most)
    {
      most = end - begin;
      best = *begin;
    }
    begin = end;
  }
  return best;
}
} // namespace

Aggregates aggregate(const std::vector<int>& row_begin, const std::vector<int>& column,
                     const std::vector<unsigned char>& taken)
{
  const Graph graph{row_begin, column, taken};
  Aggregates aggregates;
  aggregates.of_node.assign(graph.n(), none);
  const auto is_free = [&](const int v) { return taken[v] != 0 && aggregates.of_node[v] == none; };
  for (int v = 0; v < graph.n(); ++v)
  {
    bool all_free = is_free(v), has_neighbours = false;
    if (all_free)
      graph.visit_neighbours(v,
                             [&](const int w)
                             {
                               has_neighbours = has_neighbours || w != v;
                               all_free = all_free && aggregates.of_node[w] == none;
                             });
    if (all_free && has_neighbours)
      take_star(graph, v, aggregates);
  }
  // All at once, so that no aggregate grows by more than one layer.
  const std::vector<int> stars = aggregates.of_node;
  std::vector<int> touched;
  for (int v = 0; v < graph.n(); ++v)
    if (is_free(v))
      aggregates.of_node[v] = most_touched(graph, v, stars, touched);
  for (int v = 0; v < graph.n(); ++v)
    if (is_free(v))
      take_star(graph, v, aggregates);
  return aggregates;
}
} // namespace kedge
