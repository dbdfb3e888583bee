#include <gtest/gtest.h>
#include <kedge/output/schedule.h>
#include <vector>

namespace kedge
{
namespace
{
using Steps = std::vector<unsigned int>;

/// The converged steps, from 1, that are written in a stage of `n_steps`, each of which is made in `n_parts`.
Steps written(double percent, unsigned int n_steps, unsigned int n_parts = 1)
{
  OutputSchedule schedule(percent);
  schedule.begin_stage(n_steps);
  Steps due;
  for (unsigned int step = 1; step <= n_steps * n_parts; ++step)
    if (schedule.due({(step - 1.) / n_parts, double(step) / n_parts}, step == n_steps * n_parts))
      due.push_back(step);
  return due;
}

TEST(Schedule, ZeroPercentIsEveryStep) { EXPECT_EQ(written(0., 4), Steps({1, 2, 3, 4})); }

TEST(Schedule, ShareOfTheStage) { EXPECT_EQ(written(25., 8), Steps({2, 4, 6, 8})); }

TEST(Schedule, ShareBelowOneStepIsEveryStep) { EXPECT_EQ(written(1., 5), Steps({1, 2, 3, 4, 5})); }

TEST(Schedule, IntervalIsRounded)
{
  EXPECT_EQ(written(24., 10), Steps({2, 4, 6, 8, 10}));
  EXPECT_EQ(written(26., 10), Steps({3, 6, 9, 10}));
}

TEST(Schedule, LastStepIsAlwaysWritten) { EXPECT_EQ(written(30., 10), Steps({3, 6, 9, 10})); }

TEST(Schedule, HundredPercentIsTheEnd) { EXPECT_EQ(written(100., 10), Steps({10})); }

TEST(Schedule, PartsOfStepsChangeNothing)
{
  EXPECT_EQ(written(25., 8, 4), Steps({8, 16, 24, 32}));
  EXPECT_EQ(written(0., 2, 2), Steps({1, 2, 3, 4}));
}

TEST(Schedule, PartsMayDifferFromStepToStep)
{
  OutputSchedule schedule(20.); // every second step
  schedule.begin_stage(10);
  EXPECT_FALSE(schedule.due({0., 1.}, false));
  EXPECT_FALSE(schedule.due({1., 1.75}, false));
  EXPECT_TRUE(schedule.due({1.75, 2.}, false));
  EXPECT_FALSE(schedule.due({2., 2.5}, false));
}

TEST(Schedule, EveryStageHasItsInterval)
{
  OutputSchedule schedule(50.);
  schedule.begin_stage(4);
  EXPECT_TRUE(schedule.due({1., 2.}, false));
  schedule.begin_stage(8);
  EXPECT_FALSE(schedule.due({1., 2.}, false));
  EXPECT_TRUE(schedule.due({3., 4.}, false));
}
} // namespace
} // namespace kedge
