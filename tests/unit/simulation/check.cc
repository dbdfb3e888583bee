// What `kedge check` prints.
#include "input_files.h"
#include <gtest/gtest.h>
#include <kedge/parameters/json.h>
#include <kedge/simulation/check.h>
#include <kedge/simulation/version.h>

using namespace kedge;

namespace
{
Input footing() { return read_input((input_files::root() / "prm" / "strip-footing.json").string()); }

CheckResult two_warnings()
{
  CheckResult result;
  result.warnings = {"look out", "mind the \"gap\""};
  result.stages.resize(footing().stages.size());
  StageEstimate& stage = result.stages[0];
  stage.cells = 20.;
  stage.dofs = 62.;
  stage.particles = 80.;
  stage.steps = 7;
  stage.memory = 2.5e8;
  stage.seconds = 0.125;
  return result;
}
} // namespace

TEST(Check, AsJsonHasTheNumbersOfTheTable)
{
  const Input input = footing();
  const std::string text = check_as_json(input, two_warnings());
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  const schema::Json json = schema::parse_json(text, "check");
  EXPECT_EQ(json["version"], version());
  EXPECT_EQ(json["commit"], commit());
  EXPECT_EQ(json["warnings"], schema::Json({"look out", "mind the \"gap\""}));
  EXPECT_EQ(json["input"], schema::Json::parse(input.effective_json));
  ASSERT_EQ(json["stages"].size(), input.stages.size());
  EXPECT_EQ(json["stages"][0].dump(),
            "{\"type\":\"static\",\"steps\":7,\"cells\":20.0,\"dofs\":62.0,\"points\":80.0,\"counting stopped\":false,"
            "\"memory\":250000000.0,\"time\":0.125}");
}

TEST(Check, AsTextNamesTheFileTheWarningsAndTheTable)
{
  const Input input = footing();
  const CheckResult result = two_warnings();
  EXPECT_EQ(format_check(input, result, "a.json"),
            "a.json: valid\nwarning: look out\nwarning: mind the \"gap\"\nSoil: 4 x 2 m.\n" +
                format_estimate(input, result.stages));
}

TEST(Check, CountsAndWarns)
{
  const Input input = read_input((input_files::root() / "prm" / "cube.json").string());
  const CheckResult result = check_scene(input);
  EXPECT_EQ(result.stages.front().particles, 64.);
  EXPECT_EQ(result.warnings.size(), 0u);
}
