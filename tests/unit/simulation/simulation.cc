// Whole runs, as the program makes them.
#include "input_files.h"
#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/simulation/input.h>
#include <kedge/simulation/simulation.h>

using namespace kedge;

namespace
{
Input cube(const std::vector<std::string>& overrides)
{
  const auto scene = input_files::root() / "prm" / "cube.json";
  return parse_input(input_files::contents(scene), scene.parent_path().string(), "cube.json", overrides);
}

RunOptions quietly_in(const std::filesystem::path& folder)
{
  RunOptions options;
  options.quiet = true;
  options.output_directory = folder.string();
  return options;
}

std::size_t count_lines(const std::filesystem::path& file)
{
  const std::string text = input_files::contents(file);
  return std::count(text.begin(), text.end(), '\n');
}
} // namespace

TEST(RunSimulation, MakesTheFolderOfItsSummaryWhereNothingElseIsWritten)
{
  const input_files::Folder files;
  EXPECT_EQ(run_simulation(cube({"analysis.0.load steps=1", "output.vtk=off", "output.csv=off"}),
                           quietly_in(files.path / "new" / "folder")),
            success);
  EXPECT_TRUE(std::filesystem::exists(files.path / "new" / "folder" / "input.json"));
  EXPECT_TRUE(std::filesystem::exists(files.path / "new" / "folder" / "summary.json"));
}

TEST(RunSimulation, SavesTheStateWhereAStageFailsInItsFirstStep)
{
  // the second stage presses the cube flat at once
  const input_files::Folder files;
  const std::string stage = R"({"type": "static", "load steps": 1, "load": "full", "rigid bodies": "on",
    "boundary conditions": {"min": ["roller", "roller", "roller"], "max": ["roller", "roller", "free"]})";
  const std::string flat = R"(, "rigid body boundary conditions": [{"system": 1, "point": 1,
    "boundary conditions": ["fixed", "fixed", {"prescribed": -0.9}, "fixed", "fixed", "fixed"]}])";
  const Input input = cube({"analysis=[" + stage + "}, " + stage + flat + "}]", "solver.minimum step fraction=0.5",
                            "output.csv percent=0", "output.vtk=off"});
  EXPECT_THROW(run_simulation(input, quietly_in(files.path)), SolverError);
  EXPECT_EQ(count_lines(files.path / "csv" / "rigid_body.csv"), 2u); // names and the first stage's only step
  ASSERT_TRUE(std::filesystem::exists(files.path / "checkpoints" / "restart.h5"));

  RunOptions again = quietly_in(files.path);
  again.restart = Restart::yes;
  EXPECT_THROW(run_simulation(input, again), SolverError); // at the same place
  EXPECT_EQ(count_lines(files.path / "csv" / "rigid_body.csv"), 2u);
}

TEST(RunSimulation, SaysWhatARestartWithoutItsFileLacks)
{
  const input_files::Folder files;
  RunOptions options = quietly_in(files.path / "new");
  options.restart = Restart::yes;
  EXPECT_THROW(run_simulation(cube({}), options), FileError);
  EXPECT_FALSE(std::filesystem::exists(files.path / "new"));
}
