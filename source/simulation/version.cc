#include <fmt/format.h>
#include <kedge/base/kokkos.h>
#include <kedge/output/summary.h>
#include <kedge/simulation/version.h>

namespace kedge
{
std::string version() { return KEDGE_VERSION; }

std::string back_end() { return ExecutionSpace::name(); }

std::string describe_versions()
{
  std::string text = fmt::format("kedge {} (commit {}, back end {})", version(), commit(), back_end());
  for (const auto& [library, number] : library_versions())
    text += fmt::format("\n{} {}", library, number);
  return text;
}
} // namespace kedge
