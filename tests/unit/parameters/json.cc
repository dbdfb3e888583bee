#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/parameters/json.h>

using namespace kedge;
using namespace kedge::schema;

namespace
{
std::string error_of(const std::string& text)
{
  try
  {
    parse_json(text, "file.json");
  }
  catch (const InputError& error)
  {
    return error.what();
  }
  return "accepted";
}
Json overridden(const std::string& assignment)
{
  Json document =
      parse_json(R"({"solver": {"tolerance": 1}, "analysis": [{"type": "static"}, {"load steps": 5}]})", "");
  apply_override(document, assignment);
  return document;
}
} // namespace

TEST(ParseJson, AgreesWithLibraryOnNestedDocument)
{
  const std::string text = R"({"b": [1, -2, 2.5, null, true, "x", [], {}], "a": {"c": {"d": [[1], [2, 3]]}}})";
  EXPECT_EQ(parse_json(text, ""), Json::parse(text));
}

TEST(ParseJson, KeepsOrderOfKeys) { EXPECT_EQ(parse_json(R"({"b": 1, "a": 2})", "").dump(), R"({"b":1,"a":2})"); }

TEST(ParseJson, CountsLineAndColumnOfSyntaxError)
{
  EXPECT_EQ(error_of("{\n  \"a\": 1,\n  \"b\": ?\n}").substr(0, 33), "file.json: line 3, column 8: inva");
  EXPECT_EQ(error_of("?").substr(0, 28), "file.json: line 1, column 1:");
}

TEST(ParseJson, ReportsTextThatEndsEarlyAtItsEnd)
{
  EXPECT_EQ(error_of("{\"a\": 1").substr(0, 29), "file.json: line 1, column 8: ");
}

TEST(ParseJson, AcceptsSameKeyInDifferentObjects)
{
  EXPECT_EQ(error_of(R"({"a": {"x": 1}, "b": {"x": 1, "a": 2}, "c": [{"x": 1}, {"x": 1}]})"), "accepted");
}

TEST(ParseJson, RefusesKeyGivenTwiceWithItsPath)
{
  EXPECT_EQ(error_of(R"({"a": [1, {"b": {"x": 1, "x": 1}}]})"),
            "a[1].b.x: the key is given twice in file.json; keep one of the two");
}

TEST(ApplyOverride, ReplacesValueInList)
{
  EXPECT_EQ(overridden("analysis.1.load steps=40")["analysis"][1]["load steps"], 40);
}

TEST(ApplyOverride, TakesPathAsErrorsWriteIt)
{
  EXPECT_EQ(overridden("analysis[1].load steps=40")["analysis"][1]["load steps"], 40);
}

TEST(ApplyOverride, TakesBareWordAsText)
{
  EXPECT_EQ(overridden("analysis.0.type=dynamic")["analysis"][0]["type"], "dynamic");
}

TEST(ApplyOverride, KeepsEqualsSignInValue) { EXPECT_EQ(overridden("comment=a=b")["comment"], "a=b"); }

TEST(ApplyOverride, AddsKeysThatDoNotExist)
{
  EXPECT_EQ(overridden("solver.linear.kind=\"direct\"")["solver"]["linear"]["kind"], "direct");
}

TEST(ApplyOverride, TakesWholeObjects)
{
  EXPECT_EQ(overridden("analysis=[{\"type\": \"static\"}]")["analysis"].size(), 1u);
}

TEST(Shown, ShortensLongText) { EXPECT_EQ(shown(std::string(200, 'a')).size(), 60u); }
