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
  const int n_mine = message_length(mine.size() / width);
  std::vector<int> count(size);
  MPI_Gather(&n_mine, 1, MPI_INT, count.data(), 1, MPI_INT, 0, communicator);
  const std::vector<int> begin = begin_of_parts(count); // all zero but on the root
  std::vector<T> all(std::size_t(begin[size]) * width);
  const PlainType row(width * sizeof(T));
  MPI_Gatherv(mine.data(), n_mine, row.get(), all.data(), count.data(), begin.data(), row.get(), 0, communicator);
  return all;
}
} // namespace kedge
