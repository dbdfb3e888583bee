// Summary of a run and its cost, as a file beside the results.
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
  long long newton_iterations = 0, krylov_iterations = 0, time_steps = 0; ///< time_steps: of explicit stages
  long long particles = 0, cells = 0, dofs = 0;       ///< at the end, over all ranks; cells: those that hold soil
  long long deleted = 0;                              ///< particles deleted during the stage
  double mass = 0., removed_mass = 0.;                ///< of all particles at the end; of those hopeless; kg
  double penetration = 0.;                            ///< deepest one of all steps, m
  double particle_bytes = 0., basis_bytes = 0.;       ///< memory per particle: its data; its shape functions
  std::vector<std::array<double, 3>> start_positions; ///< of the rigid points, m
};

struct RunSummary
{
  std::string version, commit, input_file, back_end;
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

/// Versions of the libraries that affect a result, of MPI and of the compiler.
std::map<std::string, std::string> library_versions();

/// Converts the stages and the wall time to text for a restart file, and back. An unreadable text gives no stages.
std::string stages_as_text(const RunSummary& summary);
void read_stages(const std::string& text, RunSummary& summary);

/// Writes JSON. A reader sees the old summary or the new one, never a part. Where the disk has no room for a second
/// file, the new one, or at least its status, is written over the old one. Throws FileError.
void write_summary(const RunSummary& summary, const std::string& file);

/// Writes the status into the summary that is there, or all of it where there is none.
void change_status(const RunSummary& summary, const std::string& file);
} // namespace kedge
