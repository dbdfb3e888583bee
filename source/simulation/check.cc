#include <fmt/format.h>
#include <kedge/parameters/json.h>
#include <kedge/simulation/check.h>
#include <kedge/simulation/scene_warnings.h>
#include <kedge/simulation/version.h>

namespace kedge
{
using schema::Json;

CheckResult check_scene(const Input& input)
{
  const RigidSystems bodies = make_rigid_systems(input.systems, input.dimension);
  return {find_warnings(input, bodies), estimate_cost(input)};
}

std::string format_check(const Input& input, const CheckResult& result, const std::string& name)
{
  std::string text = name + ": valid\n";
  for (const std::string& warning : result.warnings)
    text += "warning: " + warning + "\n";
  return text + format_estimate(input, result.stages);
}

std::string check_as_json(const Input& input, const CheckResult& result)
{
  Json stages = Json::array();
  for (std::size_t i = 0; i < result.stages.size(); ++i)
  {
    const StageEstimate& stage = result.stages[i];
    stages.push_back({{"type", name_of(input.stages[i].stepping.type)},
                      {"steps", stage.steps},
                      {"cells", stage.cells},
                      {"dofs", stage.dofs},
                      {"points", stage.particles},
                      {"counting stopped", stage.counting_stopped},
                      {"memory", stage.memory},
                      {"time", stage.seconds}});
    if (stage.critical_time_step > 0.)
      stages.back()["critical time step"] = stage.critical_time_step;
  }
  const Json json = {{"version", version()},
                     {"commit", commit()},
                     {"warnings", result.warnings},
                     {"input", Json::parse(input.effective_json)},
                     {"stages", stages}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}
} // namespace kedge
