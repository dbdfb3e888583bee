// A matrix as the finest level of multigrid reads it.
#pragma once

#include <Eigen/Core>
#include <kedge/base/tpetra.h>

namespace kedge
{
/// Numbers of a column of a block, or of a node in a vector: whole SIMD registers.
constexpr int block_lanes = 4;

/// The rows of this rank's nodes in blocks, column by column in lanes (those behind the last row hold zeros), in single
/// precision. Columns are owned nodes, then ghosts.
struct NodeBlocks
{
  unsigned int block_size = 3;
  std::size_t n_nodes = 0, n_columns = 0;
  View<int*> row_begin, column;   ///< off the diagonal, ascending within a row
  View<float*> blocks;            ///< so too
  View<float*> diagonal, inverse; ///< by node: the block on the diagonal and its inverse

  KEDGE_FUNCTION const float* block(const int k) const { return &blocks(std::size_t(block_lanes) * block_size * k); }
  KEDGE_FUNCTION const float* diagonal_of(const int v) const
  {
    return &diagonal(std::size_t(block_lanes) * block_size * v);
  }
};

/// `matrix` has block_size (2 or 3) consecutive rows, and columns, per node, the diagonal among them.
NodeBlocks make_node_blocks(const TpetraMatrix& matrix, unsigned int block_size);

/// Takes the entries of the matrix as they are now; where they are, must not have changed.
void renew_node_blocks(const TpetraMatrix& matrix, const NodeBlocks& blocks);
} // namespace kedge
