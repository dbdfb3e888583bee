// Rules between sections of the input.
#pragma once

#include <kedge/parameters/place.h>
#include <kedge/simulation/input.h>

namespace kedge
{
/// Throws InputError for the first stage or layer that does not fit the rest of the input. `root` is the whole
/// document.
void check_consistency(const Input& input, const schema::Place& root);
} // namespace kedge
