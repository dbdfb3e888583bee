// What `kedge check` prints about an input: warnings and the cost of a run, as text or as JSON.
#pragma once

#include <kedge/simulation/estimate.h>
#include <string>
#include <vector>

namespace kedge
{
struct CheckResult
{
  std::vector<std::string> warnings;
  std::vector<StageEstimate> stages;
  std::vector<std::string> columns; ///< of rigid_body.csv
};

CheckResult check_scene(const Input& input);

/// For people: `name` of the input, warnings, the table of stages.
std::string format_check(const Input& input, const CheckResult& result, const std::string& name);

/// For programs: one object on one line with `version`, `commit`, `warnings`, `input`, `stages` (bytes and seconds) and
/// `columns` of rigid_body.csv.
std::string check_as_json(const Input& input, const CheckResult& result);
} // namespace kedge
