// Whole runs, as the program makes them.
#include "input_files.h"
#include <gtest/gtest.h>
#include <kedge/simulation/input.h>
#include <kedge/simulation/simulation.h>

using namespace kedge;

TEST(RunSimulation, MakesTheFolderOfItsSummaryWhereNothingElseIsWritten)
{
  const input_files::Folder files;
  const auto scene = input_files::root() / "prm" / "cube.json";
  const Input input = parse_input(input_files::contents(scene), scene.parent_path().string(), "cube.json",
                                  {"analysis.0.load steps=1", "output.vtk=off", "output.csv=off"});
  RunOptions options;
  options.quiet = true;
  options.output_directory = (files.path / "new" / "folder").string();
  EXPECT_TRUE(run_simulation(input, options));
  EXPECT_TRUE(std::filesystem::exists(files.path / "new" / "folder" / "input.json"));
  EXPECT_TRUE(std::filesystem::exists(files.path / "new" / "folder" / "summary.json"));
}
