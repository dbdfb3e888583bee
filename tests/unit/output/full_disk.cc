// A limit of the size of files stands for a full disk: the system refuses what goes beyond it, in the middle of a
// write.
#include "read_back.h"
#include "scene.h"

#include <csignal>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/history.h>
#include <kedge/output/summary.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

namespace kedge
{
namespace
{
using test::everything;
using test::files_in;
using test::own;
using test::Scene;
using test::TemporaryFolder;

/// Until it goes out of scope.
class LimitOfFiles
{
public:
  explicit LimitOfFiles(const std::size_t bytes)
  {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before);
    const rlimit now{bytes, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &now);
  }
  ~LimitOfFiles() { ::setrlimit(RLIMIT_FSIZE, &before); }
  LimitOfFiles(const LimitOfFiles&) = delete;
  LimitOfFiles& operator=(const LimitOfFiles&) = delete;

private:
  rlimit before{};
};

TEST(FullDisk, SummaryTellsItsStatusInTheRoomThatItHas)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("summary.json");
  RunSummary summary;
  summary.status = "running";
  summary.warnings = {"one"};
  write_summary(summary, path);
  const std::size_t size = read_text_file(path).size();
  const LimitOfFiles limit(size); // "finished" is longer than "running"
  const auto written = [&] { return nlohmann::json::parse(read_text_file(path)); };

  summary.status = "finished";
  write_summary(summary, path);
  EXPECT_EQ(written().at("status"), "finished");
  EXPECT_EQ(read_text_file(path).size(), size);

  summary.status = "failed: too long";
  summary.warnings = {std::string(size, 'x')};
  EXPECT_THROW(write_summary(summary, path), DiskError);
  EXPECT_EQ(written().at("status"), "failed: too long");
  EXPECT_EQ(written().at("warnings").at(0), "one");
}

TEST(FullDisk, WhatReplacesAFileIsThereOrNot)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("a");
  write_text_file(path, "old");
  {
    const LimitOfFiles limit(100);
    EXPECT_THROW(replace_text_file(path, std::string(101, 'x')), DiskError);
  }
  EXPECT_EQ(read_text_file(path), "old");
  EXPECT_FALSE(std::filesystem::exists(draft_of(path)));
}

TEST(FullDisk, TextIsAppendedWholeOrNotAtAll)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("a");
  const LimitOfFiles limit(100);
  append_text(path, std::string(90, 'x'));
  EXPECT_THROW(append_text(path, std::string(20, 'y')), DiskError);
  EXPECT_EQ(read_text_file(path), std::string(90, 'x'));
}

TEST(FullDisk, TableOfPointsIsThereOrNot)
{
  const TemporaryFolder folder;
  const ParticleTable table = {{0, 1}, {0.25, 0.5}};
  const auto fields = select_particle_fields<3>({"volume"});
  {
    const LimitOfFiles limit(20); // between the two rows
    EXPECT_THROW(write_particle_csv(table, fields, 0., folder / own("mps.csv"), MPI_COMM_SELF), DiskError);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_TRUE(files_in(folder.name()).empty());
}

TEST(FullDisk, RowsOfBodiesWait)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("rigid_body.csv");
  BodyHistory history(path, {});
  {
    const LimitOfFiles limit(30);
    history.append({}, {}, 0.25, 1, 2);
    EXPECT_THROW(history.append({}, {}, 0.5, 1, 3), DiskError);
    EXPECT_THROW(history.append({}, {}, 0.75, 1, 4), DiskError);
    EXPECT_EQ(read_text_file(path), "time,stage,step\n0.25,1,2\n");
    EXPECT_EQ(history.count_waiting(), 2u);
  }
  history.append({}, {}, 1., 1, 5);
  EXPECT_EQ(read_text_file(path), "time,stage,step\n0.25,1,2\n0.5,1,3\n0.75,1,4\n1,1,5\n");
  EXPECT_EQ(history.count_waiting(), 0u);
  EXPECT_EQ(history.take_lost(), 0u);
}

TEST(FullDisk, RowsThatWaitAreLimited)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("rigid_body.csv");
  BodyHistory history(path, {}, 20);
  {
    const LimitOfFiles limit(5);
    for (unsigned int step = 2; step < 6; ++step)
      EXPECT_THROW(history.append({}, {}, 0.5, 1, step), DiskError);
  }
  history.write();
  EXPECT_EQ(read_text_file(path), "time,stage,step\n0.5,1,2\n0.5,1,3\n");
  EXPECT_EQ(history.take_lost(), 2u);
}

TEST(FullDisk, TableThatWasTakenAwayBeginsWithItsNames)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("rigid_body.csv");
  BodyHistory history(path, {});
  history.append({}, {}, 0.25, 1, 2);
  std::filesystem::remove(path);
  history.append({}, {}, 0.5, 1, 3);
  EXPECT_EQ(read_text_file(path), "time,stage,step\n0.5,1,3\n");
}

TEST(FullDisk, RestartCutsATableWithoutRoomForASecondOne)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("rigid_body.csv");
  const std::string kept = "time,stage,step\n0.1,1,2\n0.2,1,3\n";
  write_text_file(path, kept + "0.3,1,4\n0.4,1");
  const LimitOfFiles limit(10);
  BodyHistory(path, {}).resume_after(3);
  EXPECT_EQ(read_text_file(path), kept);
}

TEST(FullDisk, WriterWarnsOnceAndSaysWhatIsMissing)
{
  const TemporaryFolder folder;
  Scene<3> scene;
  OutputWriter<3> writer(everything(), folder.name(), {{}, {}}, MPI_COMM_WORLD);
  writer.keep_until(0);
  writer.begin_stage(1);
  const auto warnings_of = [&](const unsigned int step)
  {
    writer.write_if_due(scene.state(step), {0., 1.}, true);
    return writer.take_warnings();
  };
  {
    const LimitOfFiles limit(50);
    EXPECT_EQ(warnings_of(2).size(), 2u);
    EXPECT_TRUE(warnings_of(3).empty());
    MPI_Barrier(MPI_COMM_WORLD);
    EXPECT_TRUE(files_in(folder / "vtk").empty());
    EXPECT_TRUE(files_in(folder / "csv/deep").empty());
    MPI_Barrier(MPI_COMM_WORLD);
  }
  const std::vector<std::string> after = warnings_of(4);
  ASSERT_EQ(after.size(), 2u);
  for (const std::string& warning : after)
    EXPECT_NE(warning.find("are missing at 2 moments from step 2 to step 3"), std::string::npos) << warning;
  EXPECT_TRUE(std::filesystem::exists(folder / "vtk/mesh.pvd"));
}
} // namespace
} // namespace kedge
