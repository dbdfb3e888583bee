// Decides which steps of a stage are written.
#pragma once

#include <algorithm>
#include <cmath>

namespace kedge
{
/// Progress of a stage in requested steps, before and after a converged step.
struct StepSpan
{
  double begin, end;
};

/// Every max(1, round(N percent / 100)) requested steps of a stage of N steps, however many parts they are made in; 0
/// percent: every part. Always the last one.
class OutputSchedule
{
public:
  explicit OutputSchedule(double percent) : percent(percent) {}

  void begin_stage(unsigned int n_steps) { interval = std::max(1., std::round(n_steps * percent / 100.)); }

  bool due(const StepSpan& step, bool last_of_stage) const
  {
    return last_of_stage || percent == 0. || std::floor(step.end / interval) > std::floor(step.begin / interval);
  }

private:
  double percent, interval = 1.;
};
} // namespace kedge
