// Every refusal of tests/bad_input: the error names the place, the problem and the remedy.
#include "input_files.h"
#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/parameters/json.h>
#include <kedge/simulation/input.h>

using namespace kedge;
using schema::Json;

namespace
{
const std::filesystem::path folder = input_files::root() / "tests" / "bad_input";

std::vector<Json> cases() { return Json::parse(input_files::contents(folder / "cases.json")).get<std::vector<Json>>(); }

std::string spoilt_text(const Json& spoiling)
{
  if (spoiling.contains("text"))
    return spoiling.at("text").get<std::string>();
  Json document = Json::parse(input_files::contents(folder / "base.json"));
  const Json set = spoiling.value("set", Json::object()), remove = spoiling.value("remove", Json::array());
  for (const auto& [pointer, value] : set.items())
    document[Json::json_pointer(pointer)] = value;
  for (const auto& pointer : remove)
  {
    const Json::json_pointer key(pointer.get<std::string>());
    document[key.parent_pointer()].erase(key.back());
  }
  return document.dump();
}

class BadInput : public testing::TestWithParam<Json>
{
protected:
  input_files::Folder files;
};

std::string test_name(const testing::TestParamInfo<Json>& info)
{
  std::string name = info.param.at("name").get<std::string>();
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}
} // namespace

TEST_P(BadInput, IsRefusedWithPlaceProblemAndRemedy)
{
  const Json& expected = GetParam();
  const std::string text = spoilt_text(expected);
  const auto overrides = expected.value("overrides", Json::array()).get<std::vector<std::string>>();
  const auto read = [&] { return parse_input(text, files.path.string(), "input", overrides); };
  try
  {
    if (expected.value("available", true))
      read();
    else
      refuse_unavailable_features([&] { // well-formed, so reading it must not throw
        try
        {
          return read();
        }
        catch (const InputError& error)
        {
          ADD_FAILURE() << "not even well-formed: " << error.what();
          return Input();
        }
      }());
    FAIL() << "accepted";
  }
  catch (const InputError& error)
  {
    const std::string message = error.what();
    EXPECT_EQ(error.path, expected.at("path").get<std::string>()) << message;
    const std::size_t problem = message.find(expected.at("problem").get<std::string>(), error.path.size());
    EXPECT_NE(problem, std::string::npos) << message;
    const std::size_t semicolon = message.find("; ", error.path.size());
    EXPECT_NE(message.find(expected.at("remedy").get<std::string>(), semicolon), std::string::npos) << message;
    EXPECT_LE(std::count(message.begin(), message.end(), '\n'), 1) << message;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, BadInput, testing::ValuesIn(cases()), test_name);

TEST(BadInputBase, IsGoodInput)
{
  const input_files::Folder files;
  const Input input = parse_input(input_files::contents(folder / "base.json"), files.path.string());
  EXPECT_NO_THROW(refuse_unavailable_features(input));
}
