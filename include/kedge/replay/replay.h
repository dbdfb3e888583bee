// Computes a saved linear system of Newton's method again and times its parts.
#pragma once

#include <kedge/replay/kernel_profile.h>
#include <kedge/replay/saved_step.h>
#include <optional>

namespace kedge
{
struct ReplayOptions
{
  unsigned int repetitions = 3;
  unsigned int copies = 1; ///< of the soil, which share the bodies: a larger system with the same answers
  /// If not none, every part is computed once more, before it is timed.
  KernelWatch watch = KernelWatch::none;
};

/// A part of the work.
struct ReplayedPart
{
  std::string name;
  double seconds = 0.;      ///< the shortest time of the repetitions, on the slowest rank
  double copied_bytes = 0.; ///< between host and device in each repetition, on this rank
  std::string remark;       ///< maybe empty
  KernelProfile profile;    ///< empty unless kernels are timed
};

/// What a replay has found. Differences are the largest entry's, relative to the largest entry of what was saved.
struct ReplayReport
{
  unsigned int dim = 3;
  long long n_particles = 0, n_dofs = 0; ///< of all ranks
  std::vector<ReplayedPart> parts;
  double residual_difference = 0., product_difference = 0., border_difference = 0.;
  std::optional<double> whole_difference; ///< of the product with the matrix that is factorised, in small systems
  double solution_residual = 0.;          ///< of the linear system, relative
  double tolerance = 0.;                  ///< what that may be
  unsigned int linear_iterations = 0;
};

/// Every part is computed several times. Throws FileError, SolverError and, where steps of several ranks are to be
/// copied, InputError. Collective.
ReplayReport replay_step(const std::string& path, const ReplayOptions& options);

/// A table for people.
std::string format_replay(const ReplayReport& report, const std::string& back_end);
} // namespace kedge
