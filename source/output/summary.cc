#include <Eigen/Core>
#include <Kokkos_Macros.hpp>
#include <Trilinos_version.h>
#include <deal.II/base/config.h>
#include <fmt/format.h>
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
          {"material points", stage.particles},
          {"cells", stage.cells},
          {"dofs", stage.dofs},
          {"deleted", stage.deleted},
          {"deepest penetration", stage.penetration},
          {"bytes per material point", {{"data", stage.particle_bytes}, {"basis", stage.basis_bytes}}},
          {"rigid points at start", stage.start_positions}};
}

/// The first line: some implementations add how they were built.
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

void write_summary(const RunSummary& summary, const std::string& file)
{
  Json stages = Json::array();
  for (const StageSummary& stage : summary.stages)
    stages.push_back(to_json(stage));
  const Json json = {{"version", summary.version},
                     {"input", summary.input_file},
                     {"status", summary.status},
                     {"ranks", summary.ranks},
                     {"back end", summary.back_end},
                     {"GPU requested", summary.gpu_requested},
                     {"warnings", summary.warnings},
                     {"stages", stages},
                     {"wall time", {{"total", summary.total_seconds}, {"phases", summary.seconds}}},
                     {"peak memory", summary.peak_memory},
                     {"libraries", summary.libraries}};
  // a file name may hold bytes that are no UTF-8: that must not cost the summary
  replace_text_file(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}
} // namespace kedge
