// A sparser stand-in for a matrix of the GIMP basis, to build preconditioners from.
#pragma once

#include <kedge/base/tpetra.h>
#include <vector>

namespace kedge
{
/// Where the nodes of a matrix's owned rows are: block_size coordinates per node, and the size of the largest cell at
/// each node, both in m.
struct NodePlaces
{
  std::vector<double> position, spacing;
};

/// The GIMP boxes of particles couple nodes two cells apart: in 3-D up to 125 blocks a row, where elements have 27. The
/// far blocks are small. Here they are added to the block's own row on the diagonal, which keeps the row sums and so
/// the answer to translations, at a quarter of the cost of every smoothing sweep. Where that would take more than 5 %
/// off the diagonal, 0.3 times the far blocks' magnitude is added to it instead: a weak diagonal ruins the smoother.
class NearMatrix
{
public:
  /// `matrix` has block_size consecutive rows, and columns, per node. Collective.
  NearMatrix(const Teuchos::RCP<const TpetraMatrix>& matrix, unsigned int block_size, const NodePlaces& places);

  /// Takes over the matrix's present values.
  void update();

  const Teuchos::RCP<TpetraMatrix>& matrix() const { return near; }

private:
  Teuchos::RCP<const TpetraMatrix> full;
  Teuchos::RCP<TpetraMatrix> near;
  View<unsigned int*> target; ///< entry of `near` that each entry of `full` is added to
};
} // namespace kedge
