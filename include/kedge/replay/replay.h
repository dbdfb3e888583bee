// Computes a saved linear system of Newton's method again and times its parts.
#pragma once

#include <kedge/replay/saved_step.h>

namespace kedge
{
/// Seconds that a part takes, the shortest of the repetitions, on the slowest rank.
struct ReplayedPart
{
  std::string name;
  double seconds = 0.;
  std::string remark; ///< maybe empty
};

/// What a replay has found. Differences are the largest entry's, relative to the largest entry of what was saved.
struct ReplayReport
{
  unsigned int dim = 3;
  long long n_particles = 0, n_dofs = 0; ///< of all ranks
  std::vector<ReplayedPart> parts;
  double residual_difference = 0., product_difference = 0.;
  double solution_residual = 0.; ///< of the linear system, relative
  double tolerance = 0.;         ///< what that may be
  unsigned int linear_iterations = 0;
};

/// Every part is computed `repetitions` times. Throws FileError and SolverError. Collective.
ReplayReport replay_step(const std::string& path, unsigned int repetitions);

/// A table for people.
std::string format_replay(const ReplayReport& report, const std::string& back_end);
} // namespace kedge
