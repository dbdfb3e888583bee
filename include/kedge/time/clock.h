// Progress of a stage, and the size of its next step.
#pragma once

#include <cstdint>

namespace kedge
{
/// The memory of a clock; times are in its ticks.
struct ClockState
{
  std::int64_t ticks_per_step = 1; ///< a power of two
  std::int64_t position = 0;       ///< ticks since the stage began
  std::int64_t limit = 0;          ///< largest size of a step
  unsigned int cuts = 0;           ///< number of cuts in the stage
  unsigned int made = 0;           ///< steps as large as the limit since it was set
  unsigned int patience = 1;       ///< number of such steps after which the limit doubles
  bool on_trial = false;           ///< the limit has just doubled and no step has reached it yet
};

/// Counts the progress of a stage in ticks. Ticks are exact fractions of a requested step, so the stage ends at the
/// right time after any sequence of cuts. A failed step is halved. After a successful one the size doubles, up to the
/// requested size and not across the end of a requested step. If the larger step fails again, more small steps follow
/// before the next attempt: failures come in bursts and cost more than larger steps save.
class Clock
{
public:
  /// `n_steps`: requested steps; `minimum_fraction`: smallest share of a requested step that a cut leaves,
  /// rounded down to a power of two. An incomplete step at the end may be shorter.
  Clock(double n_steps, double minimum_fraction);

  bool at_end() const { return now.position == end; }
  /// Size of the current step as a fraction of a requested one.
  double step_fraction() const { return static_cast<double>(size) / now.ticks_per_step; }
  /// Progress of the stage in requested steps, before and after the current step.
  double steps_done() const { return static_cast<double>(now.position) / now.ticks_per_step; }
  double steps_after() const { return static_cast<double>(now.position + size) / now.ticks_per_step; }
  double requested_steps() const { return static_cast<double>(end) / now.ticks_per_step; }
  unsigned int cuts() const { return now.cuts; }

  ClockState state() const { return now; }
  /// Continues from the state of another clock of the same stage, which may have had another end or smallest step.
  void resume(const ClockState& state);

  /// From now on no step is larger than this fraction of a requested one, rounded down to a power of two. Returns false
  /// if that is below the smallest step allowed, which is then the limit.
  bool keep_below(double fraction);

  void advance();
  /// Halves the step. Returns false if it is already the smallest allowed.
  bool cut();

private:
  void stop_at_requested_steps();

  std::int64_t end, smallest = 1, size = 0, most = 0; ///< `most`: by keep_below()
  ClockState now;
};
} // namespace kedge
