// What a scene costs, told before it runs.
#include "input_files.h"
#include <gtest/gtest.h>
#include <kedge/simulation/estimate.h>

using namespace kedge;

namespace
{
std::vector<StageEstimate> estimate(const std::string& scene, const std::vector<std::string>& overrides = {},
                                    const double most_particles = 1e6)
{
  return estimate_cost(read_input((input_files::root() / "prm" / scene).string(), overrides), most_particles);
}
} // namespace

TEST(Estimate, CountsBaseCellsFromTheirSizes)
{
  const StageEstimate stage = estimate("cube.json").front();
  EXPECT_EQ(stage.cells, 8.);
  EXPECT_EQ(stage.dofs, 3. * 27.);
  EXPECT_EQ(stage.particles, 8. * 8.);
}

TEST(Estimate, CountsTheCellsThatABodyRefines)
{
  // From below: base cells, cells of 0.2 m and two layers of 0.1 m. Those at 0.6 and 0.8 m hang on coarser ones.
  const StageEstimate stage = estimate("cube-octree.json").front();
  EXPECT_EQ(stage.cells, 4. + 16. + 2. * 64.);
  EXPECT_EQ(stage.dofs, 3. * (9. + 9. + 25. + 81. + 25.));
  EXPECT_EQ(stage.particles, 8. * stage.cells);
}

TEST(Estimate, MovesBodiesBetweenStages)
{
  // The platen starts the second stage at z = 0.6: all above 0.4 is fine, all below has half the base size.
  const std::string stage = R"({"type": "static", "load steps": 20, "load": "full", "rigid bodies": "on",
    "adaptivity": {"type": "rigid body surface", "element size": 0.1}})";
  const auto stages = estimate("cube-octree.json", {"analysis=[" + stage + ", " + stage + "]"});
  EXPECT_EQ(stages[1].cells, 32. + 4. * 64.);
}

TEST(Estimate, LeavesOutBuriedMaterialPoints)
{
  // 20 mm cells, so that the half of the plate, 10 x 50 x 100 mm, holds 1 x 5 x 10 centres
  const StageEstimate stage =
      estimate("plate-anchor-quick.json",
               {R"(analysis.0.adaptivity={"type": "rigid body surface", "element size": 0.02})"})
          .front();
  EXPECT_EQ(stage.particles, 19200. - 50.);
}

TEST(Estimate, CountsTimeStepsOfExplicitStages)
{
  const auto seconds = [](const std::vector<std::string>& changes)
  { return estimate("plate-anchor-explicit.json", changes).front().seconds; };
  const double whole = seconds({});
  EXPECT_NEAR(seconds({"analysis.0.final time=1.25"}), 0.5 * whole, 1e-9 * whole);
  EXPECT_NEAR(seconds({"analysis.0.mass scaling=64"}), 0.5 * whole, 1e-9 * whole);
  EXPECT_NEAR(seconds({"analysis.0.dt=1e-4"}),
              25000. * 0.6e-6 * estimate("plate-anchor-explicit.json").front().particles, 1e-9 * whole);
}

TEST(Estimate, StopsCountingBetweenTwoLevels)
{
  const StageEstimate stage = estimate("cube-octree.json", {"analysis.0.adaptivity.element size=0.05"}, 1200.).front();
  EXPECT_TRUE(stage.counting_stopped);
  EXPECT_EQ(stage.particles, 8. * (4. + 16. + 2. * 64.)); // those of 0.1 m
}

TEST(Estimate, TellsOfStagesThatItCouldNotCount)
{
  const Input input = read_input((input_files::root() / "prm" / "cube-octree.json").string());
  EXPECT_EQ(format_estimate(input, estimate_cost(input)).find("too many"), std::string::npos);
  EXPECT_NE(format_estimate(input, estimate_cost(input, 1.)).find("too many"), std::string::npos);
}
