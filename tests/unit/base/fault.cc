#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/report.h>

namespace kedge
{
namespace
{
TEST(PlannedFault, StrikesInItsStepAndPhaseAlone)
{
  Timings timings(planned_fault("rank=1,step=3,phase=linear solver,kind=solver", 1));
  EXPECT_NO_THROW(timings.measure("linear solver"));
  timings.begin_step(3);
  EXPECT_NO_THROW(timings.measure("basis"));
  EXPECT_THROW(timings.measure("linear solver"), SolverError);
  EXPECT_THROW(timings.reach("linear solver"), SolverError);
  EXPECT_EQ(timings.seconds().count("linear solver"), 1u); // of the first time alone
}

TEST(PlannedFault, KindsAreThoseOfErrors)
{
  const auto strike = [](const std::string& kind)
  { planned_fault(("rank=0,step=1,phase=basis,kind=" + kind).c_str(), 0)->strike_at("basis"); };
  EXPECT_THROW(strike("input"), InputError);
  EXPECT_THROW(strike("solver"), SolverError);
  EXPECT_THROW(strike("file"), FileError);
  EXPECT_THROW(strike("bad_alloc"), std::bad_alloc);
  EXPECT_THROW(strike("logic"), std::logic_error);
}

TEST(PlannedFault, IsForItsRankOrForAll)
{
  EXPECT_FALSE(planned_fault(nullptr, 0));
  EXPECT_FALSE(planned_fault("rank=1,step=2,phase=basis,kind=solver", 0));
  EXPECT_TRUE(planned_fault("step=2,phase=basis,kind=solver", 0));
  EXPECT_TRUE(planned_fault("step=2,phase=basis,kind=solver", 1));
}

TEST(PlannedFault, NonsenseIsRefused)
{
  for (const char* const text : {"", "rank=0", "rank=x,step=2,phase=basis,kind=solver", "step=2,phase=basis,kind=bug"})
    EXPECT_THROW(planned_fault(text, 0), InputError) << text;
}
} // namespace
} // namespace kedge
