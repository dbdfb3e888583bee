// Steps that fit the cells: how far bodies may go in one.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <kedge/steps/stage.h>
#include <string>

namespace kedge
{
/// What the prescribed motion of a stage leaves of its steps.
struct StepLimit
{
  double motion = 0.;       ///< of a surface in a requested step, m
  double cell_size = 0.;    ///< at the surfaces, m
  double fraction = 1.;     ///< of a requested step that a step may take by "largest motion"
  unsigned int n_parts = 1; ///< in which a requested step is made: a power of two

  /// Motion in a requested step over the cell size.
  double in_cells() const { return motion / cell_size; }
};

/// Throws InputError(path) where the steps of a stage cannot be made in parts as small as the limit asks for.
void refuse_long_steps(const StepLimit& limit, const Stage& stage, double minimum_step_fraction,
                       const std::string& path);

/// Why they cannot.
std::string refusal_of(const StepLimit& limit, const Stage& stage, double minimum_step_fraction);

/// `bodies` with the conditions of the stage; `base_size` of the grid, m.
StepLimit find_step_limit(const Stage& stage, const RigidSystems& bodies, double base_size);
} // namespace kedge
