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

/// Of a column of rigid_body.csv, in its last row.
double last_value(const std::filesystem::path& folder, const std::string& column)
{
  std::istringstream text(input_files::contents(folder / "csv" / "rigid_body.csv"));
  std::string names, row, name, value;
  std::getline(text, names);
  while (std::getline(text, value))
    row = value;
  std::istringstream all_names(names), values(row);
  while (std::getline(all_names, name, ',') && std::getline(values, value, ','))
    if (name == column)
      return std::stod(value);
  throw std::runtime_error("no column " + column);
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
  // the second stage presses the cube flat at once, in fewer iterations than that takes
  const input_files::Folder files;
  const std::string stage = R"({"type": "static", "load steps": 1, "load": "full", "rigid bodies": "on",
    "boundary conditions": {"min": ["roller", "roller", "roller"], "max": ["roller", "roller", "free"]})";
  const std::string flat = R"(, "rigid body boundary conditions": [{"system": 1, "point": 1,
    "boundary conditions": ["fixed", "fixed", {"prescribed": -0.9}, "fixed", "fixed", "fixed"]}])";
  const Input input = cube({"analysis=[" + stage + "}, " + stage + flat + "}]", "solver.minimum step fraction=0.5",
                            "analysis.1.largest motion=\"off\"", "solver.max newton iterations=4",
                            "output.csv percent=0", "output.vtk=off"});
  EXPECT_THROW(run_simulation(input, quietly_in(files.path)), SolverError);
  EXPECT_EQ(count_lines(files.path / "csv" / "rigid_body.csv"), 2u); // names and the first stage's only step
  ASSERT_TRUE(std::filesystem::exists(files.path / "checkpoints" / "restart.h5"));

  RunOptions again = quietly_in(files.path);
  again.restart = Restart::yes;
  EXPECT_THROW(run_simulation(input, again), SolverError); // at the same place
  EXPECT_EQ(count_lines(files.path / "csv" / "rigid_body.csv"), 2u);
}

TEST(RunSimulation, KeepsBodiesWhereTheyAreInStagesWithoutThem)
{
  const std::string faces = R"("boundary conditions": {"min": ["roller", "roller", "roller"],
    "max": ["roller", "roller", "free"]})";
  for (const std::string stepping : {R"("type": "static", "load steps": 2, "load": "full")",
                                     R"("type": "dynamic", "final time": 0.02, "dt": 0.01, "beta": 0.5, "gamma": 1)"})
  {
    const input_files::Folder files;
    const std::string stage = "{" + stepping + R"(, "rigid bodies": "off", )" + faces + "}";
    ASSERT_EQ(run_simulation(cube({"analysis=[" + stage + "]", "output.csv percent=0", "output.vtk=off"}),
                             quietly_in(files.path)),
              success);
    EXPECT_EQ(last_value(files.path, "body1_position_z"), 1.3) << stepping; // though -0.01 a step is prescribed
  }
}

TEST(RunSimulation, SavesTheStateWhereTheInputFailsInTheMiddle)
{
  const input_files::Folder files;
  const Input input = cube({"analysis.0.load steps=4", R"#(domain.body force={"expression": ["sqrt(0.6-t)", 0, 0]})#",
                            "output.csv percent=0", "output.vtk=off"});
  EXPECT_THROW(run_simulation(input, quietly_in(files.path)), InputError);
  EXPECT_EQ(count_lines(files.path / "csv" / "rigid_body.csv"), 3u); // names and two steps
  EXPECT_TRUE(std::filesystem::exists(files.path / "checkpoints" / "restart.h5"));
}

TEST(RunSimulation, SaysWhatARestartWithoutItsFileLacks)
{
  const input_files::Folder files;
  RunOptions options = quietly_in(files.path / "new");
  options.restart = Restart::yes;
  EXPECT_THROW(run_simulation(cube({}), options), FileError);
  EXPECT_FALSE(std::filesystem::exists(files.path / "new"));
}
