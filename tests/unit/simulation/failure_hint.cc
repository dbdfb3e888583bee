// A failed step names a cause that fits it.
#include "input_files.h"
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/simulation/failure_hint.h>

using namespace kedge;

namespace
{
const Input& input()
{
  static const Input read = read_input((input_files::root() / "prm/strip-footing.json").string());
  return read;
}

NewtonReport failed(const std::string& why)
{
  NewtonReport report;
  report.failure = why;
  report.iterations = 5;
  report.residuals = {1., 0.5};
  return report;
}

ResidualPlace in_yielding_soil()
{
  ResidualPlace place;
  place.position = {1., 2.};
  place.cell_size = 0.1;
  place.share = 0.3;
  place.gap = INFINITY;
  place.filled = place.yielding = 1.;
  return place;
}

std::string hint(const ResidualPlace& place, const std::string& why = "no progress in 24 iterations")
{
  return hint_for(failed(why), place, input().stages.front(), input());
}
} // namespace

TEST(FailureHint, FollowsTheCause)
{
  EXPECT_NE(hint({}, "contacts still penetrate after 20 rounds").find("penetration tolerance"), std::string::npos);
  EXPECT_NE(hint({}, "the linear system could not be solved").find("singular"), std::string::npos);
  EXPECT_NE(hint({}, "the linear system could not be solved").find("direct"), std::string::npos);
  Input direct = input();
  direct.solver.linear_solver = LinearSolverChoice::direct;
  const NewtonReport failure = failed("the linear system could not be solved");
  EXPECT_EQ(hint_for(failure, {}, direct.stages.front(), direct).find("direct"), std::string::npos);
  EXPECT_NE(hint({}, "the residual is not finite").find("inside out"), std::string::npos);
}

TEST(FailureHint, FollowsThePlace)
{
  ResidualPlace place = in_yielding_soil();
  EXPECT_NE(hint(place).find("soil that yields"), std::string::npos) << hint(place);
  place.unstressed = 0.8;
  EXPECT_NE(hint(place).find("cohesion"), std::string::npos) << hint(place);
  place.gap = 0.05;
  EXPECT_NE(hint(place).find("at a body"), std::string::npos) << hint(place);
  place.bodies_dominate = true;
  EXPECT_NE(hint(place).find("free body"), std::string::npos) << hint(place);
}

TEST(FailureHint, SaysWhereTheResidualIs)
{
  ResidualPlace place = in_yielding_soil();
  const std::string text = describe_place(place);
  for (const char* part : {"0.3 of the forces", "(1, 2)", "0.1 m", "away from all bodies", "soil that yields"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  place.filled = 0.3;
  EXPECT_NE(describe_place(place).find("edge of the soil"), std::string::npos);
  EXPECT_EQ(describe_place({}), "");
}
