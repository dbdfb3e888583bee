// Decides which steps of a stage are written.
#pragma once

#include <algorithm>
#include <cmath>

namespace kedge
{
/// Every max(1, round(N percent / 100)) converged steps of a stage of N steps, and always the last one.
class OutputSchedule
{
public:
  explicit OutputSchedule(double percent) : percent(percent) {}

  void begin_stage(unsigned int n_steps) { interval = std::max(1l, std::lround(n_steps * percent / 100.)); }
  /// `step` counts the converged steps of the stage from 1; cuts may make it exceed N.
  bool due(unsigned int step, bool last_of_stage) const { return last_of_stage || step % interval == 0; }

private:
  double percent;
  unsigned long interval = 1;
};
} // namespace kedge
