// What a user reads where a step fails at its smallest size.
#pragma once

#include <kedge/simulation/input.h>
#include <kedge/steps/trial_step.h>
#include <kedge/time/clock.h>
#include <string>

namespace kedge
{
/// Where the step is farthest from balance, and what is there, as a sentence; empty where nothing is known.
std::string describe_place(const ResidualPlace& place);

/// What may help, from why Newton's method or the explicit steps gave up and from where the residual sits.
std::string hint_for(const NewtonReport& newton, const ResidualPlace& place, const Stage& stage, const Input& input);

/// All that a user reads: which step, why it failed, the history of the residual, where it sits, what may help.
std::string describe_failure(const Input& input, unsigned int stage_number, const Clock& clock,
                             const NewtonReport& newton, const ResidualPlace& place);
} // namespace kedge
