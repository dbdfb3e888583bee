// Symmetric Gauss-Seidel smoothing node by node.
#pragma once

#include <kedge/base/tpetra.h>
#include <vector>

namespace kedge
{
/// A forward and a backward sweep over the nodes of a matrix, each of which is solved for its block_size (2 or 3)
/// unknowns together. Between ranks, values of before the sweeps count. The matrix is held in single precision, which
/// halves the memory that a sweep reads; vectors are double.
class BlockGaussSeidel
{
public:
  /// `matrix` has block_size consecutive rows, and columns, per node, all blocks whole.
  BlockGaussSeidel(const TpetraMatrix& matrix, unsigned int block_size);

  /// Improves x as the solution of A x = b. Collective.
  void sweep(const TpetraVector& b, TpetraVector& x) const;

private:
  template <int size> void copy(const TpetraMatrix& matrix);
  template <int size> void sweep_blocks(const TpetraVector& b, TpetraVector& x) const;

  /// Numbers of a column of a block, or of a node in a vector: whole SIMD registers.
  static constexpr unsigned int lanes = 4;

  unsigned int block_size;
  std::size_t n_columns = 0; ///< nodes of the columns
  Teuchos::RCP<const TpetraMap> column_map;
  Teuchos::RCP<const TpetraImport> importer; ///< null on one rank
  // host memory: the sweeps go from node to node
  std::vector<unsigned int> row_begin, column; ///< of blocks off the diagonal, by node
  std::vector<float> blocks, inverse;          ///< column by column, `lanes` numbers each; inverses of diagonal blocks
};
} // namespace kedge
