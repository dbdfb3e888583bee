// Runs an input from its first stage to its last.
#pragma once

#include <kedge/simulation/input.h>
#include <string>

namespace kedge
{
struct RunOptions
{
  std::string input_file;       ///< for the summary
  std::string output_directory; ///< every output lands below it
  bool quiet = false;
  bool verbose = false; ///< print the residuals of every step
  bool restart = false; ///< go on from the restart file in the output folder
};

/// Runs all stages; false where a signal ended it after a step, with a restart file written. Throws SolverError where a
/// step fails at its smallest size (the state reached is written first, also as a restart file) and FileError where
/// output cannot be written. Collective.
bool run_simulation(const Input& input, const RunOptions& options);
} // namespace kedge
