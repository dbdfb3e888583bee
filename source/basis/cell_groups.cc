#include <algorithm>
#include <kedge/basis/cell_groups.h>
#include <utility>

namespace kedge
{
CellGroups group_by_cell(const StencilSet& stencils, const std::vector<unsigned int>& leaf_of_particle,
                         const std::vector<unsigned char>& is_full)
{
  const std::vector<unsigned int> pattern = download(stencils.pattern_of_particle);
  const std::vector<unsigned int> pattern_begin = download(stencils.pattern_node_begin);
  const std::vector<unsigned int> pattern_nodes = download(stencils.pattern_nodes);
  std::vector<unsigned int> particle_begin{0}, node_begin{0}, nodes;
  const std::size_t n = leaf_of_particle.size();
  const unsigned int n_nodes =
      pattern_nodes.empty() ? 0 : *std::max_element(pattern_nodes.begin(), pattern_nodes.end()) + 1;
  // By node and by pattern, the number of cells with the last one that has it.
  std::vector<std::size_t> last_cell(n_nodes, 0), last_cell_of_pattern(stencils.n_patterns, 0);
  for (std::size_t begin = 0, end = 0; begin < n; begin = end)
  {
    const unsigned int leaf = leaf_of_particle[begin];
    const std::size_t most = is_full[leaf] ? n : begin + 1;
    const std::size_t number = particle_begin.size();
    for (end = begin; end < most && leaf_of_particle[end] == leaf; ++end)
    {
      const unsigned int k = pattern[end];
      if (std::exchange(last_cell_of_pattern[k], number) == number)
        continue;
      for (unsigned int i = pattern_begin[k]; i < pattern_begin[k + 1]; ++i)
        if (std::exchange(last_cell[pattern_nodes[i]], number) != number)
          nodes.push_back(pattern_nodes[i]);
    }
    std::sort(nodes.begin() + node_begin.back(), nodes.end());
    particle_begin.push_back(end);
    node_begin.push_back(nodes.size());
  }
  return {upload(particle_begin, "cell particle begin"),
          upload(node_begin, "cell node begin"),
          upload(nodes, "cell nodes"),
          View<double*>("volume factor", n),
          View<double*>("cell pressure", n),
          View<double*>("spring", n)};
}

std::vector<int> groups_of_leaves(const CellGroups& cells, const std::vector<unsigned int>& leaf_of_particle,
                                  const std::size_t n_leaves)
{
  std::vector<int> group(n_leaves, -1);
  const std::vector<unsigned int> begin = download(cells.particle_begin);
  for (std::size_t c = 0; c < cells.n_cells(); ++c)
    if (begin[c + 1] - begin[c] > 1)
      group[leaf_of_particle[begin[c]]] = c;
  return group;
}
} // namespace kedge
