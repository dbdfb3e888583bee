// What a run did and what it cost, as a file beside its results.
#pragma once

#include <array>
#include <kedge/output/text_file.h>
#include <map>
#include <string>
#include <vector>

namespace kedge
{
struct StageSummary
{
  std::string type; ///< "static", "dynamic", "explicit"
  unsigned int steps = 0, cuts = 0;
  long long newton_iterations = 0, krylov_iterations = 0, time_steps = 0; ///< the last of explicit stages
  long long particles = 0, cells = 0, dofs = 0;       ///< at its end, over all ranks; cells that hold soil
  long long deleted = 0;                              ///< particles, during the stage
  double penetration = 0.;                            ///< deepest of any step, m
  double particle_bytes = 0., basis_bytes = 0.;       ///< per particle: its data, its shape functions
  std::vector<std::array<double, 3>> start_positions; ///< of the rigid points, m
};

struct RunSummary
{
  std::string version, input_file, back_end;
  bool gpu_requested = false;
  int ranks = 1;
  std::string status = "finished"; ///< or "failed: ..."
  std::vector<std::string> warnings;
  std::vector<StageSummary> stages;
  std::map<std::string, double> seconds; ///< wall time per phase
  double total_seconds = 0.;
  double peak_memory = 0.;                      ///< highest of any rank, bytes
  std::map<std::string, std::string> libraries; ///< name and version
};

/// Versions of the libraries that matter to a result, of MPI and of the compiler.
std::map<std::string, std::string> library_versions();

/// The stages and the wall time as text for a restart file, and back. What cannot be read counts as no stages.
std::string stages_as_text(const RunSummary& summary);
void read_stages(const std::string& text, RunSummary& summary);

/// Writes JSON in one go: a reader sees the old summary or the new one. Throws FileError.
void write_summary(const RunSummary& summary, const std::string& file);
} // namespace kedge
