// What acts in a step of a stage, and steps in which nothing new acts.
#pragma once

#include <functional>
#include <kedge/steps/trial_step.h>
#include <kedge/time/clock.h>

namespace kedge
{
/// The load of the clock's step. `first`: of the stage.
StepLoad load_at(const Clock& clock, const Stage& stage, const RigidSystems& bodies, bool first);

/// A new mesh, split points or a new basis leave forces at the start of a step that nothing balances. No cut of the
/// load makes them smaller, but they can be balanced part by part, with bodies and load as they are at the clock's
/// position. `attempt` solves for a load and commits what it finds; it returns whether there was a solution. Returns
/// whether all is balanced in the end.
bool balance_in_parts(const Clock& clock, const Stage& stage, const RigidSystems& bodies,
                      const std::function<bool(const StepLoad&)>& attempt);
} // namespace kedge
