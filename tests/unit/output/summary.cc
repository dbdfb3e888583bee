#include "read_back.h"

#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/summary.h>
#include <nlohmann/json.hpp>

namespace kedge
{
namespace
{
using Json = nlohmann::ordered_json;

Json write_and_parse(const RunSummary& summary)
{
  const test::TemporaryFolder folder;
  const std::string path = folder / (std::to_string(rank_of(MPI_COMM_WORLD)) + "summary.json");
  write_summary(summary, path);
  EXPECT_FALSE(std::filesystem::exists(path + ".new"));
  return Json::parse(read_text_file(path));
}

TEST(Summary, HoldsTheRun)
{
  RunSummary summary;
  summary.version = "0.1.0";
  summary.commit = "1a2b3c4";
  summary.input_file = "anchor.json";
  summary.back_end = "Serial";
  summary.gpu_requested = true;
  summary.ranks = 3;
  summary.warnings = {"the GPU was asked for", "second"};
  summary.stages.resize(2);
  summary.stages[1] = {"dynamic", 10, 2,     31,  900,  0,    70000, 12000,
                       41000,     17, 2.5e6, 0.5, 1e-4, 750., 1250., {{{1., 2., 3.}}}};
  summary.seconds = {{"assembly", 1.5}, {"solve", 2.25}};
  summary.total_seconds = 4.;
  summary.peak_memory = 2.5e9;
  const Json json = write_and_parse(summary);

  EXPECT_EQ(json["version"], "0.1.0");
  EXPECT_EQ(json["commit"], "1a2b3c4");
  EXPECT_EQ(json["input"], "anchor.json");
  EXPECT_EQ(json["status"], "finished");
  EXPECT_EQ(json["ranks"], 3);
  EXPECT_EQ(json["back end"], "Serial");
  EXPECT_EQ(json["GPU requested"], true);
  EXPECT_EQ(json["warnings"], Json({"the GPU was asked for", "second"}));
  EXPECT_EQ(json["stages"].size(), 2u);
  EXPECT_EQ(json["stages"][1].dump(),
            "{\"type\":\"dynamic\",\"steps\":10,\"cuts\":2,\"newton iterations\":31,\"krylov iterations\":900,\"time "
            "steps\":0,"
            "\"material points\":70000,\"cells\":12000,\"dofs\":41000,\"deleted\":17,"
            "\"mass\":2500000.0,\"removed mass\":0.5,\"deepest penetration\":0.0001,\"bytes per material "
            "point\":{\"data\":750.0,\"basis\":1250.0},"
            "\"rigid points at start\":[[1.0,2.0,3.0]]}");
  EXPECT_EQ(json["wall time"]["total"], 4.);
  EXPECT_EQ(json["wall time"]["phases"]["solve"], 2.25);
  EXPECT_EQ(json["peak memory"], 2.5e9);
}

TEST(Summary, EmptyRunKeepsItsShape)
{
  RunSummary summary;
  summary.status = "failed: input";
  const Json json = write_and_parse(summary);
  EXPECT_EQ(json["status"], "failed: input");
  EXPECT_TRUE(json["stages"].is_array());
  EXPECT_TRUE(json["warnings"].is_array());
  EXPECT_TRUE(json["wall time"]["phases"].is_object());
  EXPECT_TRUE(json["libraries"].is_object());
}

TEST(Summary, FileNameThatIsNotUtf8IsShownAnyway)
{
  RunSummary summary;
  summary.input_file = "anchor\xff.json";
  EXPECT_EQ(write_and_parse(summary)["input"], "anchor\xEF\xBF\xBD.json");
}

TEST(Summary, LibrariesHaveVersions)
{
  const auto versions = library_versions();
  for (const char* name : {"deal.II", "Trilinos", "Kokkos", "Eigen", "zlib", "MPI", "compiler"})
  {
    ASSERT_TRUE(versions.count(name)) << name;
    EXPECT_FALSE(versions.at(name).empty()) << name;
  }
}

TEST(Summary, UnwritableFileIsAnError) { EXPECT_THROW(write_summary({}, "/no such folder/summary.json"), FileError); }
} // namespace
} // namespace kedge
