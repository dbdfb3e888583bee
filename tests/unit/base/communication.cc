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
