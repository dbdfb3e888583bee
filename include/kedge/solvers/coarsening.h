// From the finest level of multigrid to the next.
#pragma once

#include <kedge/solvers/node_blocks.h>

namespace kedge
{
/// Where the blocks of the coarse matrix come from. Block c couples aggregate row[c] with column[c] and is the sum of
/// P_v^T (sum of A_vw P_w) over parts s = part_begin[c] .. part_begin[c + 1] with v = node[s] and, within,
/// the blocks block_begin[s] .. block_begin[s + 1] of `block`: numbers of NodeBlocks, or -1 for that on the diagonal.
struct ProductPlan
{
  View<int*> row_begin; ///< first block of each row of blocks
  View<int*> row, column, part_begin;
  View<int*> node, block_begin;
  View<int*> block;
};

/// Interpolation from the modes of aggregates to the unknowns of nodes.
struct Prolongator
{
  unsigned int n_modes = 6; ///< per aggregate
  int n_aggregates = 0;     ///< of this rank
  View<int*> aggregate; ///< by node of the fine matrix' columns: its aggregate as a column of the coarse matrix; or -1
  View<float*> rows;    ///< by unknown of these nodes, in lanes of mode_lanes(n_modes)
  View<int*> node_begin, nodes; ///< by aggregate
};

KEDGE_FUNCTION constexpr unsigned int mode_lanes(const unsigned int n_modes) { return n_modes == 3 ? 4 : 8; }

/// Aggregates of a matrix' nodes with the rigid body modes as their unknowns. P interpolates them to the nodes: its
/// columns are the modes of each aggregate, made orthonormal. P^T A P is the coarse matrix. Aggregates do not reach
/// beyond a rank.
class Coarsening
{
public:
  /// `near_null_space`: the modes, as columns on the row map of the matrix: 3 in the plane (block size 2), 6 in space.
  /// Nodes without modes stay out. The blocks are those of the matrix. Collective.
  Coarsening(const TpetraMatrix& matrix, const NodeBlocks& blocks, const TpetraMultiVector& near_null_space);

  unsigned int n_modes() const { return prolongator.n_modes; }
  /// Its rows are the modes of this rank's aggregates, one aggregate after the other. A mode that an aggregate cannot
  /// have, as it has too few nodes, has 1 on the diagonal.
  const Teuchos::RCP<TpetraMatrix>& matrix() const { return coarse_matrix; }
  /// P^T of the modes, with almost nothing, but not zero, for modes that an aggregate cannot have.
  const Teuchos::RCP<TpetraMultiVector>& near_null_space() const { return coarse_modes; }

  /// Computes the coarse matrix anew, from the blocks as they are now.
  void renew();
  /// to = P^T from
  void restrict(const TpetraVector& from, TpetraVector& to) const;
  /// to += P from
  void add_prolonged(const TpetraVector& from, TpetraVector& to) const;

private:
  NodeBlocks blocks;
  Prolongator prolongator;
  ProductPlan plan;
  Teuchos::RCP<TpetraMatrix> coarse_matrix;
  Teuchos::RCP<TpetraMultiVector> coarse_modes;
};
} // namespace kedge
