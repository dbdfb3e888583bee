// Functions that the input gives as text.
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/parameters/expression.h>

using namespace kedge;
using namespace kedge::schema;

namespace
{
std::vector<std::string> variables(const unsigned int dim)
{
  return dim == 2 ? std::vector<std::string>{"X", "Z", "t"} : std::vector<std::string>{"X", "Y", "Z", "t"};
}

ExpressionText read(const std::string& text, const unsigned int dim = 2)
{
  InputContext context;
  context.dimension = dim;
  return expression_along_axes("m/s2", variables).read(Json::parse(text), Place(context).key("body force"));
}

/// At X = 3, Z = 4, t = 0.5.
std::array<double, 2> evaluate(const ExpressionText& text)
{
  const double values[] = {3., 4., 0.5};
  std::array<double, 2> result;
  Expression(text, variables(2)).evaluate(values, result.data());
  return result;
}

/// That a text is refused at a path, with these words.
void expect_refusal(const std::string& text, const std::string& path, const std::string& words)
{
  try
  {
    read(text);
    ADD_FAILURE() << text << " is not refused";
  }
  catch (const InputError& error)
  {
    EXPECT_EQ(error.path, path) << text;
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}
} // namespace

TEST(Expression, UsesVariablesFunctionsAndPi)
{
  const auto value =
      evaluate(read(R"json({"expression": ["-X^2 + sqrt(X^2 + Z^2) * t", "sin(pi * t) + atan2(Z, X)"]})json"));
  EXPECT_DOUBLE_EQ(value[0], -9. + 2.5);
  EXPECT_DOUBLE_EQ(value[1], 1. + std::atan2(4., 3.));
}

TEST(Expression, DefinitionsUseThoseBeforeThem)
{
  const ExpressionText text = read(R"json({"definitions": {"comment": "radius", "b": 0.1, "R": "sqrt(X^2 + Z^2)",
    "a": "b * R"}, "expression": ["a", "R >= 5 && t < 1 ? a * R : 0"]})json");
  EXPECT_EQ(text.definitions.size(), 3u);
  const auto value = evaluate(text);
  EXPECT_DOUBLE_EQ(value[0], 0.5);
  EXPECT_DOUBLE_EQ(value[1], 2.5);
}

TEST(Expression, NumbersKeepTheirDigits)
{
  const auto value = evaluate(read(R"json({"expression": [0.1234567890123456, -1e-300]})json"));
  EXPECT_EQ(value[0], 0.1234567890123456);
  EXPECT_EQ(value[1], -1e-300);
}

TEST(Expression, KnowsWhichVariablesItUses)
{
  const Expression expression(read(R"json({"definitions": {"s": "2 * t"}, "expression": ["X", "s"]})json"),
                              variables(2));
  EXPECT_TRUE(expression.uses("X"));
  EXPECT_TRUE(expression.uses("t"));
  EXPECT_FALSE(expression.uses("Z"));
  EXPECT_EQ(expression.n_components(), 2u);
}

TEST(Expression, RefusesWhatItCannotEvaluateAndNamesThePlace)
{
  const std::string first = "body force.expression[0]";
  expect_refusal(R"json({"expression": ["X +", 0]})json", first, "X +");
  expect_refusal(R"json({"expression": ["sin(X", 0]})json", first, "sin(X");
  expect_refusal(R"json({"expression": [0, "Q * 2"]})json", "body force.expression[1]", "unknown name \"Q\"");
  expect_refusal(R"json({"expression": ["foo(X)", 0]})json", first, "foo(X)");
  expect_refusal(R"json({"expression": ["Y", 0]})json", first, "the names here are X, Z, t");
  expect_refusal(R"json({"expression": ["X = 2", 0]})json", first, "cannot assign");
  expect_refusal(R"json({"expression": ["X, Z", 0]})json", first, "expected one value");
  expect_refusal(R"json({"expression": ["", 0]})json", first, "expression in quotes");
  expect_refusal(R"json({"expression": ["X"]})json", "body force.expression", "[x, z]");
  const std::string rest = R"json(, "expression": [0, 0]})json";
  expect_refusal(R"json({"definitions": {"a": "b", "b": 1})json" + rest, "body force.definitions.a",
                 "unknown name \"b\"");
  expect_refusal(R"json({"definitions": {"X": 1})json" + rest, "body force.definitions.X", "has a meaning already");
  expect_refusal(R"json({"definitions": {"sin": 1})json" + rest, "body force.definitions.sin", "has a meaning already");
  expect_refusal(R"json({"definitions": {"a b": 1})json" + rest, "body force.definitions.a b", "letters, digits");
  expect_refusal(R"json({"definitions": {"a": [1]})json" + rest, "body force.definitions.a", "expression in quotes");
}
