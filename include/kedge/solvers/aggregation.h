// Which nodes multigrid takes together.
#pragma once

#include <vector>

namespace kedge
{
struct Aggregates
{
  int n = 0;
  std::vector<int> of_node; ///< the number of a node's aggregate, or -1
};

/// Neighbours in a graph taken together: a node with all its neighbours, and what is left between such stars with the
/// one that it touches most (Vanek, Mandel & Brezina 1996, doi:10.1007/BF02238511). The neighbours of node v are
/// column[row_begin[v] .. row_begin[v + 1]); those from n on, the number of rows, belong to other ranks and are left
/// out, as are nodes that are not `taken`.
Aggregates aggregate(const std::vector<int>& row_begin, const std::vector<int>& column,
                     const std::vector<unsigned char>& taken);
} // namespace kedge
