// Warnings about what an input hardly means.
#include "input_files.h"
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/simulation/scene_warnings.h>

using namespace kedge;

namespace
{
std::vector<std::string> warnings(const std::string& scene, const std::vector<std::string>& overrides = {})
{
  const Input input = read_input((input_files::root() / "prm" / scene).string(), overrides);
  return find_warnings(input, make_rigid_systems(input.systems, input.dimension));
}

/// That there is one, and that it says `words`.
void expect_warning(const std::vector<std::string>& found, const std::string& words)
{
  ASSERT_EQ(found.size(), 1u) << testing::PrintToString(found);
  EXPECT_NE(found[0].find(words), std::string::npos) << found[0];
}
} // namespace

TEST(Warnings, NoneAboutScenesThatMeanWhatTheySay)
{
  for (const char* scene : {"plate-anchor-ts.json", "strip-footing.json", "cube-octree.json", "column.json",
                            "drag-anchor-quick.json", "plate-anchor-explicit.json"})
    EXPECT_EQ(warnings(scene), std::vector<std::string>()) << scene;
}

TEST(Warnings, EdgesSharperThanHalfAMaterialPoint)
{
  expect_warning(warnings("plate-anchor-ts.json", {R"(analysis.0.adaptivity={"type": "uniform"})"}),
                 "surface 1 has convex edges");
  expect_warning(warnings("strip-footing.json", {R"(analysis.0.adaptivity={"type": "uniform"})"}),
                 "surface 1 has convex edges");
}

TEST(Warnings, NoneAboutSharpEdgesThatTheInputAccepts)
{
  EXPECT_EQ(warnings("plate-anchor-ts.json", {R"(analysis.0.adaptivity={"type": "uniform"})",
                                              R"(rigid bodies.0.stl files.0.warn of sharp edges="off")"}),
            std::vector<std::string>());
  EXPECT_EQ(warnings("strip-footing.json", {R"(analysis.0.adaptivity={"type": "uniform"})",
                                            R"(rigid bodies.0.outline.0.warn of sharp edges="off")"}),
            std::vector<std::string>());
}

TEST(Warnings, AdhesionThatIsNeverReached)
{
  const std::string adhesive = "contact={\"friction coefficient\": 0, \"adhesion\": 1000";
  expect_warning(warnings("strip-footing.json", {adhesive + "}"}), "the adhesion of surface 1 has no effect");
  EXPECT_EQ(warnings("strip-footing.json", {adhesive + ", \"tangential limit\": \"sum\"}"}),
            std::vector<std::string>());
  EXPECT_EQ(warnings("strip-footing.json", {adhesive + ", \"bonded\": \"on\"}"}), std::vector<std::string>());
}

TEST(Warnings, RodsOfAnotherLengthThanTheyAreDrawnWith)
{
  expect_warning(warnings("drag-anchor-quick.json", {"rigid bodies.0.constraints.2.distance=8"}),
                 "rigid bodies[0].constraints[2]: its ends are 9.5");
}

TEST(Warnings, HingesWhoseAxesAreNotParallel)
{
  expect_warning(warnings("drag-anchor-quick.json", {"rigid bodies.0.constraints.0.direction 2=[0, 1, 0.1]"}),
                 "rigid bodies[0].constraints[0]: \"direction 1\" and \"direction 2\" are 5.71 degrees apart");
  EXPECT_EQ(warnings("drag-anchor-quick.json", {"rigid bodies.0.constraints.0.direction 2=[0, -2, 0]"}),
            std::vector<std::string>()); // the axis is the same
}

TEST(Warnings, BodiesBesideTheGrid)
{
  expect_warning(warnings("plate-anchor-ts.json", {"rigid bodies.0.offset=[5, 0, 0]"}),
                 "surface 1 begins beside the grid");
  expect_warning(warnings("strip-footing.json", {"rigid bodies.0.offset=[5, 0]"}), "surface 1 begins beside the grid");
  EXPECT_EQ(warnings("plate-anchor-ts.json", {"rigid bodies.0.offset=[0, 0, 5]"}), std::vector<std::string>());
}

TEST(Warnings, BodiesThatBeginInTheSoil)
{
  const std::string wished = "analysis.0.wished in place=";
  expect_warning(warnings("plate-anchor-ts.json", {wished + "off"}), "surface 1 begins in the soil");
  EXPECT_EQ(warnings("plate-anchor-ts.json", {wished + "off", "rigid bodies.0.offset=[0, 0, 5]"}),
            std::vector<std::string>());
  expect_warning(warnings("strip-footing.json", {"rigid bodies.0.offset=[0, -0.1]"}), "surface 1 begins in the soil");
}

TEST(Warnings, BodiesThatAreOnAgainAfterAStageWithoutThem)
{
  Input input = read_input((input_files::root() / "prm/strip-footing.json").string(), {});
  const Stage with_bodies = input.stages[0];
  Stage without = with_bodies;
  without.rigid_bodies = false;
  const auto found = [&] { return find_warnings(input, make_rigid_systems(input.systems, input.dimension)); };
  input.stages = {with_bodies, without, with_bodies};
  expect_warning(found(), "stage 3 has the bodies \"on\" again");
  input.stages = {without, with_bodies, with_bodies};
  EXPECT_EQ(found(), std::vector<std::string>());
}

TEST(Warnings, FineBoxesOutsideTheGrid)
{
  const auto with_box = [](const std::string& box)
  {
    return std::vector<std::string>{
        R"(analysis.0.adaptivity={"type": "rigid body surface", "element size": 0.005, "boxes": [)" + box + "]}"};
  };
  expect_warning(
      warnings("plate-anchor-ts.json", with_box(R"({"min": [0, 0, 2], "max": [1, 0.2, 3], "element size": 0.01})")),
      "a box of fine cells in stage 1");
  EXPECT_EQ(
      warnings("plate-anchor-ts.json", with_box(R"({"min": [-1, 0, 0.1], "max": [1, 0.2, 3], "element size": 0.01})")),
      std::vector<std::string>());
}

TEST(Warnings, BaseCellsThatAreSmallerThanAskedFor)
{
  expect_warning(warnings("plate-anchor-ts.json",
                          {R"(analysis.0.adaptivity={"type": "rigid body surface", "element size": 0.006})"}),
                 "base cells are 0.024 m instead of the 0.04 m requested");
}

TEST(Warnings, InitialStressBeyondTheYieldSurface)
{
  // friction of 35.5 degrees: 0.265 at the active limit, 3.77 at the passive one
  const auto with = [](const std::string& K0)
  { return warnings("plate-anchor-ts.json", {"material points.initial stress.K0=" + K0}); };
  EXPECT_EQ(with("0.266"), std::vector<std::string>());
  EXPECT_EQ(with("3.7"), std::vector<std::string>());
  expect_warning(with("0.2"), "layer 1 does not bear the initial stress with \"K0\" = 0.2 from a depth of 0.01 m on");
  expect_warning(with("0.2"), "bears 0.265");
  expect_warning(with("5"), "bears 3.77");
}

TEST(Warnings, StepsInWhichABodyGoesTooFarForTheCells)
{
  const std::string motion = "analysis.0.rigid body boundary conditions.0.boundary conditions.0.prescribed=";
  expect_warning(
      warnings("plate-anchor-ts.json", {motion + "0.002"}),
      "stage 1 moves a body by 0.002 m in a step, 0.4 of the cells of 0.005 m at it: each step is made in 4");
  EXPECT_EQ(warnings("plate-anchor-ts.json", {motion + "0.0005"}), std::vector<std::string>());
  expect_warning(warnings("plate-anchor-ts.json", {motion + "0.002", "analysis.0.largest motion=off"}),
                 "so make them shorter");
  expect_warning(warnings("plate-anchor-ts.json", {motion + "0.002", "analysis.0.largest motion=0.25"}), "made in 2");
}

TEST(Warnings, StepsThatNoPartsMakeShortEnoughAreRefused)
{
  const std::string motion = "analysis.0.rigid body boundary conditions.0.boundary conditions.0.prescribed=0.002";
  EXPECT_NO_THROW(warnings("plate-anchor-ts.json", {motion, "solver.minimum step fraction=0.25"}));
  try
  {
    warnings("plate-anchor-ts.json", {motion, "solver.minimum step fraction=0.5"});
    FAIL() << "accepted";
  }
  catch (const InputError& error)
  {
    EXPECT_EQ(error.path, "analysis[0]");
    EXPECT_NE(std::string(error.what()).find("give the stage more steps"), std::string::npos) << error.what();
  }
}

TEST(Warnings, BoxesOfStagesThatRefineNothing)
{
  const std::string box = R"(analysis.0.adaptivity.boxes=[{"min": [0, 0], "max": [1, 1], "element size": 0.1}])";
  expect_warning(warnings("strip-footing.json", {"analysis.0.rigid bodies=off", box}), "no effect");
}

TEST(Warnings, ChoicesThatExperimentsHaveShownToBePoor)
{
  const std::string points = "material points.number of material points per element 1=";
  expect_warning(warnings("column.json", {points + "1"}), "take 2");
  expect_warning(warnings("column.json", {points + "5"}), "finer cells");
  expect_warning(warnings("column.json", {"solver.poor factor=0.9"}), "take 0.25");
  expect_warning(warnings("sphere.json", {"analysis.0.beta=0.3", "analysis.0.gamma=0.8"}), "here 0.4225, is stable");
  expect_warning(warnings("sphere.json", {"analysis.0.gamma=0.6"}), "may add energy");
  expect_warning(warnings("strip-footing.json", {"contact.normal penalty factor=0.01"}), "sink into the soil");
  expect_warning(warnings("plate-anchor-explicit.json", {"contact.normal penalty factor=10"}), "explicit stages");
}
