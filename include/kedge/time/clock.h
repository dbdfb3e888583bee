// Where a stage stands, and how large its next step is.
#pragma once

#include <cstdint>

namespace kedge
{
/// What a clock has counted, in its ticks.
struct ClockState
{
  std::int64_t position = 0, size = 0;
  unsigned int cuts = 0;
};

/// Counts a stage's progress in ticks, exact fractions of a requested step, so that a stage ends where it should after
/// any sequence of cuts. A failed step is halved; a successful one is followed by one of twice its size, up to the
/// requested size and not across the end of a requested step.
class Clock
{
public:
  /// `n_steps` requested steps, cut down to no less than `minimum_fraction` of one. A part of a step at the end is
  /// rounded to that fraction.
  Clock(double n_steps, double minimum_fraction);

  bool at_end() const { return position == end; }
  /// Size of the current step as a fraction of a requested one.
  double step_fraction() const { return static_cast<double>(size) / ticks_per_step; }
  /// Progress of the stage in requested steps: where it is, and where the current step ends.
  double steps_done() const { return static_cast<double>(position) / ticks_per_step; }
  double steps_after() const { return static_cast<double>(position + size) / ticks_per_step; }
  double requested_steps() const { return static_cast<double>(end) / ticks_per_step; }
  unsigned int cuts() const { return n_cuts; }

  ClockState state() const { return {position, size, n_cuts}; }
  /// Goes on where another clock of the same stage was, or of one that ended earlier.
  void resume(const ClockState& state);

  void advance();
  /// Halves the step; false where it is already the smallest allowed.
  bool cut();

private:
  void stop_at_requested_steps();

  std::int64_t ticks_per_step, end, position = 0, size;
  unsigned int n_cuts = 0;
};
} // namespace kedge
