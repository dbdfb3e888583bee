// A sparser approximation of a matrix of the GIMP basis, for building preconditioners.
#pragma once

#include <kedge/base/tpetra.h>
#include <vector>

namespace kedge
{
/// Positions of the nodes of a matrix's owned rows (block_size coordinates per node) and the size of the largest cell
/// at each node, both in m.
struct NodePlaces
{
  std::vector<double> position, spacing;
};

/// The GIMP boxes of particles couple nodes that are two cells apart: in 3-D a row has up to 125 blocks, where finite
/// elements have 27. The far blocks are small. Here they are added to the diagonal block of their row. This keeps the
/// row sums, and so the response to translations, and a smoothing sweep costs a quarter. A weak diagonal ruins the
/// smoother, so a diagonal entry that would lose more than 5 % gets 0.3 times the magnitude of the far entries instead.
class NearMatrix
{
public:
  /// `matrix` has block_size consecutive rows, and columns, per node. Collective.
  NearMatrix(const Teuchos::RCP<const TpetraMatrix>& matrix, unsigned int block_size, const NodePlaces& places);

  /// Copies the present values of the matrix.
  void update();

  const Teuchos::RCP<TpetraMatrix>& matrix() const { return near; }

private:
  Teuchos::RCP<const TpetraMatrix> full;
  Teuchos::RCP<TpetraMatrix> near;
  View<unsigned int*> target; ///< entry of `near` that each entry of `full` is added to
};
} // namespace kedge
