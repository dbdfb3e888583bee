#include "read_back.h"
#include "scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <set>
#include <sstream>

namespace kedge
{
namespace
{
using test::everything;
using test::files_in;
using test::Scene;
using test::TemporaryFolder;
using Names = std::set<std::string>;

constexpr StepSpan first_step{0., 1.};

/// Names of one series in parallel or not.
void add_series(Names& names, const std::string& start)
{
  const int size = size_of(MPI_COMM_WORLD);
  names.insert(start + (size > 1 ? ".pvtu" : ".vtu"));
  if (size > 1) // all of them write one piece
    names.insert(start + "_0.vtu");
}

template <int dim> void add_body(Scene<dim>& scene)
{
  scene.bodies.points.resize(1);
  scene.bodies.points[0].mass = 3.;
  scene.bodies.surfaces.push_back({Surface(test::cube()), 0});
  scene.bodies.tracked.push_back({Eigen::Vector3d(0., 0., 1.), 0});
}

TEST(OutputWriter, WritesEverySeries)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  add_body(scene);
  OutputWriter<3> writer(everything(), folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(10);
  writer.write_if_due(scene.state(2), first_step, false);

  Names vtk = {"mps_1.pvd",   "mps_2.pvd",      "mesh.pvd",          "body.pvd",         "surface.pvd",
               "tracked.pvd", "body_00002.vtu", "surface_00002.vtu", "tracked_00002.vtu"};
  for (const char* start : {"mps_1_00002", "mps_2_00002", "mesh_00002"})
    add_series(vtk, start);
  EXPECT_EQ(files_in(folder / "vtk"), vtk);
  EXPECT_EQ(files_in(folder / "csv/deep"), Names({"mps_1_00002.csv", "mps_2_00002.csv", "rigid_body.csv"}));
}

TEST(OutputWriter, SceneWithoutBodiesHasNoFilesOfThem)
{
  const TemporaryFolder folder;
  Scene<2> scene;
  OutputParameters parameters = everything();
  parameters.csv.particle_fields = {}; // no columns, no file
  OutputWriter<2> writer(parameters, folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(10);
  writer.write_if_due(scene.state(123456), first_step, false);

  Names vtk = {"mps_1.pvd", "mps_2.pvd", "mesh.pvd"};
  for (const char* start : {"mps_1_123456", "mps_2_123456", "mesh_123456"})
    add_series(vtk, start);
  EXPECT_EQ(files_in(folder / "vtk"), vtk);
  EXPECT_EQ(files_in(folder / "csv/deep"), Names());
}

TEST(OutputWriter, SeriesAreSwitchedAndTimedOnTheirOwn)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  OutputParameters parameters = everything();
  parameters.vtk.on = false;
  parameters.csv.percent = 50.;
  OutputWriter<3> writer(parameters, folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(4);
  for (unsigned int step = 1; step <= 5; ++step)
    writer.write_if_due(scene.state(step + 1), {step - 1., step * 1.}, step == 5);
  EXPECT_FALSE(std::filesystem::exists(folder / "vtk"));
  EXPECT_EQ(files_in(folder / "csv/deep"), Names({"mps_1_00003.csv", "mps_2_00003.csv", "mps_1_00005.csv",
                                                  "mps_2_00005.csv", "mps_1_00006.csv", "mps_2_00006.csv"}));
}

TEST(OutputWriter, PiecesHoldAllParticlesAndTheRequestedFields)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  OutputParameters parameters = everything();
  parameters.vtk.particle_fields = {"initial volume", "stress"};
  OutputWriter<3> writer(parameters, folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(1);
  writer.write_if_due(scene.state(2), first_step, true);

  MPI_Barrier(MPI_COMM_WORLD);
  const bool parallel = size_of(MPI_COMM_WORLD) > 1;
  const test::ReadGrid grid = test::read_vtu(folder / (parallel ? "vtk/mps_2_00002_0.vtu" : "vtk/mps_2_00002.vtu"));
  EXPECT_EQ(grid.time, 10.5);
  EXPECT_EQ(grid.arrays.size(), 4u + 2u);
  EXPECT_EQ(grid.arrays.at("CellData/stress").component_names,
            std::vector<std::string>({"xx", "yy", "zz", "xy", "yz", "xz"}));
  double sum = 0.;
  for (const double volume : grid.arrays.at("CellData/initial volume").values)
    sum += volume;
  EXPECT_EQ(sum, 10. + 12. + 14. + 16.);
}

TEST(OutputWriter, ParticleTableIsSortedOverRanks)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  OutputParameters parameters = everything();
  parameters.csv.particle_fields = {"initial volume", "position"};
  OutputWriter<3> writer(parameters, folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(1);
  writer.write_if_due(scene.state(2), first_step, true);
  EXPECT_EQ(read_text_file(folder / "csv/deep/mps_2_00002.csv"), "time,0.5\n"
                                                                 "initial volume,position_x,position_y,position_z\n"
                                                                 "10,0.5,0.5,0.5\n"
                                                                 "12,0.5,1.5,0.5\n"
                                                                 "14,1.5,0.5,0.5\n"
                                                                 "16,1.5,1.5,0.5\n");
}

TEST(OutputWriter, ContactForcesOfAllRanksAddUp)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  add_body(scene);
  typename Contact<3>::Touch touch;
  touch.position = {0.5, -0.9, 0.95};
  touch.force = {0., 0., 4.};
  touch.surface = 0;
  scene.touches = {touch};
  OutputWriter<3> writer(everything(), folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(1);
  writer.write_if_due(scene.state(2), first_step, true);
  double sum = 0.;
  const test::ReadGrid grid = test::read_vtu(folder / "vtk/surface_00002.vtu");
  const std::vector<double>& force = grid.arrays.at("CellData/contact force").values;
  for (std::size_t face = 0; face < grid.n_cells; ++face)
    sum += force[3 * face + 2];
  EXPECT_EQ(sum, -2. * size_of(MPI_COMM_WORLD)); // on a triangle of 2 m2
}

TEST(OutputWriter, RestartContinuesListsAndTable)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  add_body(scene);
  OutputParameters parameters = everything();
  parameters.csv.body_fields = {"mass"};
  const auto run = [&](unsigned int first, unsigned int last, bool restart)
  {
    OutputWriter<3> writer(parameters, folder.name(), {{}, {}}, MPI_COMM_WORLD);
    writer.keep_until(restart ? first - 1 : 0);
    writer.begin_stage(10);
    for (unsigned int step = first; step <= last; ++step)
      writer.write_if_due(scene.state(step), {step - 2., step - 1.}, false);
  };
  run(2, 5, false);
  run(4, 4, true);

  unsigned int n_listed = 0;
  for (const test::Tag& tag : test::read_tags(read_text_file(folder / "vtk/body.pvd")))
    n_listed += tag.name == "DataSet";
  EXPECT_EQ(n_listed, 3u);
  std::istringstream lines(read_text_file(folder / "csv/deep/rigid_body.csv"));
  std::vector<std::string> steps;
  for (std::string line; std::getline(lines, line);)
    steps.push_back(line.substr(line.rfind(',') + 1));
  EXPECT_EQ(steps, std::vector<std::string>({"step", "2", "3", "4"}));
}

TEST(OutputWriter, WritesNoStepTwice)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  add_body(scene);
  OutputParameters parameters = everything();
  parameters.vtk.percent = 50.;
  parameters.csv.body_fields = {"mass"};
  const auto count_rows = [&]
  {
    const std::string text = read_text_file(folder / "csv/deep/rigid_body.csv");
    return std::count(text.begin(), text.end(), '\n') - 1;
  };
  {
    OutputWriter<3> writer(parameters, folder.name(), {{}, {}}, MPI_COMM_WORLD);
    writer.keep_until(0);
    writer.begin_stage(4);
    writer.write_if_due(scene.state(2), first_step, false); // a row of the table alone
    writer.write_if_due(scene.state(2), first_step,
                        true); // the run fails in its next step: writes the rest of this one
  }
  EXPECT_EQ(count_rows(), 1);
  EXPECT_TRUE(std::filesystem::exists(folder / "vtk/body.pvd"));
  OutputWriter<3> writer(parameters, folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(2);
  writer.begin_stage(4);
  writer.write_if_due(scene.state(2), first_step, true); // the next step has failed again
  EXPECT_EQ(count_rows(), 1);
}

TEST(OutputWriter, FolderThatCannotBeMadeFailsOnEveryRank)
{
  OutputWriter<3> writer(everything(), "/proc/no such place", {{}}, MPI_COMM_WORLD);
  EXPECT_THROW(writer.keep_until(0), FileError);
}

TEST(OutputWriter, LostFolderFailsOnEveryRank)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  OutputWriter<3> writer(everything(), folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(1);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::filesystem::remove_all(folder / "csv"); // only rank 0 writes tables
  EXPECT_THROW(writer.write_if_due(scene.state(2), first_step, true), FileError);
}
} // namespace
} // namespace kedge
