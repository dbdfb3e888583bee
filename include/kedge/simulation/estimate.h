// What a scene costs, told before it runs.
#pragma once

#include <kedge/simulation/input.h>
#include <string>
#include <vector>

namespace kedge
{
struct StageEstimate
{
  double cells, dofs, particles; ///< cells that hold soil, unknowns, material points
  unsigned int steps;
  double memory;  ///< bytes over all ranks
  double seconds; ///< on one core
};

/// Counts cells, unknowns and material points from the sizes alone. Time and memory come from rates measured on one
/// core of a server; they tell minutes from hours, no more.
std::vector<StageEstimate> estimate_cost(const Input& input);

/// The table that `kedge check` prints.
std::string format_estimate(const Input& input, const std::vector<StageEstimate>& stages);
} // namespace kedge
