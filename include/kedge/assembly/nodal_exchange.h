// Nodal vectors over the ranks: each rank has the nodes that it owns and the ghosts that its particles see.
#pragma once

#include <kedge/assembly/node_graph.h>

namespace kedge
{
/// Nodal vectors have dim entries per local node (owned, then ghosts).
using NodalVector = View<double*>;

class NodalExchange
{
public:
  /// Exchanges between the owned dofs and the `n_local` dofs of all local nodes. Without an importer both are the same.
  NodalExchange(std::size_t n_local, const Teuchos::RCP<const TpetraMap>& owned,
                const Teuchos::RCP<const TpetraMap>& local, const Teuchos::RCP<const TpetraImport>& importer);
  /// The same for `dim` dofs per node of a numbering. Collective.
  NodalExchange(unsigned int dim, const NodeNumbering& numbering);

  /// Zeros, one entry per local dof.
  NodalVector make_nodal_vector() const;
  /// Owned values, and for ghosts the values of their owners. Collective.
  NodalVector spread(const TpetraVector& owned) const;
  /// Sums the contributions of all ranks to the owned dofs. Collective.
  void collect(const NodalVector& local, TpetraVector& owned) const;
  /// Replaces every entry by its sum over the ranks. Collective.
  void sum_over_ranks(const NodalVector& local) const;

private:
  std::size_t n_local;
  Teuchos::RCP<const TpetraMap> owned_map, local_map;
  Teuchos::RCP<const TpetraImport> importer;
};
} // namespace kedge
