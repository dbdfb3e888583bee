// What a scene costs, told before it runs.
#pragma once

#include <kedge/simulation/input.h>
#include <string>
#include <vector>

namespace kedge
{
struct StageEstimate
{
  double cells = 0., dofs = 0., particles = 0.; ///< cells that hold soil, unknowns, material points
  bool counting_stopped = false;                ///< the cells at the surfaces are more than these
  unsigned int steps = 0;
  double critical_time_step = 0.; ///< of explicit stages, for the soil alone in regular cells, s
  double memory = 0.;             ///< bytes on one rank
  double seconds = 0.;            ///< on one core
};

/// Counts cells, unknowns and material points at the start of every stage. Where bodies refine the mesh, it is built
/// around them, where their prescribed motion takes them; what they refine as they move and the soil's motion are left
/// out. Counting stops before a level of refinement that would hold more than `most_particles`. Time and memory come
/// from rates measured on one core of a server; they tell minutes from hours, no more.
std::vector<StageEstimate> estimate_cost(const Input& input, double most_particles = 2e5);

/// The table that `kedge check` prints.
std::string format_estimate(const Input& input, const std::vector<StageEstimate>& stages);
} // namespace kedge
