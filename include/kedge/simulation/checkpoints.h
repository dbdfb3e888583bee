// When a run writes its restart file.
#pragma once

#include <chrono>
#include <kedge/output/parameters.h>
#include <string>

namespace kedge
{
/// The restart file of a run whose output lands below `output_directory`.
std::string restart_path(const OutputParameters& parameters, const std::string& output_directory);

/// Counts steps or wall time since the last restart file. Listens for SIGUSR1, which mpirun hands on to its ranks, and
/// while files are wanted for SIGTERM. Under mpirun that comes a second before SIGKILL.
class CheckpointSchedule
{
public:
  /// `output_directory`: what the folder of the input is relative to.
  CheckpointSchedule(const OutputParameters& parameters, const std::string& output_directory);
  ~CheckpointSchedule();
  CheckpointSchedule(const CheckpointSchedule&) = delete;
  CheckpointSchedule& operator=(const CheckpointSchedule&) = delete;

  /// The restart file; each replaces the one before.
  const std::string& path() const { return file; }
  /// Makes the folder of the restart file, on rank 0; the writer reports what cannot be written.
  void make_folder() const;
  /// Whether a file is due after a converged step: by the interval, or because the run is told to end. Ranks agree.
  /// Collective.
  bool due();
  /// The signal that tells the run to end, or null; what the last due() found on any rank.
  const char* told_to_end() const;

private:
  std::string file;
  unsigned int every_steps = 0, steps = 0; ///< 0: not by steps
  double every_seconds = 0.;               ///< 0: not by time
  std::chrono::steady_clock::time_point last = std::chrono::steady_clock::now();
  int ended_by = 0; ///< a signal
};
} // namespace kedge
