#include <gtest/gtest.h>
#include <kedge/time/clock.h>
#include <random>
#include <vector>

using namespace kedge;

TEST(Clock, MakesTheRequestedStepsIfNothingFails)
{
  Clock clock(7, 1. / 4096.);
  unsigned int steps = 0;
  for (; !clock.at_end(); clock.advance(), ++steps)
  {
    EXPECT_EQ(clock.step_fraction(), 1.);
    EXPECT_EQ(clock.steps_done(), steps);
    EXPECT_EQ(clock.steps_after(), steps + 1.);
  }
  EXPECT_EQ(steps, 7u);
  EXPECT_EQ(clock.requested_steps(), 7.);
  EXPECT_EQ(clock.cuts(), 0u);
}

TEST(Clock, KeepsStepsBelowALimit)
{
  Clock clock(2, 1. / 4096.);
  EXPECT_TRUE(clock.keep_below(0.3)); // 1/4
  unsigned int steps = 0;
  for (; !clock.at_end(); clock.advance(), ++steps)
    EXPECT_EQ(clock.step_fraction(), 0.25);
  EXPECT_EQ(steps, 8u);
  EXPECT_EQ(clock.cuts(), 0u);
}

TEST(Clock, GrowsBackToTheLimitAfterACut)
{
  Clock clock(2, 1. / 4096.);
  clock.keep_below(0.25);
  clock.cut();
  EXPECT_EQ(clock.step_fraction(), 0.125);
  clock.advance();
  clock.advance();
  for (; !clock.at_end(); clock.advance())
    EXPECT_LE(clock.step_fraction(), 0.25);
  EXPECT_EQ(clock.steps_done(), 2.);
}

TEST(Clock, SaysThatALimitIsBelowTheSmallestStep)
{
  Clock clock(2, 1. / 8.);
  EXPECT_FALSE(clock.keep_below(0.1));
  EXPECT_EQ(clock.step_fraction(), 0.125);
  EXPECT_TRUE(Clock(2, 1. / 8.).keep_below(0.125));
}

TEST(Clock, HalvesAFailedStep)
{
  Clock clock(2, 1. / 4096.);
  EXPECT_TRUE(clock.cut());
  EXPECT_EQ(clock.step_fraction(), 0.5);
  EXPECT_EQ(clock.steps_done(), 0.);
  EXPECT_EQ(clock.steps_after(), 0.5);
  EXPECT_EQ(clock.cuts(), 1u);
}

TEST(Clock, DoublesAfterASuccessUpToTheRequestedSize)
{
  Clock clock(2, 1. / 4096.);
  clock.cut();
  clock.cut();
  clock.cut(); // 1/8
  clock.advance();
  EXPECT_EQ(clock.step_fraction(), 0.25);
  clock.advance(); // at 3/8
  EXPECT_EQ(clock.step_fraction(), 0.5);
  clock.advance(); // at 7/8
  EXPECT_EQ(clock.step_fraction(), 0.125);
}

TEST(Clock, WaitsLongerIfTheLargerStepFailsAgain)
{
  Clock clock(100, 1. / 4096.);
  std::vector<double> failed_at;
  while (!clock.at_end())
    if (clock.step_fraction() < 1.)
      clock.advance();
    else
    {
      failed_at.push_back(clock.steps_done());
      ASSERT_TRUE(clock.cut());
    }
  ASSERT_GE(failed_at.size(), 4u);
  EXPECT_EQ(failed_at[1], 1.);
  EXPECT_EQ(failed_at[2], 3.); // four halves
  EXPECT_EQ(failed_at[3], 11.);
  EXPECT_EQ(failed_at.back() - failed_at[failed_at.size() - 2], 8.); // the patience grows no more
  EXPECT_EQ(failed_at.size(), clock.cuts());
}

TEST(Clock, ResetsItsPatienceWhenALargerStepSucceeds)
{
  Clock clock(100, 1. / 4096.);
  const auto advance_to = [&](const double position)
  {
    while (clock.steps_done() < position)
      clock.advance();
  };
  clock.cut();
  advance_to(1.);
  clock.cut(); // fails again: four halves follow
  advance_to(4.);
  clock.cut();
  advance_to(5.);
  EXPECT_EQ(clock.step_fraction(), 1.);
}

TEST(Clock, NeverStepsAcrossARequestedStep)
{
  std::mt19937 generator(1);
  Clock clock(50, 1. / 64.);
  while (!clock.at_end())
  {
    EXPECT_LE(clock.steps_after(), std::floor(clock.steps_done()) + 1.);
    if (generator() % 3 > 0 || !clock.cut())
      clock.advance();
  }
}

TEST(Clock, StopsAtTheSmallestStep)
{
  Clock clock(1, 1. / 16.);
  for (unsigned int n = 0; n < 4; ++n)
    EXPECT_TRUE(clock.cut());
  EXPECT_FALSE(clock.cut());
  EXPECT_EQ(clock.step_fraction(), 1. / 16.);
  EXPECT_EQ(clock.cuts(), 4u);
}

TEST(Clock, RoundsTheSmallestStepDownToAPowerOfTwo)
{
  Clock clock(1, 0.1);
  while (clock.cut())
    ;
  EXPECT_EQ(clock.step_fraction(), 1. / 16.);
}

TEST(Clock, DoesNotCutAtAllIfTheWholeStepIsTheSmallest)
{
  Clock clock(3, 1.);
  EXPECT_FALSE(clock.cut());
  clock.advance();
  EXPECT_EQ(clock.steps_done(), 1.);
}

TEST(Clock, EndsExactlyAfterAnyCuts)
{
  for (unsigned int seed = 0; seed < 100; ++seed)
  {
    std::mt19937 generator(seed);
    Clock clock(1 + seed % 13, 1. / 4096.);
    while (!clock.at_end())
      if (generator() % 2 == 0 || !clock.cut())
        clock.advance();
    ASSERT_EQ(clock.steps_done(), double(clock.requested_steps())) << "seed " << seed;
  }
}

TEST(Clock, EndsWithAnIncompleteStepWhateverTheSmallestStep)
{
  for (const double smallest : {1., 0.25, 1. / 4096.})
    for (const double n_steps : {0.3, 10. / 7., 2.9998, 5.5})
      for (unsigned int seed = 0; seed < 20; ++seed)
      {
        std::mt19937 generator(seed);
        Clock clock(n_steps, smallest);
        while (!clock.at_end())
          if (seed > 0 && generator() % 2 == 0 && clock.cut())
            EXPECT_GE(clock.step_fraction(), 0.5 * std::min(smallest, n_steps - std::floor(n_steps)));
          else
            clock.advance();
        ASSERT_NEAR(clock.steps_done(), n_steps, 1e-12) << "seed " << seed;
      }
}

TEST(Clock, LeavesNoStepThatIsTooShort)
{
  Clock clock(1.3, 0.25);
  clock.cut();
  clock.cut();
  for (unsigned int step = 0; step < 4; ++step, clock.advance())
    EXPECT_LE(clock.step_fraction(), 0.5);
  while (!clock.at_end())
  {
    EXPECT_GT(clock.step_fraction(), 0.14);
    clock.advance();
  }
}

TEST(Clock, ResumesWhereAnotherStopped)
{
  Clock clock(3, 1. / 4096.);
  clock.advance();
  clock.cut();
  clock.cut();
  clock.advance(); // the next step is half a requested one
  clock.cut();     // which fails
  clock.advance();
  Clock resumed(3, 1. / 4096.);
  resumed.resume(clock.state());
  for (; !clock.at_end(); clock.advance(), resumed.advance())
  {
    EXPECT_EQ(resumed.steps_done(), clock.steps_done());
    EXPECT_EQ(resumed.step_fraction(), clock.step_fraction());
  }
  EXPECT_TRUE(resumed.at_end());
  EXPECT_EQ(resumed.cuts(), 3u);
}

TEST(Clock, ContinuesBeyondTheEndOfAShorterStage)
{
  Clock shorter(2.5, 1. / 4096.);
  while (!shorter.at_end())
    shorter.advance();
  Clock longer(4, 1. / 4096.);
  longer.resume(shorter.state());
  EXPECT_EQ(longer.steps_done(), 2.5);
  EXPECT_EQ(longer.step_fraction(), 0.5); // to the end of the requested step
  longer.advance();
  EXPECT_EQ(longer.steps_done(), 3.);
  EXPECT_EQ(longer.step_fraction(), 1.);
  longer.advance();
  EXPECT_TRUE(longer.at_end());
}

TEST(Clock, ContinuesWithAnotherSmallestStep)
{
  for (const double fraction : {1. / 64., 1. / 4096., 1. / 65536.})
  {
    Clock clock(10, 1. / 4096.);
    clock.advance();
    clock.cut();
    clock.cut();
    clock.advance(); // at 1.25, the next step is half a requested one
    Clock resumed(10, fraction);
    resumed.resume(clock.state());
    EXPECT_EQ(resumed.steps_done(), 1.25);
    EXPECT_EQ(resumed.requested_steps(), 10.);
    EXPECT_EQ(resumed.step_fraction(), 0.5);
    while (resumed.cut())
      ;
    EXPECT_EQ(resumed.step_fraction(), fraction);
    while (!resumed.at_end())
      resumed.advance();
    EXPECT_EQ(resumed.steps_done(), 10.);
  }
}
