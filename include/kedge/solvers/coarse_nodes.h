// The nodes of multigrid's next level, while it is made on the host.
#pragma once

#include <kedge/solvers/aggregation.h>
#include <kedge/solvers/node_blocks.h>

namespace kedge
{
/// Aggregates of the nodes of a matrix.
struct CoarseNodes
{
  unsigned int size, modes;           ///< unknowns of a fine and a coarse node
  std::vector<int> row_begin, column; ///< of the blocks off the diagonal
  Aggregates aggregates;
  Teuchos::RCP<const TpetraMap> map;    ///< of their modes
  std::vector<int> node_begin, nodes;   ///< by aggregate
  std::vector<int> aggregate_of_column; ///< with those of other ranks behind this rank's; or -1
  std::vector<GlobalOrdinal> ghosts;    ///< aggregates of other ranks: global numbers, ascending

  /// The global number of this rank's first aggregate.
  GlobalOrdinal first() const { return aggregates.n > 0 ? map->getMinGlobalIndex() / modes : 0; }
};

/// Nodes without near-null-space modes stay out. Collective.
CoarseNodes make_coarse_nodes(const TpetraMatrix& matrix, const NodeBlocks& blocks, const TpetraMultiVector& modes);

/// The modes of each aggregate, made orthonormal, on the row map of the matrix; and what `modes` are in terms of them.
void make_prolongator(const CoarseNodes& at, const TpetraMultiVector& modes, TpetraMultiVector& prolongator,
                      TpetraMultiVector& coarse_modes);

/// The vectors on the columns of the matrix. Collective.
Teuchos::RCP<const TpetraMultiVector> with_ghosts(const TpetraMatrix& matrix,
                                                  const Teuchos::RCP<const TpetraMultiVector>& owned);

/// Lists of a ProductPlan (coarsening.h).
struct ProductLists
{
  std::vector<int> row_begin{0}, row, column, part_begin{0}, node, block_begin{0}, block;
};

ProductLists list_products(const CoarseNodes& at);
} // namespace kedge
