#include <algorithm>
#include <kedge/solvers/coarse_nodes.h>

namespace kedge
{
ProductLists list_products(const CoarseNodes& at)
{
  ProductLists lists;
  constexpr int unseen = -1, of_diagonal = -1;
  std::vector<int> position(at.aggregates.n + at.ghosts.size(), unseen), columns, begin;
  std::vector<std::pair<int, int>> sorted; // node and block
  for (int row = 0; row < at.aggregates.n; ++row)
  {
    const auto visit = [&](const auto& work)
    {
      for (int i = at.node_begin[row]; i < at.node_begin[row + 1]; ++i)
      {
        const int v = at.nodes[i];
        work(row, v, of_diagonal);
        for (int k = at.row_begin[v]; k < at.row_begin[v + 1]; ++k)
          if (at.aggregate_of_column[at.column[k]] >= 0)
            work(at.aggregate_of_column[at.column[k]], v, k);
      }
    };
    columns.clear();
    visit(
        [&](const int column, int, int)
        {
          if (position[column] == unseen)
          {
            position[column] = 0;
            columns.push_back(column);
          }
          ++position[column];
        });
    std::sort(columns.begin(), columns.end());
    begin.assign(1, 0);
    for (std::size_t c = 0; c < columns.size(); ++c)
    {
      begin.push_back(begin[c] + position[columns[c]]);
      position[columns[c]] = begin[c];
    }
    sorted.resize(begin.back());
    visit([&](const int column, const int v, const int k) { sorted[position[column]++] = {v, k}; });
    for (std::size_t c = 0; c < columns.size(); ++c)
    {
      position[columns[c]] = unseen;
      lists.row.push_back(row);
      lists.column.push_back(columns[c]);
      for (int i = begin[c]; i < begin[c + 1]; ++i)
      {
        if (i > begin[c] && sorted[i].first != sorted[i - 1].first)
          lists.block_begin.push_back(static_cast<int>(lists.block.size()));
        if (i == begin[c] || sorted[i].first != sorted[i - 1].first)
          lists.node.push_back(sorted[i].first);
        lists.block.push_back(sorted[i].second);
      }
      lists.block_begin.push_back(static_cast<int>(lists.block.size()));
      lists.part_begin.push_back(static_cast<int>(lists.node.size()));
    }
    lists.row_begin.push_back(static_cast<int>(lists.row.size()));
  }
  return lists;
}
} // namespace kedge
