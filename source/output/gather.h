// Collects rows of plain data on the rank that writes.
#pragma once

#include <kedge/base/communication.h>

namespace kedge
{
/// The rows (`width` entries each) of all ranks in their order, on rank 0 only. Counts rows, not bytes, so that a table
/// may be larger than 2 GiB. Collective.
template <typename T>
std::vector<T> gather_rows_on_root(const std::vector<T>& mine, unsigned int width, MPI_Comm communicator)
{
  static_assert(std::is_trivially_copyable<T>::value, "only plain data can be sent");
  const int size = size_of(communicator);
  if (size == 1 || width == 0)
    return mine;
  const int n_mine = static_cast<int>(mine.size() / width);
  std::vector<int> count(size), begin(size + 1, 0);
  MPI_Gather(&n_mine, 1, MPI_INT, count.data(), 1, MPI_INT, 0, communicator);
  const bool root = rank_of(communicator) == 0;
  if (root)
    std::partial_sum(count.begin(), count.end(), begin.begin() + 1);
  std::vector<T> all(root ? std::size_t(begin[size]) * width : 0);
  MPI_Datatype row;
  MPI_Type_contiguous(static_cast<int>(width * sizeof(T)), MPI_BYTE, &row);
  MPI_Type_commit(&row);
  MPI_Gatherv(mine.data(), n_mine, row, all.data(), count.data(), begin.data(), row, 0, communicator);
  MPI_Type_free(&row);
  return all;
}
} // namespace kedge
