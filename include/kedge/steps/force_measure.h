// How far a step is from balance: unbalanced forces over those that act, node by node.
#pragma once

#include <kedge/assembly/nodal_exchange.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// The node whose residual is largest by its own measure.
struct WorstNode
{
  double share = 0.;     ///< of the unbalanced force in those that act; below 0: no rank has a node
  unsigned int node = 0; ///< owned by `rank`
  int rank = 0;
};

/// Divides the sizes of forces (N), entry dim * v of `sizes` on the owned dofs, into those of the residual: the share
/// of the first that is the second. 0 where no force is.
void find_shares(unsigned int dim, const TpetraVector& residual, TpetraVector& sizes);

/// Share of the forces at a node that nothing balances: |r_a| / (s_a + floor h_a^(dim-1)), s_a the sum of the sizes of
/// all forces on it and h_a its cell size. So a fine node counts as much as a coarse one, for s_a of a stress sigma is
/// about sigma h_a^(dim-1). The floor is the root mean square of s_a / h_a^(dim-1) over all nodes: soil at a free
/// surface or without stress needs no better balance than the rest. The measure is the root mean square over all nodes,
/// but at least a fiftieth of the largest: in a large mesh a few nodes at a body would hardly count.
class ForceMeasure
{
public:
  ForceMeasure() = default;
  /// `cell_sizes` of the owned nodes, m. Collective.
  ForceMeasure(unsigned int dim, MPI_Comm communicator, const std::vector<double>& cell_sizes);

  /// Takes s_a (N) from entry dim * a of a vector on the owned dofs. Collective.
  void renew(const TpetraVector& sizes);
  /// Whether no force acts anywhere, or none is known yet.
  bool is_zero() const { return !(floor > 0.); }

  /// Stress that counts at every node, Pa.
  double least_stress() const { return floor; }

  /// Of a residual on the owned dofs, N; 0 without forces. Collective.
  double of(const TpetraVector& residual) const;
  /// Collective; every rank gets the same answer.
  WorstNode worst(const TpetraVector& residual) const;

private:
  unsigned int dim = 0;
  MPI_Comm communicator = MPI_COMM_SELF;
  double n_nodes = 0.; ///< over all ranks
  double floor = 0.;   ///< Pa (2-D: N/m)
  View<double*> area;  ///< h^(dim-1) of every owned node
  View<double*> scale; ///< of every owned node, N
};
} // namespace kedge
