#include "input_rules.h"
#include <kedge/base/exceptions.h>

namespace kedge
{
namespace
{
[[noreturn]] void refuse(const std::string& path, const std::string& feature, const std::string& remedy)
{
  throw InputError(path, feature + " is not available yet in this version", remedy);
}

std::string entry(const std::string& list, std::size_t position) { return list + "[" + std::to_string(position) + "]"; }

/// Path of the conditions that hold for a point in a stage.
std::string conditions_path(const Stage& stage, const std::string& stage_path, std::size_t system, std::size_t point)
{
  for (std::size_t i = 0; i < stage.point_conditions.size(); ++i)
    if (stage.point_conditions[i].system == system + 1 && stage.point_conditions[i].point == point + 1)
      return entry(stage_path + ".rigid body boundary conditions", i) + ".boundary conditions";
  return entry(entry("rigid bodies", system) + ".points", point) + ".boundary conditions";
}

void refuse_free_points(const Input& input, const Stage& stage, const std::string& path)
{
  const std::size_t dofs = input.dimension == 2 ? 3 : 6;
  for (std::size_t system = 0; system < input.systems.size(); ++system)
    for (std::size_t point = 0; point < input.systems[system].points.size(); ++point)
      for (std::size_t dof = 0; dof < dofs; ++dof)
        if (conditions_in(stage, input, system, point)[dof].kind == DofCondition::Kind::free)
          refuse(entry(conditions_path(stage, path, system, point), dof), "a free rigid body (stage " + path + ")",
                 "hold it with \"fixed\" or move it with {\"prescribed\": q}");
}

void refuse_in_stage(const Input& input, const Stage& stage, const std::string& path)
{
  if (stage.stepping.type == StageType::explicit_)
    refuse(path + ".type", "the stage type \"explicit\"", "use \"static\" or \"dynamic\"");
  if (stage.rigid_bodies)
    refuse_free_points(input, stage, path);
}
} // namespace

void refuse_unavailable_features(const Input& input)
{
  if (input.dimension == 2)
    refuse("dimension", "plane strain", "set it to 3 and model a slice one cell thick between rollers");
  if (input.contact.method == ContactMethod::augmented_lagrangian)
    refuse("contact.method", "the augmented Lagrangian method", "use \"penalty\"");
  for (std::size_t i = 0; i < input.stages.size(); ++i)
    refuse_in_stage(input, input.stages[i], entry("analysis", i));
  if (!input.output.checkpoint_every.empty())
    refuse("output.checkpoint every", "writing restart files", "remove the key");
}
} // namespace kedge
