// Which rank owns a place of the grid.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// Where a cell lies on the forest's space-filling curve.
struct ForestPlace
{
  std::uint64_t tree = 0;  ///< number in the forest
  std::uint64_t child = 0; ///< numbers of the children on the way down, three bits each, the first one leading

  static constexpr unsigned int depth = 20; ///< that 64 bits have room for; forests are less deep

  bool operator<(const ForestPlace& other) const
  {
    return tree < other.tree || (tree == other.tree && child < other.child);
  }
};

/// The child of a cell, of half its edge, that holds x; a point on a face belongs to the upper one. Moves the cell's
/// lower corner to the child's.
template <int dim>
unsigned int find_child(const std::array<double, dim>& x, const double half, std::array<double, dim>& corner)
{
  unsigned int child = 0;
  for (unsigned int d = 0; d < dim; ++d)
    if (x[d] >= corner[d] + half)
    {
      child |= 1u << d;
      corner[d] += half;
    }
  return child;
}

/// The cut of the forest's space-filling curve into the ranks' parts (Burstedde, Wilcox, Ghattas 2011, section 2.2, doi
/// 10.1137/100791634), as it was when this was made: two numbers per rank.
template <int dim> class Partition
{
public:
  /// A brick of trees, all of the same edge (m), its lower corner at the origin.
  struct Trees
  {
    std::array<unsigned int, dim> n{};
    double size = 0.;

    /// Of the tree that holds x, its number x fastest; a point on a face belongs to the upper tree. Sets its lower
    /// corner. x must lie in the brick.
    std::size_t find(const std::array<double, dim>& x, std::array<double, dim>& corner) const;
  };

  Partition() = default;
  /// `number_in_forest` by tree, x fastest. `first`: of this rank's cells; end() without cells. Collective.
  Partition(const Trees& trees, std::vector<std::uint64_t> number_in_forest, const ForestPlace& first,
            MPI_Comm communicator);
  static ForestPlace end() { return {std::numeric_limits<std::uint64_t>::max(), 0}; }

  const Trees& trees() const { return brick; }

  /// The rank whose leaf holds x, with the same rule for faces as LeafTable::find_leaf; x must lie in the grid.
  int find_owner(const std::array<double, dim>& x) const;

private:
  Trees brick;
  std::vector<std::uint64_t> number_in_forest; ///< by tree, x fastest
  std::vector<ForestPlace> begin;              ///< by rank; one without cells begins where the next one does
};
} // namespace kedge
