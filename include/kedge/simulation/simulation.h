// Runs an input from its first stage to its last.
#pragma once

#include <kedge/base/failure.h>
#include <kedge/simulation/input.h>
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

struct RunOptions
{
  std::string input_file;       ///< for the summary
  std::string output_directory; ///< every output lands below it
  bool quiet = false;
  bool verbose = false; ///< print the residuals of every step
  Restart restart = Restart::no;
};

/// Runs all stages. Returns success, or told_to_end or interrupted where a signal ended the run after a step, with a
/// restart file written. Throws SolverError where a
/// step fails at its smallest size (the state reached is written first, also as a restart file) and FileError where
/// output cannot be written. Collective.
ExitCode run_simulation(const Input& input, const RunOptions& options);
} // namespace kedge
