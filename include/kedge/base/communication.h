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

/// A number of entries as MPI takes it. Throws where that is too large.
inline int message_length(const std::size_t n)
{
  if (n > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::length_error("a message between ranks is too long; run with more ranks");
  return static_cast<int>(n);
}

/// Where the parts of a message begin, from their numbers of entries, and behind the last one its length. Throws where
/// that is too long for MPI.
inline std::vector<int> begin_of_parts(const std::vector<int>& count)
{
  std::vector<int> begin(count.size() + 1, 0);
  for (std::size_t r = 0; r < count.size(); ++r)
    begin[r + 1] = message_length(static_cast<std::size_t>(begin[r]) + count[r]);
  return begin;
}

constexpr int tag_of_known_parts = 4711;

/// Of the messages of one exchange of unknown parts. Two in a row differ, for a rank may begin the next one while
/// another still listens; none can be two ahead. The communicator remembers which one was last.
inline int next_tag(const MPI_Comm communicator)
{
  static const int key = []
  {
    int made = MPI_KEYVAL_INVALID;
    MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, MPI_COMM_NULL_DELETE_FN, &made, nullptr);
    return made;
  }();
  static char is_odd; // its address is the mark
  void* mark = nullptr;
  int found = 0;
  MPI_Comm_get_attr(communicator, key, &mark, &found);
  const bool odd = found != 0 && mark != nullptr;
  MPI_Comm_set_attr(communicator, key, odd ? nullptr : &is_odd);
  return tag_of_known_parts + (odd ? 1 : 2);
}

/// Sends to_rank[r] to rank r; returns what each rank sent here. Ranks that get nothing see no message, so the cost
/// depends on the number of neighbours (Hoefler, Siebert, Lumsdaine 2010, doi 10.1145/1693453.1693476, algorithm NBX).
/// Collective; T must be trivially copyable.
template <typename T>
std::vector<std::vector<T>> exchange_between_ranks(const std::vector<std::vector<T>>& to_rank,
                                                   const MPI_Comm communicator)
{
  static_assert(std::is_trivially_copyable<T>::value, "only plain data can be sent");
  const int size = size_of(communicator);
  if (size == 1)
    return to_rank;
  const int me = rank_of(communicator), tag = next_tag(communicator);
  const PlainType type(sizeof(T));
  std::vector<std::vector<T>> from_rank(size);
  from_rank[me] = to_rank[me];
  std::vector<MPI_Request> sends;
  for (int r = 0; r < size; ++r)
    if (r != me && !to_rank[r].empty()) // synchronous: it is complete when the other rank has it
      MPI_Issend(to_rank[r].data(), message_length(to_rank[r].size()), type.get(), r, tag, communicator,
                 &sends.emplace_back());

  MPI_Request barrier = MPI_REQUEST_NULL; // complete when all ranks' messages have arrived
  for (int done = 0; !done;)
  {
    int arrived = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, tag, communicator, &arrived, &status);
    if (arrived)
    {
      int n = 0;
      MPI_Get_count(&status, type.get(), &n);
      from_rank[status.MPI_SOURCE].resize(n);
      MPI_Recv(from_rank[status.MPI_SOURCE].data(), n, type.get(), status.MPI_SOURCE, tag, communicator,
               MPI_STATUS_IGNORE);
    }
    if (barrier != MPI_REQUEST_NULL)
      MPI_Test(&barrier, &done, MPI_STATUS_IGNORE);
    else
    {
      int sent = 0;
      MPI_Testall(static_cast<int>(sends.size()), sends.data(), &sent, MPI_STATUSES_IGNORE);
      if (sent)
        MPI_Ibarrier(communicator, &barrier);
    }
  }
  return from_rank;
}

/// Sends entries [send_begin[r], send_begin[r + 1]) to rank r and receives entries [receive_begin[r],
/// receive_begin[r + 1]) from it, `width` numbers each; both sides know how many.
inline void exchange_known_parts(const double* send, const std::vector<int>& send_begin, double* receive,
                                 const std::vector<int>& receive_begin, const std::size_t width,
                                 const MPI_Comm communicator)
{
  const PlainType type(width * sizeof(double));
  std::vector<MPI_Request> requests;
  for (int r = 0; r < size_of(communicator); ++r)
    if (const int n = receive_begin[r + 1] - receive_begin[r]; n > 0)
      MPI_Irecv(receive + width * receive_begin[r], n, type.get(), r, tag_of_known_parts, communicator,
                &requests.emplace_back());
  for (int r = 0; r < size_of(communicator); ++r)
    if (const int n = send_begin[r + 1] - send_begin[r]; n > 0)
      MPI_Isend(send + width * send_begin[r], n, type.get(), r, tag_of_known_parts, communicator,
                &requests.emplace_back());
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

/// Joins the contributions of all ranks, in their order, on every rank. For a few entries per rank. Collective; T must
/// be trivially copyable.
template <typename T> std::vector<T> gather_everywhere(const std::vector<T>& mine, const MPI_Comm communicator)
{
  static_assert(std::is_trivially_copyable<T>::value, "only plain data can be sent");
  std::vector<int> count(size_of(communicator));
  const int n_mine = message_length(mine.size());
  MPI_Allgather(&n_mine, 1, MPI_INT, count.data(), 1, MPI_INT, communicator);
  const std::vector<int> begin = begin_of_parts(count);
  std::vector<T> all(begin.back());
  const PlainType type(sizeof(T));
  MPI_Allgatherv(mine.data(), n_mine, type.get(), all.data(), count.data(), begin.data(), type.get(), communicator);
  return all;
}
} // namespace kedge
