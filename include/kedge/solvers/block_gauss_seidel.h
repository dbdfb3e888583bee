// Symmetric Gauss-Seidel smoothing node by node.
#pragma once

#include <kedge/base/tpetra.h>
#include <vector>

namespace kedge
{
/// In which order the nodes of a rank are solved.
enum class SweepOrder
{
  by_number, ///< one after the other: for back ends with one thread
  by_colour  ///< those of a colour, which no block couples, at once
};

/// The order that suits the back end.
SweepOrder sweep_order();

/// The matrix as sweeps read it: blocks off the diagonal by node, column by column, with an idle lane, and the inverses
/// of diagonal blocks.
struct NodeBlocks
{
  View<int*> row_begin, column;
  View<float*> blocks, inverse;
  View<double*> values; ///< of owned nodes, then ghosts, in lanes: what the sweeps work on
  View<int*> order;     ///< the nodes, colour by colour
};

/// A forward and a backward sweep over the nodes of a matrix, each of which is solved for its block_size (2 or 3)
/// unknowns together. Between ranks, values of before the sweeps count. The matrix is held in single precision, which
/// halves the memory that a sweep reads; vectors are double.
class BlockGaussSeidel
{
public:
  /// `matrix` has block_size consecutive rows, and columns, per node, the diagonal among them.
  BlockGaussSeidel(const TpetraMatrix& matrix, unsigned int block_size, SweepOrder order = sweep_order());

  /// Takes the entries of the matrix as they are now; where they are, must not have changed.
  void renew(const TpetraMatrix& matrix);

  /// Improves x as the solution of A x = b. Collective.
  void sweep(const TpetraVector& b, TpetraVector& x) const;

  /// Of the sweeps: one if they go by number.
  std::size_t n_colours() const { return colour_begin.size() - 1; }

private:
  void set_order(SweepOrder order);

  unsigned int block_size;
  std::size_t n_nodes, n_columns; ///< of this rank; nodes of the columns
  Teuchos::RCP<const TpetraMap> column_map;
  Teuchos::RCP<const TpetraImport> importer; ///< null on one rank
  NodeBlocks held;
  std::vector<int> colour_begin;
};
} // namespace kedge
