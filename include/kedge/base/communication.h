// The few patterns of communication (MPI) that the rooms share.
#pragma once

#include <mpi.h>
#include <numeric>
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

/// Sends to_rank[r] to rank r; returns what each rank sent here. Collective; T must be trivially copyable.
template <typename T>
std::vector<std::vector<T>> exchange_between_ranks(const std::vector<std::vector<T>>& to_rank,
                                                   const MPI_Comm communicator)
{
  static_assert(std::is_trivially_copyable<T>::value, "only plain data can be sent");
  const int size = size_of(communicator);
  if (size == 1)
    return to_rank;
  std::vector<int> send_count(size), receive_count(size), send_begin(size + 1, 0), receive_begin(size + 1, 0);
  for (int r = 0; r < size; ++r)
    send_count[r] = static_cast<int>(to_rank[r].size() * sizeof(T));
  MPI_Alltoall(send_count.data(), 1, MPI_INT, receive_count.data(), 1, MPI_INT, communicator);
  std::partial_sum(send_count.begin(), send_count.end(), send_begin.begin() + 1);
  std::partial_sum(receive_count.begin(), receive_count.end(), receive_begin.begin() + 1);
  std::vector<T> send, receive(receive_begin[size] / sizeof(T));
  send.reserve(send_begin[size] / sizeof(T));
  for (const auto& part : to_rank)
    send.insert(send.end(), part.begin(), part.end());
  MPI_Alltoallv(send.data(), send_count.data(), send_begin.data(), MPI_BYTE, receive.data(), receive_count.data(),
                receive_begin.data(), MPI_BYTE, communicator);
  std::vector<std::vector<T>> from_rank(size);
  for (int r = 0; r < size; ++r)
    from_rank[r].assign(receive.begin() + receive_begin[r] / sizeof(T),
                        receive.begin() + receive_begin[r + 1] / sizeof(T));
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
