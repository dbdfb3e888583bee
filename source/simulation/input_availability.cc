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

void refuse_in_stage(const Stage& stage, const std::string& path)
{
  if (stage.stepping.type == StageType::explicit_)
    refuse(path + ".type", "the stage type \"explicit\"", "use \"static\" or \"dynamic\"");
}
} // namespace

void refuse_unavailable_features(const Input& input)
{
  for (std::size_t i = 0; i < input.stages.size(); ++i)
    refuse_in_stage(input.stages[i], entry("analysis", i));
}
} // namespace kedge
