#include "step_limit.h"
#include <algorithm>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/time/clock.h>

namespace kedge
{
namespace
{
constexpr unsigned int most_parts = 1u << 30;
} // namespace

StepLimit find_step_limit(const Stage& stage, const RigidSystems& bodies, const double base_size)
{
  StepLimit limit;
  limit.cell_size = cell_size_at_surfaces(stage.cells, base_size);
  if (!stage.rigid_bodies)
    return limit;
  limit.motion = largest_prescribed_motion(bodies);
  if (limit.motion > 0.)
    limit.fraction = std::min(1., stage.largest_motion / limit.in_cells());
  while (limit.n_parts < most_parts && limit.n_parts * limit.fraction < 1. - 1e-9)
    limit.n_parts *= 2;
  return limit;
}

void refuse_long_steps(const StepLimit& limit, const Stage& stage, const double minimum_step_fraction,
                       const std::string& path)
{
  if (!Clock(1., minimum_step_fraction).keep_below(limit.fraction))
    throw InputError(path, refusal_of(limit, stage, minimum_step_fraction));
}

std::string refusal_of(const StepLimit& limit, const Stage& stage, const double minimum_step_fraction)
{
  return fmt::format("a body goes {:.3g} m in a step, {:.3g} of the cells at it, which takes {} parts by \"largest "
                     "motion\" ({:.3g}), but \"minimum step fraction\" allows {:.0f}; give the stage more steps",
                     limit.motion, limit.in_cells(), limit.n_parts, stage.largest_motion, 1. / minimum_step_fraction);
}
} // namespace kedge
