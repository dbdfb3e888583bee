#include "size_limits.h"
#include <fmt/format.h>
#include <kedge/output/history.h>
#include <kedge/parameters/json.h>
#include <kedge/simulation/check.h>
#include <kedge/simulation/layout.h>
#include <kedge/simulation/scene_warnings.h>
#include <kedge/simulation/version.h>

namespace kedge
{
using schema::Json;

namespace
{
/// A scene may be checked on a laptop and run on a cluster of so many of them.
constexpr double largest_share = 1000.;
} // namespace

CheckResult check_scene(const Input& input)
{
  refuse_excessive_size(input, largest_share * memory_of_machine(),
                        fmt::format("{:g} machines like this one", largest_share));
  const RigidSystems bodies = make_rigid_systems(input.systems, input.dimension);
  CheckResult result{find_warnings(input, bodies), estimate_cost(input),
                     history_columns(bodies, select_body_fields(input.output.csv.body_fields))};
  if (const double bytes = least_size(input).bytes; bytes > memory_of_machine())
    result.warnings.push_back(fmt::format("the scene needs at least {:.3g} GB, more than the {:.3g} GB of this machine",
                                          1e-9 * bytes, 1e-9 * memory_of_machine()));
  return result;
}

std::string format_check(const Input& input, const CheckResult& result, const std::string& name)
{
  std::string text = name + ": valid\n";
  for (const std::string& warning : result.warnings)
    text += "warning: " + warning + "\n";
  text += "Soil: " + describe_block(input).text + ".\n";
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
                     {"stages", stages},
                     {"columns", result.columns}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}
} // namespace kedge
