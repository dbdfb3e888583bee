// Runs an input from its first stage to its last.
#pragma once

#include <kedge/base/failure.h>
#include <kedge/simulation/input.h>
#include <optional>
#include <string>

namespace kedge
{
/// Whether a run goes on from a restart file in its output folder.
enum class Restart
{
  no,
  yes,
  automatic ///< where there is a file
};

/// A linear system of Newton's method that a run writes to a file (replay/saved_step.h) before it ends.
struct SystemToDump
{
  unsigned int step = 0;      ///< as the progress line counts them; 0: the first of the run
  unsigned int iteration = 1; ///< of the step, from 1
  std::string path;
};

struct RunOptions
{
  std::string input_file;       ///< for the summary
  std::string output_directory; ///< every output lands below it
  bool quiet = false;
  bool verbose = false; ///< print the residuals of every step
  Restart restart = Restart::no;
  std::optional<SystemToDump> dumps;
};

/// Runs all stages. Returns success, or told_to_end or interrupted where a signal ended the run after a step, with a
/// restart file written. Throws SolverError where a step fails at its smallest size (the state reached is written
/// first, also as a restart file), FileError where output cannot be written, unless only the disk has no room, and
/// InputError where the run has no such system as it is to dump. Collective.
ExitCode run_simulation(const Input& input, const RunOptions& options);
} // namespace kedge
