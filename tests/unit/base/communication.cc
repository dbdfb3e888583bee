#include <gtest/gtest.h>
#include <kedge/base/communication.h>

using namespace kedge;

namespace
{
const MPI_Comm world = MPI_COMM_WORLD;

struct Parcel
{
  int from, to;
  double content;
};
} // namespace

TEST(ExchangeBetweenRanks, DeliversEachParcelToItsRank)
{
  // Rank r sends r + s + 1 parcels to rank s.
  const int rank = rank_of(world), size = size_of(world);
  std::vector<std::vector<Parcel>> out(size);
  for (int to = 0; to < size; ++to)
    for (int n = 0; n <= rank + to; ++n)
      out[to].push_back({rank, to, 100. * rank + 10. * to + n});
  const auto in = exchange_between_ranks(out, world);
  ASSERT_EQ(in.size(), std::size_t(size));
  for (int from = 0; from < size; ++from)
  {
    ASSERT_EQ(in[from].size(), std::size_t(from + rank + 1));
    for (std::size_t n = 0; n < in[from].size(); ++n)
    {
      EXPECT_EQ(in[from][n].from, from);
      EXPECT_EQ(in[from][n].to, rank);
      EXPECT_EQ(in[from][n].content, 100. * from + 10. * rank + double(n));
    }
  }
}

TEST(ExchangeBetweenRanks, DeliversNothingIfNothingWasSent)
{
  std::vector<std::vector<char>> out(size_of(world));
  if (rank_of(world) == 0)
    out.back() = {'a', 'b', 'c'};
  const auto in = exchange_between_ranks(out, world);
  std::size_t count = 0;
  for (const auto& part : in)
    count += part.size();
  EXPECT_EQ(count, rank_of(world) == size_of(world) - 1 ? 3u : 0u);
}

TEST(ExchangeBetweenRanks, KeepsOneExchangeApartFromTheNext)
{
  // Few messages, so that no rank waits for another unless the exchange makes it wait.
  const int rank = rank_of(world), size = size_of(world);
  for (int round = 0; round < 300; ++round)
  {
    const int from = round % size, to = (round / size) % size;
    std::vector<std::vector<int>> out(size);
    if (rank == from)
      out[to] = {round};
    const auto in = exchange_between_ranks(out, world);
    for (int r = 0; r < size; ++r)
      ASSERT_EQ(in[r], rank == to && r == from ? std::vector<int>{round} : std::vector<int>{});
  }
}

TEST(ExchangeBetweenRanks, CountsEachCommunicatorApart)
{
  // Some ranks exchange more often than others, among themselves.
  const int rank = rank_of(world), size = size_of(world);
  MPI_Comm lower = MPI_COMM_NULL;
  MPI_Comm_split(world, rank < 2 ? 0 : 1, rank, &lower);
  std::vector<std::vector<int>> out(size_of(lower));
  out.back() = {rank};
  exchange_between_ranks(out, lower);
  std::vector<std::vector<int>> everywhere(size, {rank});
  const auto in = exchange_between_ranks(everywhere, world);
  for (int r = 0; r < size; ++r)
    EXPECT_EQ(in[r], std::vector<int>{r});
  MPI_Comm_free(&lower);
}

TEST(ExchangeKnownParts, DeliversEachPartToItsPlace)
{
  // Rank r sends s entries of two numbers to rank s, so rank 0 gets nothing.
  constexpr int width = 2;
  const int rank = rank_of(world), size = size_of(world);
  std::vector<int> send_begin{0}, receive_begin{0};
  std::vector<double> out;
  for (int r = 0; r < size; ++r)
  {
    send_begin.push_back(send_begin.back() + r);
    receive_begin.push_back(receive_begin.back() + rank);
    for (int n = 0; n < width * r; ++n)
      out.push_back(100. * rank + 10. * r + n);
  }
  std::vector<double> in(width * receive_begin.back());
  exchange_known_parts(out.data(), send_begin, in.data(), receive_begin, width, world);
  for (int r = 0; r < size; ++r)
    for (int n = 0; n < width * rank; ++n)
      EXPECT_EQ(in[width * receive_begin[r] + n], 100. * r + 10. * rank + n);
}

TEST(GatherEverywhere, JoinsInRankOrder)
{
  const std::vector<long long> mine(rank_of(world) + 1, rank_of(world));
  std::vector<long long> expected;
  for (long long r = 0; r < size_of(world); ++r)
    expected.insert(expected.end(), r + 1, r);
  EXPECT_EQ(gather_everywhere(mine, world), expected);
}

TEST(Reductions, SumAndExtremes)
{
  const double rank = rank_of(world), size = size_of(world);
  EXPECT_EQ(sum_over_ranks(rank + 1., world), 0.5 * size * (size + 1.));
  EXPECT_EQ(sum_over_ranks(2LL, world), 2 * size_of(world));
  EXPECT_EQ(max_over_ranks(rank, world), size - 1.);
  EXPECT_EQ(min_over_ranks(rank - 5., world), -5.);
}

TEST(Reductions, SumOverLowerRanks)
{
  // 1 + 2 + ... + rank
  const long long rank = rank_of(world);
  EXPECT_EQ(sum_over_lower_ranks(rank + 1, world), rank * (rank + 1) / 2);
}
