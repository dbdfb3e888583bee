#include <algorithm>
#include <cmath>
#include <kedge/time/clock.h>

namespace kedge
{
Clock::Clock(const double n_steps, const double minimum_fraction)
    : ticks_per_step(std::int64_t(1) << std::lround(std::max(0., std::ceil(-std::log2(minimum_fraction))))),
      end(std::max(1ll, std::llround(ticks_per_step * n_steps))),
      size(std::min(ticks_per_step, end))
{
}

void Clock::resume(const ClockState& state)
{
  position = state.position;
  size = state.size > 0 ? state.size : ticks_per_step; // the other clock was at its end
  n_cuts = state.cuts;
  stop_at_requested_steps();
}

void Clock::advance()
{
  position += size;
  size *= 2;
  stop_at_requested_steps();
}

void Clock::stop_at_requested_steps()
{
  size = std::min({size, ticks_per_step - position % ticks_per_step, end - position});
}

bool Clock::cut()
{
  if (size <= 1)
    return false;
  size /= 2;
  ++n_cuts;
  return true;
}
} // namespace kedge
