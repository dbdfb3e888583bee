// The nodes that carry unknowns, and their numbers over the ranks.
#pragma once

#include <kedge/mesh/leaf_table.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// Active nodes of a rank: first the nodes that it owns, then ghosts, grouped by owner. A ghost is seen by this rank's
/// particles but owned by another rank.
struct ActiveNodes
{
  static constexpr unsigned int inactive = ~0u;
  MPI_Comm communicator = MPI_COMM_WORLD;
  unsigned int n_owned = 0;
  std::vector<long long> global;       ///< contiguous over the ranks
  std::vector<unsigned int> mesh_node; ///< number in the leaf table, of owned and ghost nodes
  std::vector<unsigned int>
      ghost_begin;                  ///< ghosts owned by rank r: [ghost_begin[r], ghost_begin[r + 1]) in local numbers
  std::vector<unsigned int> number; ///< leaf-table node -> local active number, or `inactive`
  long long n_global = 0;

  unsigned int n_local() const { return global.size(); }
};

/// Numbers the nodes that at least one rank uses. `used[node]` is nonzero if this rank's stencils use that node of the
/// table. Collective.
template <int dim>
ActiveNodes number_active_nodes(const LeafTable<dim>& table, const std::vector<unsigned char>& used,
                                MPI_Comm communicator);
} // namespace kedge
