// Text for the terminal: lines, warnings and the progress of a run; wall time per phase; memory.
#pragma once

#include <algorithm>
#include <chrono>
#include <kedge/base/fault.h>
#include <map>
#include <string>
#include <vector>

namespace kedge
{
/// The numbers of the progress line.
struct ProgressLine
{
  unsigned int stage = 1, n_stages = 1;
  double time = 0., end = 1.; ///< load fraction in a static stage, s otherwise
  unsigned int step = 0;
  double increment = 0.;
  bool is_explicit = false;
  unsigned int iterations = 0; ///< Newton iterations; in an explicit stage, time steps
  unsigned int krylov_iterations = 0, cuts = 0;
  long long deleted = 0, particles = 0;

  /// Of the stage, from 0 to 1.
  double fraction() const { return end > 0. ? std::min(1., time / end) : 1.; }
};

/// Writes to the terminal from one rank. A terminal redraws the progress line in place; a log file gets a line for the
/// first and the last step of a stage, and between them one per interval of wall time.
class Report
{
public:
  /// `speak`: this rank prints; `quiet`: it prints warnings only. `interval` (s) is that of a log file.
  Report(bool speak, bool quiet, double interval = 10.);

  void line(const std::string& text);
  void warn(const std::string& text);
  void progress(const ProgressLine& shown);
  /// Ends the progress line of a stage; a log file gets the last one where it was not due.
  void end_progress();

  const std::vector<std::string>& warnings() const { return given_warnings; }

private:
  void close_line();

  bool speak, quiet, on_terminal;
  double interval;
  bool line_open = false;
  std::string waiting; ///< progress that a log file has not got yet
  unsigned int last_stage = 0;
  std::chrono::steady_clock::time_point first_seen; ///< when the present stage first reported
  std::chrono::steady_clock::time_point last_line;  ///< when a log file got its last line of progress
  double first_fraction = 0.;                       ///< how much of the stage was done then
  std::vector<std::string> given_warnings;
};

/// The text of the progress line without the time left.
std::string format_progress(const ProgressLine& shown);

/// Wall time per named phase, in s.
class Timings
{
public:
  /// Adds the time from its construction to its destruction to a phase, less that of the scopes within.
  class Scope
  {
  public:
    Scope(Timings& timings, const char* phase);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

  private:
    Timings& timings;
    const char* phase;
    std::chrono::steady_clock::time_point start;
    double within_others; ///< of the scope around this one, so far
  };

  /// With a fault that strikes as its phase begins.
  explicit Timings(std::optional<PlannedFault> fault_ = {}) : fault(std::move(fault_)) {}

  Scope measure(const char* phase)
  {
    reach(phase);
    return {*this, phase};
  }
  /// A place within a phase where a planned fault may strike too.
  void reach(const char* place) const
  {
    if (fault)
      fault->strike_at(place);
  }
  /// For planned faults.
  void begin_step(const unsigned int number)
  {
    if (fault)
      fault->step_now = number;
  }
  const std::map<std::string, double>& seconds() const { return totals; }

private:
  std::map<std::string, double> totals;
  double within = 0.; ///< the present scope, s: spent in scopes within it
  std::optional<PlannedFault> fault;
};

/// Highest resident memory of this process so far, in bytes.
double peak_memory();
} // namespace kedge
