// Where a stage stands, and how large its next step is.
#pragma once

#include <cstdint>

namespace kedge
{
/// What a clock has counted, in its ticks.
struct ClockState
{
  std::int64_t ticks_per_step = 1; ///< a power of two
  std::int64_t position = 0;       ///< of the stage
  std::int64_t limit = 0;          ///< of a step's size
  unsigned int cuts = 0;           ///< of the stage
  unsigned int made = 0;           ///< steps as large as the limit since it was set
  unsigned int patience = 1;       ///< such steps before the limit doubles
  bool on_trial = false;           ///< the limit has just doubled, and no step has been as large as it yet
};

/// Counts a stage's progress in ticks, exact fractions of a requested step, so that a stage ends where it should after
/// any sequence of cuts. A failed step is halved; a successful one is followed by one of twice its size, up to the
/// requested size and not across the end of a requested step. Where the larger step fails again, the smaller ones go on
/// for longer before the next attempt: failures come in bursts, and cost more than the steps they spare.
class Clock
{
public:
  /// `n_steps` requested steps, cut down to no less than `minimum_fraction` of one. A part of a step at the end is
  /// rounded to that fraction.
  Clock(double n_steps, double minimum_fraction);

  bool at_end() const { return now.position == end; }
  /// Size of the current step as a fraction of a requested one.
  double step_fraction() const { return static_cast<double>(size) / now.ticks_per_step; }
  /// Progress of the stage in requested steps: where it is, and where the current step ends.
  double steps_done() const { return static_cast<double>(now.position) / now.ticks_per_step; }
  double steps_after() const { return static_cast<double>(now.position + size) / now.ticks_per_step; }
  double requested_steps() const { return static_cast<double>(end) / now.ticks_per_step; }
  unsigned int cuts() const { return now.cuts; }

  ClockState state() const { return now; }
  /// Goes on where another clock of the same stage was, or of one that ended earlier or had another smallest step.
  void resume(const ClockState& state);

  void advance();
  /// Halves the step; false where it is already the smallest allowed.
  bool cut();

private:
  void stop_at_requested_steps();

  std::int64_t end, smallest = 1, size = 0;
  ClockState now;
};
} // namespace kedge
