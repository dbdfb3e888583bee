#include <kedge/base/exceptions.h>
#include <kedge/simulation/input.h>

namespace kedge
{
namespace
{
[[noreturn]] void refuse(const std::string& path, const std::string& feature, const std::string& remedy)
{
  throw InputError(path, feature + " is not available yet in this version", remedy);
}

void refuse_in_explicit_stage(const Stage& stage, const Input& input)
{
  if (stage.rigid_bodies && input.contact.method == ContactMethod::augmented_lagrangian)
    refuse("contact.method", "\"augmented lagrangian\" in an explicit stage", "use \"penalty\"");
}
} // namespace

void refuse_unavailable_features(const Input& input)
{
  for (const Stage& stage : input.stages)
    if (stage.stepping.type == StageType::explicit_)
      refuse_in_explicit_stage(stage, input);
}
} // namespace kedge
