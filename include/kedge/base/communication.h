// The few patterns of communication (MPI) that the rooms share.
#pragma once

#include <cstddef>
#include <limits>
#include <mpi.h>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace kedge
{
inline int rank_of(const MPI_Comm communicator)
{
  int rank = 0;
  MPI_Comm_rank(communicator, &rank);
  return rank;
}

inline int size_of(const MPI_Comm communicator)
{
  int size = 1;
  MPI_Comm_size(communicator, &size);
  return size;
}

inline double sum_over_ranks(double value, const MPI_Comm communicator)
{
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, communicator);
  return value;
}

inline long long sum_over_ranks(long long value, const MPI_Comm communicator)
{
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_LONG_LONG, MPI_SUM, communicator);
  return value;
}

inline double max_over_ranks(double value, const MPI_Comm communicator)
{
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, communicator);
  return value;
}

inline double min_over_ranks(const double value, const MPI_Comm communicator)
{
  return -max_over_ranks(-value, communicator);
}

/// Sum of `value` over the ranks below this one.
inline long long sum_over_lower_ranks(const long long value, const MPI_Comm communicator)
{
  long long sum = 0;
  MPI_Exscan(&value, &sum, 1, MPI_LONG_LONG, MPI_SUM, communicator);
  return rank_of(communicator) == 0 ? 0 : sum;
}

/// Gives every rank the text of one. Collective.
inline void broadcast(std::string& text, const int from, const MPI_Comm communicator)
{
  unsigned long size = text.size();
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, from, communicator);
  text.resize(size);
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, from, communicator);
}

/// A type of MPI for plain data, so that messages are counted in entries: their bytes may be too many for an int.
class PlainType
{
public:
  explicit PlainType(const std::size_t bytes)
  {
    MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &type);
    MPI_Type_commit(&type);
  }
  PlainType(const PlainType&) = delete;
  PlainType& operator=(const PlainType&) = delete;
  ~PlainType() { MPI_Type_free(&type); }
  MPI_Datatype get() const { return type; }

private:
  MPI_Datatype type = MPI_DATATYPE_NULL;
};

/// Where the parts of a message begin, from their numbers of entries, and behind the last one its length. Throws where
/// that is too long for MPI.
inline std::vector<int> begin_of_parts(const std::vector<int>& count)
{
  std::vector<int> begin(count.size() + 1, 0);
  for (std::size_t r = 0; r < count.size(); ++r)
  {
    const long long end = begin[r] + static_cast<long long>(count[r]);
    if (count[r] < 0 || end > std::numeric_limits<int>::max())
      throw std::length_error("a message between ranks is too long; run with more ranks");
    begin[r + 1] = static_cast<int>(end);
  }
  return begin;
}

/// Sends to_rank[r] to rank r; returns what each rank sent here. Collective; T must be trivially copyable.
template <typename T>
std::vector<std::vector<T>> exchange_between_ranks(const std::vector<std::vector<T>>& to_rank,
                                                   const MPI_Comm communicator)
{
  static_assert(std::is_trivially_copyable<T>::value, "only plain data can be sent");
  const int size = size_of(communicator);
  if (size == 1)
    return to_rank;
  std::vector<int> send_count(size), receive_count(size);
  for (int r = 0; r < size; ++r)
    send_count[r] = static_cast<int>(to_rank[r].size());
  MPI_Alltoall(send_count.data(), 1, MPI_INT, receive_count.data(), 1, MPI_INT, communicator);
  const std::vector<int> send_begin = begin_of_parts(send_count), receive_begin = begin_of_parts(receive_count);
  std::vector<T> send, receive(receive_begin[size]);
  send.reserve(send_begin[size]);
  for (const auto& part : to_rank)
    send.insert(send.end(), part.begin(), part.end());
  const PlainType type(sizeof(T));
  MPI_Alltoallv(send.data(), send_count.data(), send_begin.data(), type.get(), receive.data(), receive_count.data(),
                receive_begin.data(), type.get(), communicator);
  std::vector<std::vector<T>> from_rank(size);
  for (int r = 0; r < size; ++r)
    from_rank[r].assign(receive.begin() + receive_begin[r], receive.begin() + receive_begin[r + 1]);
  return from_rank;
}

/// Joins the contributions of all ranks, in their order, on every rank. Collective; T must be trivially copyable.
template <typename T> std::vector<T> gather_everywhere(const std::vector<T>& mine, const MPI_Comm communicator)
{
  const std::vector<std::vector<T>> from_rank =
      exchange_between_ranks(std::vector<std::vector<T>>(size_of(communicator), mine), communicator);
  std::vector<T> all;
  for (const auto& part : from_rank)
    all.insert(all.end(), part.begin(), part.end());
  return all;
}
} // namespace kedge
