// Rules between sections of the input.
#pragma once

#include <kedge/parameters/place.h>
#include <kedge/simulation/input.h>

namespace kedge
{
/// Throws InputError for the first stage or layer that does not fit the rest of the input. `root` is the whole
/// document.
void check_consistency(const Input& input, const schema::Place& root);

/// Conditions of a point in a stage: the stage's own, or else those of the point.
const std::array<DofCondition, 6>& conditions_in(const Stage& stage, const Input& input, std::size_t system,
                                                 std::size_t point);
} // namespace kedge
