#include <Eigen/Core>
#include <Kokkos_Macros.hpp>
#include <Trilinos_version.h>
#include <deal.II/base/config.h>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/summary.h>
#include <mpi.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

namespace kedge
{
namespace
{
using Json = nlohmann::ordered_json;

Json to_json(const StageSummary& stage)
{
  return {{"type", stage.type},
          {"steps", stage.steps},
          {"cuts", stage.cuts},
          {"newton iterations", stage.newton_iterations},
          {"krylov iterations", stage.krylov_iterations},
          {"time steps", stage.time_steps},
          {"material points", stage.particles},
          {"cells", stage.cells},
          {"dofs", stage.dofs},
          {"deleted", stage.deleted},
          {"mass", stage.mass},
          {"removed mass", stage.removed_mass},
          {"deepest penetration", stage.penetration},
          {"bytes per material point", {{"data", stage.particle_bytes}, {"basis", stage.basis_bytes}}},
          {"rigid points at start", stage.start_positions}};
}

StageSummary stage_from(const Json& json)
{
  StageSummary stage;
  stage.type = json.at("type");
  stage.steps = json.at("steps");
  stage.cuts = json.at("cuts");
  stage.newton_iterations = json.at("newton iterations");
  stage.krylov_iterations = json.at("krylov iterations");
  stage.time_steps = json.at("time steps");
  stage.particles = json.at("material points");
  stage.cells = json.at("cells");
  stage.dofs = json.at("dofs");
  stage.deleted = json.at("deleted");
  stage.mass = json.value("mass", 0.); // older restart files have none
  stage.removed_mass = json.value("removed mass", 0.);
  stage.penetration = json.at("deepest penetration");
  stage.particle_bytes = json.at("bytes per material point").at("data");
  stage.basis_bytes = json.at("bytes per material point").at("basis");
  stage.start_positions = json.at("rigid points at start").get<std::vector<std::array<double, 3>>>();
  return stage;
}

Json to_json(const std::vector<StageSummary>& stages)
{
  Json list = Json::array();
  for (const StageSummary& stage : stages)
    list.push_back(to_json(stage));
  return list;
}

Json to_json(const RunSummary& summary)
{
  return {{"version", summary.version},
          {"commit", summary.commit},
          {"input", summary.input_file},
          {"status", summary.status},
          {"ranks", summary.ranks},
          {"back end", summary.back_end},
          {"GPU requested", summary.gpu_requested},
          {"warnings", summary.warnings},
          {"stages", to_json(summary.stages)},
          {"wall time", {{"total", summary.total_seconds}, {"phases", summary.seconds}}},
          {"peak memory", summary.peak_memory},
          {"libraries", summary.libraries}};
}

constexpr int readable = 2, compact = -1; ///< indents

/// A file name may hold bytes that are not UTF-8. They are replaced, so that the summary can be written.
std::string to_text(const Json& json, const int indent = readable)
{
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// The summary that is there with another status; null if there is none.
Json with_status(const RunSummary& summary, const std::string& file)
{
  std::error_code ignored;
  Json json = std::filesystem::exists(file, ignored) ? Json::parse(read_text_file(file), nullptr, false) : Json();
  if (!json.is_object())
    return {};
  json["status"] = summary.status;
  return json;
}

/// Over the old file where the disk has no room for a second one.
void write(const Json& json, const std::string& file)
{
  try
  {
    replace_text_file(file, to_text(json));
  }
  catch (const DiskError&)
  {
    if (!write_in_place(file, to_text(json, compact)))
      throw;
  }
}

/// The first line only: some implementations add how they were built.
std::string mpi_version()
{
  char text[MPI_MAX_LIBRARY_VERSION_STRING];
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string version(text, length);
  return version.substr(0, version.find_first_of("\n,"));
}
} // namespace

std::map<std::string, std::string> library_versions()
{
  return {{"deal.II", DEAL_II_PACKAGE_VERSION},
          {"Trilinos", TRILINOS_VERSION_STRING},
          {"Kokkos", fmt::format("{}.{}.{}", KOKKOS_VERSION / 10000, KOKKOS_VERSION / 100 % 100, KOKKOS_VERSION % 100)},
          {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"zlib", zlibVersion()},
          {"MPI", mpi_version()},
          {"compiler", __VERSION__}};
}

std::string stages_as_text(const RunSummary& summary)
{
  return Json{{"stages", to_json(summary.stages)}, {"total", summary.total_seconds}, {"phases", summary.seconds}}
      .dump();
}

void read_stages(const std::string& text, RunSummary& summary)
{
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.contains("stages"))
    return;
  summary.stages.clear();
  for (const Json& stage : json.at("stages"))
    summary.stages.push_back(stage_from(stage));
  summary.total_seconds = json.at("total");
  summary.seconds = json.at("phases").get<std::map<std::string, double>>();
}

void write_summary(const RunSummary& summary, const std::string& file)
{
  try
  {
    write(to_json(summary), file);
  }
  catch (const DiskError&)
  {
    const Json json = with_status(summary, file);
    if (json.is_null() || !write_in_place(file, to_text(json, compact)))
      throw;
    throw DiskError(file, "has room for a new status alone; the rest of it is what was written last");
  }
}

void change_status(const RunSummary& summary, const std::string& file)
{
  const Json json = with_status(summary, file);
  if (json.is_null())
    return write_summary(summary, file);
  write(json, file);
}
} // namespace kedge
