// What an input may say but hardly means.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <kedge/simulation/input.h>
#include <string>
#include <vector>

namespace kedge
{
/// Warnings for a scene as it begins: edges that soil may slip past, bodies and fine boxes where there is no grid,
/// bodies within soil that nobody takes out, and base cells that are smaller than asked for. Throws InputError where a
/// stage's steps cannot be made in parts that are short enough for the cells.
std::vector<std::string> find_warnings(const Input& input, const RigidSystems& bodies);
} // namespace kedge
