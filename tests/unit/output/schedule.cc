#include <gtest/gtest.h>
#include <kedge/output/schedule.h>
#include <vector>

namespace kedge
{
namespace
{
using Steps = std::vector<unsigned int>;

/// The steps that are written in a stage of `n_steps` that takes `n_taken` converged steps, because of cuts.
Steps written(double percent, unsigned int n_steps, unsigned int n_taken)
{
  OutputSchedule schedule(percent);
  schedule.begin_stage(n_steps);
  Steps due;
  for (unsigned int step = 1; step <= n_taken; ++step)
    if (schedule.due(step, step == n_taken))
      due.push_back(step);
  return due;
}

TEST(Schedule, ZeroPercentIsEveryStep) { EXPECT_EQ(written(0., 4, 4), Steps({1, 2, 3, 4})); }

TEST(Schedule, ShareOfTheStage) { EXPECT_EQ(written(25., 8, 8), Steps({2, 4, 6, 8})); }

TEST(Schedule, ShareBelowOneStepIsEveryStep) { EXPECT_EQ(written(1., 5, 5), Steps({1, 2, 3, 4, 5})); }

TEST(Schedule, IntervalIsRounded)
{
  EXPECT_EQ(written(24., 10, 10), Steps({2, 4, 6, 8, 10}));
  EXPECT_EQ(written(26., 10, 10), Steps({3, 6, 9, 10}));
}

TEST(Schedule, LastStepIsAlwaysWritten) { EXPECT_EQ(written(30., 10, 11), Steps({3, 6, 9, 11})); }

TEST(Schedule, HundredPercentIsTheEnd) { EXPECT_EQ(written(100., 10, 10), Steps({10})); }

TEST(Schedule, EveryStageHasItsInterval)
{
  OutputSchedule schedule(50.);
  schedule.begin_stage(4);
  EXPECT_TRUE(schedule.due(2, false));
  schedule.begin_stage(8);
  EXPECT_FALSE(schedule.due(2, false));
  EXPECT_TRUE(schedule.due(4, false));
}
} // namespace
} // namespace kedge
