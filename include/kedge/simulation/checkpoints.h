// When a run writes its restart files, and what tells it to end.
#pragma once

#include <chrono>
#include <kedge/output/parameters.h>
#include <kedge/output/restart_files.h>
#include <string>

namespace kedge
{
/// The folder of the restart files of a run whose output lands below `output_directory`.
std::string restart_folder(const OutputParameters& parameters, const std::string& output_directory);

/// Counts steps or wall time since the last restart file. Listens for SIGTERM, SIGINT (Ctrl-C), SIGUSR1 and SIGHUP,
/// which end a run after its step; of SIGTERM and SIGINT, of either, the second one ends it at once. mpirun hands
/// SIGUSR1 on to its ranks; after SIGTERM and SIGINT it kills them a second later, unless told to wait (scripts/mpirun
/// does).
class CheckpointSchedule
{
public:
  /// `output_directory`: what the folder of the input is relative to.
  CheckpointSchedule(const OutputParameters& parameters, const std::string& output_directory);
  ~CheckpointSchedule();
  CheckpointSchedule(const CheckpointSchedule&) = delete;
  CheckpointSchedule& operator=(const CheckpointSchedule&) = delete;

  const RestartFiles& files() const { return names; }
  /// Makes the folder of the restart files, on rank 0; the writer reports what cannot be written.
  void make_folder() const;
  /// Removes those of an earlier run, on rank 0. Throws FileError there.
  void remove_files() const;
  /// Whether files are wanted at intervals, so that the end of the run is one, too.
  bool is_on() const { return every_steps > 0 || every_seconds > 0.; }
  /// Whether a file is due after a converged step: by the interval, or because the run is told to end. Ranks agree.
  /// Collective.
  bool due();
  /// The signal that tells the run to end, or 0; what the last due() found on any rank.
  int told_to_end() const { return ended_by; }

private:
  RestartFiles names;
  unsigned int every_steps = 0, steps = 0; ///< 0: not by steps
  double every_seconds = 0.;               ///< 0: not by time
  std::chrono::steady_clock::time_point last = std::chrono::steady_clock::now();
  int ended_by = 0; ///< a signal
};

/// "SIGTERM" and so on, of those that end a run.
const char* name_of_signal(int signal);
} // namespace kedge
