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
  size = state.size;
  n_cuts = state.cuts;
}

void Clock::advance()
{
  position += size;
  const std::int64_t to_next_requested = ticks_per_step - position % ticks_per_step;
  size = std::min({2 * size, to_next_requested, end - position});
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
