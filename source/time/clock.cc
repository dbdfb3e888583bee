#include <algorithm>
#include <cmath>
#include <kedge/time/clock.h>

namespace kedge
{
namespace
{
constexpr unsigned int most_patience = 16, patience_growth = 4;
/// A tick is a requested step halved so often, for stages to end to round-off, or less often for the whole stage to
/// have so many binary digits at most.
constexpr int halvings_of_tick = 40, digits_of_stage = 58;
} // namespace

Clock::Clock(const double n_steps, const double minimum_fraction)
{
  const int cuts = static_cast<int>(std::max(0., std::ceil(-std::log2(minimum_fraction))));
  const int room = digits_of_stage - static_cast<int>(std::ceil(std::log2(std::max(1., n_steps))));
  const int halvings = std::max(cuts, std::min(halvings_of_tick, room));
  now.ticks_per_step = std::int64_t(1) << halvings;
  smallest = std::int64_t(1) << (halvings - cuts);
  now.limit = now.ticks_per_step;
  most = now.ticks_per_step;
  end = std::max(1ll, std::llround(now.ticks_per_step * n_steps));
  stop_at_requested_steps();
}

void Clock::resume(const ClockState& state)
{
  const std::int64_t mine = now.ticks_per_step, finest = std::max(mine, state.ticks_per_step);
  now = state;
  now.ticks_per_step = finest;
  now.position *= finest / state.ticks_per_step;
  now.limit *= finest / state.ticks_per_step;
  end *= finest / mine;
  most = now.ticks_per_step;
  smallest *= finest / mine;
  stop_at_requested_steps();
}

bool Clock::keep_below(const double fraction)
{
  most = now.ticks_per_step;
  while (most > smallest && most > fraction * now.ticks_per_step * (1. + 1e-9))
    most /= 2;
  stop_at_requested_steps();
  return most <= fraction * now.ticks_per_step * (1. + 1e-9);
}

void Clock::advance()
{
  now.position += size;
  if (size == now.limit)
  {
    ++now.made;
    if (now.on_trial)
      now.patience = 1;
    now.on_trial = false;
  }
  if (now.made >= now.patience && now.limit < now.ticks_per_step)
  {
    now.limit *= 2;
    now.made = 0;
    now.on_trial = true;
  }
  stop_at_requested_steps();
}

void Clock::stop_at_requested_steps()
{
  const std::int64_t rest = std::min(now.ticks_per_step - now.position % now.ticks_per_step, end - now.position);
  size = std::min({now.limit, most, rest});
  if (rest > size && rest - size < smallest) // what is left would be too short for a step
    size = rest <= most ? rest : rest / 2;
}

bool Clock::cut()
{
  if (size < 2 * smallest)
    return false;
  if (now.on_trial && size == now.limit)
    now.patience = std::min(most_patience, patience_growth * now.patience);
  now.limit = size /= 2;
  now.made = 0;
  now.on_trial = false;
  ++now.cuts;
  return true;
}
} // namespace kedge
