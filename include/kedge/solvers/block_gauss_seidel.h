// Symmetric Gauss-Seidel smoothing node by node.
#pragma once

#include <kedge/solvers/node_blocks.h>
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

/// A forward and a backward sweep over the nodes of a matrix, each of which is solved for its 2 or 3 unknowns together.
/// Between ranks, values of before the sweeps count. The matrix is read in single precision, which halves the memory
/// that a sweep reads; vectors are double.
class BlockGaussSeidel
{
public:
  /// `blocks` are those of the matrix; it follows when they are renewed.
  BlockGaussSeidel(const TpetraMatrix& matrix, const NodeBlocks& blocks, SweepOrder order = sweep_order());

  /// Improves x as the solution of A x = b. Collective.
  void sweep(const TpetraVector& b, TpetraVector& x) const;

  /// Of the sweeps: one if they go by number.
  std::size_t n_colours() const { return colour_begin.size() - 1; }

private:
  void set_order(SweepOrder order);

  NodeBlocks blocks;
  Teuchos::RCP<const TpetraMap> column_map;
  Teuchos::RCP<const TpetraImport> importer; ///< null on one rank
  View<double*> values;                      ///< of owned nodes, then ghosts, in lanes
  View<int*> order;                          ///< the nodes, colour by colour
  std::vector<int> colour_begin;
};
} // namespace kedge
