#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/report.h>
#include <thread>

using namespace kedge;

namespace
{
ProgressLine halfway()
{
  ProgressLine state;
  state.stage = 2;
  state.n_stages = 3;
  state.time = 0.5;
  state.step = 17;
  state.increment = 0.0125;
  state.iterations = 4;
  state.krylov_iterations = 31;
  state.cuts = 1;
  state.deleted = 2;
  state.particles = 1000;
  return state;
}

/// Text that a report prints if it speaks on this rank.
template <typename Action> std::string printed(const bool quiet, const Action& action)
{
  testing::internal::CaptureStdout();
  Report report(true, quiet);
  action(report);
  return testing::internal::GetCapturedStdout();
}
} // namespace

TEST(ProgressLine, ShowsStageBarTimeAndCounts)
{
  EXPECT_EQ(format_progress(halfway()),
            "stage 2/3 ██████░░░░░░  50.0% t 0.5/1 step 17 Δt 0.0125 NR 4 cuts 1 del 2 N 1000 "
            "Krylov 31");
}

TEST(ProgressLine, StopsAtAHundredPercent)
{
  ProgressLine state = halfway();
  state.time = 1.5;
  EXPECT_NE(format_progress(state).find("████████████ 100.0%"), std::string::npos);
}

TEST(Report, AFileGetsTheFirstAndTheLastStepOfAStage)
{
  const std::string text = printed(false,
                                   [](Report& report)
                                   {
                                     ProgressLine state = halfway();
                                     for (const double time : {0.5, 0.6, 0.7, 0.8})
                                     {
                                       state.time = time;
                                       report.progress(state);
                                     }
                                     report.end_progress();
                                     report.end_progress();
                                   });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
  EXPECT_LT(text.find(" 50.0%"), text.find('\n'));
  EXPECT_GT(text.find(" 80.0%"), text.find('\n'));
  EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST(Report, AFileGetsALinePerInterval)
{
  testing::internal::CaptureStdout();
  Report report(true, false, 0.05);
  report.progress(halfway());
  report.progress(halfway());
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  report.progress(halfway());
  report.end_progress();
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
}

TEST(Report, OtherTextDoesNotBringMoreLinesOfProgress)
{
  const std::string text = printed(false,
                                   [](Report& report)
                                   {
                                     report.progress(halfway());
                                     report.progress(halfway());
                                     report.line("a line");
                                   });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
  EXPECT_EQ(text.substr(text.size() - 7), "a line\n");
}

TEST(Report, StartsAnewWithEachStage)
{
  const std::string text = printed(false,
                                   [](Report& report)
                                   {
                                     ProgressLine state = halfway();
                                     report.progress(state);
                                     state.stage = 3;
                                     report.progress(state);
                                   });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
}

TEST(Report, QuietMeansWarningsOnly)
{
  const std::string text = printed(true,
                                   [](Report& report)
                                   {
                                     report.line("a line");
                                     report.progress(halfway());
                                     testing::internal::CaptureStderr();
                                     report.warn("look out");
                                     EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: look out\n");
                                     EXPECT_EQ(report.warnings(), std::vector<std::string>{"look out"});
                                   });
  EXPECT_EQ(text, "");
}

TEST(Report, OtherRanksSayNothingButRememberWarnings)
{
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Report report(false, false);
  report.line("a line");
  report.progress(halfway());
  report.warn("look out");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(report.warnings().size(), 1u);
}

TEST(Timings, AddUpByPhase)
{
  Timings timings;
  for (unsigned int n = 0; n < 2; ++n)
  {
    const auto scope = timings.measure("sleep");
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  ASSERT_EQ(timings.seconds().count("sleep"), 1u);
  EXPECT_GE(timings.seconds().at("sleep"), 4e-3);
}

TEST(Errors, SayWhereWhatAndTheRemedy)
{
  const InputError error("solver.tolerance", "expected a number above 0", "give 1e-6");
  EXPECT_STREQ(error.what(), "solver.tolerance: expected a number above 0; give 1e-6");
  EXPECT_EQ(error.path, "solver.tolerance");
  EXPECT_STREQ(FileError("a.vtu", "no room left").what(), "a.vtu: no room left");
  EXPECT_EQ(SolverError("stuck", {1., 0.5}).residual_history, (std::vector<double>{1., 0.5}));
}
