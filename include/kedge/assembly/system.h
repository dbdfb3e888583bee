// The nonlinear system of one step on the active nodes: vectors over ranks, constraints, the matrix.
#pragma once

#include <kedge/assembly/internal_force.h>
#include <kedge/assembly/nodal_exchange.h>

namespace kedge
{
class System
{
public:
  /// `constrained` marks dofs (dim per local node) that stay zero. Collective.
  System(unsigned int dim, const NodeNumbering& numbering, const std::vector<NodeLists>& couplings,
         const std::vector<unsigned char>& constrained);

  const NodeGraph& graph() const { return node_graph; }
  const Teuchos::RCP<TpetraMatrix>& matrix() const { return owned_matrix; }
  /// Values of all rows, laid out by graph(). Kernels add to them.
  const View<double*>& values() const { return all_values; }
  /// A zero vector with dim entries per local node.
  NodalVector make_nodal_vector() const { return exchange.make_nodal_vector(); }

  /// Owned values, and for ghosts the values of their owners. Collective.
  NodalVector spread(const TpetraVector& owned) const { return exchange.spread(owned); }
  /// Sums the contributions of all ranks to the owned dofs. Collective.
  void collect(const NodalVector& local, TpetraVector& owned) const { exchange.collect(local, owned); }
  /// Sets constrained entries to zero.
  void zero_constrained(TpetraVector& owned) const;

  /// Gives constrained entries of `result` the values that they have in `from`.
  void keep_constrained(const TpetraVector& from, TpetraVector& result) const;

  void clear_matrix();
  /// Adds ghost rows to the rows of their owners. Constrained rows and columns become a scaled identity. Collective.
  void finish_matrix();

private:
  NodeGraph node_graph;
  NodalExchange exchange;
  View<double*> all_values;
  Teuchos::RCP<TpetraMatrix> owned_matrix;
  View<unsigned char*> constrained_column; ///< per column dof
};
} // namespace kedge
