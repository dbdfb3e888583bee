#include <kedge/base/exceptions.h>
#include <kedge/simulation/input.h>

namespace kedge
{
void refuse_unavailable_features(const Input& input)
{
  for (const Stage& stage : input.stages)
    if (stage.stepping.type == StageType::explicit_ && stage.rigid_bodies &&
        input.contact.method == ContactMethod::augmented_lagrangian)
      throw InputError("contact.method",
                       "\"augmented lagrangian\" in an explicit stage is not available yet in this version",
                       "use \"penalty\"");
}
} // namespace kedge
