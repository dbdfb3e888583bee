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

void refuse_in_explicit_stage(const Stage& stage, const Input& input, const std::string& path)
{
  if (!stage.rigid_bodies)
    return;
  if (input.contact.method == ContactMethod::augmented_lagrangian)
    refuse("contact.method", "\"augmented lagrangian\" in an explicit stage", "use \"penalty\"");
  for (std::size_t i = 0; i < input.systems.size(); ++i)
    for (std::size_t k = 0; k < input.systems[i].points.size(); ++k)
      for (const DofCondition& condition : conditions_in(stage, input, i, k))
        if (condition.kind == DofCondition::Kind::free)
          refuse(path + ".type",
                 "a free rigid point (" + std::to_string(k + 1) + " of system " + std::to_string(i + 1) +
                     ") in an explicit stage",
                 "set its conditions in the stage to \"fixed\" or \"prescribed\", or make the stage \"dynamic\"");
}
} // namespace

void refuse_unavailable_features(const Input& input)
{
  for (std::size_t i = 0; i < input.stages.size(); ++i)
    if (input.stages[i].stepping.type == StageType::explicit_)
      refuse_in_explicit_stage(input.stages[i], input, entry("analysis", i));
}
} // namespace kedge
