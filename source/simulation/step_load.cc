#include <algorithm>
#include <kedge/simulation/step_load.h>

namespace kedge
{
namespace
{
/// Smallest part of the unbalanced forces, and largest number of trials.
constexpr double least_share_balanced = 1. / 64.;
constexpr unsigned int most_trials = 30;
} // namespace

StepLoad load_at(const Clock& clock, const Stage& stage, const RigidSystems& bodies, const bool first)
{
  const SteppingParameters& stepping = stage.stepping;
  StepLoad load;
  load.gravity_factor = stepping.load == GravityLoad::ramp ? clock.steps_after() / clock.requested_steps() : 1.;
  load.start_time = clock.steps_done() * step_length(stepping);
  load.end_time = clock.steps_after() * step_length(stepping);
  load.step_fraction = clock.step_fraction();
  load.newmark = {stepping.beta, stepping.gamma,
                  stepping.type == StageType::dynamic ? clock.step_fraction() * stepping.dt : 0.};
  load.begins_stage = first;
  for (const RigidPoint& point : bodies.points)
    load.body_increments.push_back(stage.rigid_bodies ? point.prescribed_increment(clock.step_fraction())
                                                      : Vector6::Zero());
  return load;
}

bool balance_in_parts(const Clock& clock, const Stage& stage, const RigidSystems& bodies,
                      const std::function<bool(const StepLoad&)>& attempt)
{
  StepLoad load = load_at(clock, stage, bodies, false);
  if (stage.stepping.load == GravityLoad::ramp)
    load.gravity_factor = clock.steps_done() / clock.requested_steps();
  load.end_time = load.start_time;
  load.step_fraction = 1.;
  for (Vector6& increment : load.body_increments)
    increment.setZero();
  load.share_balanced = 0.5;
  for (unsigned int trials = 0; trials < most_trials && load.share_balanced >= least_share_balanced; ++trials)
    if (attempt(load))
    {
      if (load.share_balanced == 1.)
        return true;
      load.share_balanced = std::min(1., 2. * load.share_balanced);
    }
    else
      load.share_balanced *= 0.5;
  return false;
}
} // namespace kedge
