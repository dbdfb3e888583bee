#include <cctype>
#include <kedge/base/exceptions.h>
#include <kedge/parameters/expression.h>
#include <kedge/parameters/section.h>
#include <set>
#ifdef KEDGE_WITH_MUPARSER
#include <muParser.h>
#endif

namespace kedge
{
using namespace schema;

#ifdef KEDGE_WITH_MUPARSER
namespace
{
/// muParser would let "a = b" change a variable.
bool has_assignment(const std::string& text)
{
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '=')
    {
      const bool is_comparison = (i > 0 && std::string("<>!=").find(text[i - 1]) != std::string::npos) ||
                                 (i + 1 < text.size() && text[i + 1] == '=');
      if (!is_comparison)
        return true;
    }
  return false;
}

bool is_name(const std::string& text)
{
  if (text.empty() || std::isdigit(static_cast<unsigned char>(text[0])))
    return false;
  for (const unsigned char c : text)
    if (!std::isalnum(c) && c != '_')
      return false;
  return true;
}

std::string join(const std::vector<std::string>& names)
{
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "" : ", ") + name;
  return text;
}
} // namespace

struct Expression::Content
{
  std::size_t n_variables = 0;
  std::vector<std::string> names; ///< of variables, then of definitions
  std::vector<double> values;     ///< the same; its place in memory stays
  std::vector<mu::Parser> definitions, components;
  std::set<std::string> used;

  /// A text that may use the first `n_names` names.
  mu::Parser compile(const std::string& text, const std::size_t n_names, const std::string& path)
  {
    const auto fail = [&](const std::string& problem)
    {
      const std::vector<std::string> known(names.begin(), names.begin() + n_names);
      throw InputError(path, "\"" + text + "\": " + problem,
                       "the names here are " + join(known) + ", pi and functions such as sin, sqrt, min");
    };
    if (has_assignment(text))
      fail("an expression cannot assign values");
    mu::Parser parser;
    try
    {
      parser.DefineConst("pi", M_PI);
      for (std::size_t i = 0; i < n_names; ++i)
        parser.DefineVar(names[i], &values[i]);
      parser.SetExpr(text);
      for (const auto& [name, place] : parser.GetUsedVar())
      {
        if (std::find(names.begin(), names.begin() + n_names, name) == names.begin() + n_names)
          fail("unknown name \"" + name + "\"");
        used.insert(name);
      }
      parser.Eval();
      if (parser.GetNumResults() != 1)
        fail("expected one value, found " + std::to_string(parser.GetNumResults()));
    }
    catch (const mu::Parser::exception_type& error)
    {
      fail(error.GetMsg());
    }
    return parser;
  }
};

Expression::Expression(const ExpressionText& text, const std::vector<std::string>& variables)
    : content(std::make_unique<Content>())
{
  Content& c = *content;
  c.n_variables = variables.size();
  c.names = variables;
  c.values.assign(variables.size() + text.definitions.size(), 0.5); // for the trial evaluation
  for (const auto& [name, definition] : text.definitions)
  {
    const std::string path = text.path + ".definitions." + name;
    if (!is_name(name))
      throw InputError(path, "a name consists of letters, digits and _", "rename it");
    if (name == "pi" || std::find(c.names.begin(), c.names.end(), name) != c.names.end() ||
        mu::Parser().GetFunDef().count(name) > 0)
      throw InputError(path, "\"" + name + "\" has a meaning already", "rename it");
    c.definitions.push_back(c.compile(definition, c.names.size(), path));
    c.names.push_back(name);
  }
  for (std::size_t i = 0; i < text.components.size(); ++i)
    c.components.push_back(
        c.compile(text.components[i], c.names.size(), text.path + ".expression[" + std::to_string(i) + "]"));
}

void Expression::evaluate(const double* variables, double* components) const
{
  Content& c = *content;
  std::copy_n(variables, c.n_variables, c.values.begin());
  for (std::size_t i = 0; i < c.definitions.size(); ++i)
    c.values[c.n_variables + i] = c.definitions[i].Eval();
  for (std::size_t i = 0; i < c.components.size(); ++i)
    components[i] = c.components[i].Eval();
}

std::size_t Expression::n_components() const { return content->components.size(); }

bool Expression::uses(const std::string& variable) const { return content->used.count(variable) > 0; }

#else

struct Expression::Content
{
};

Expression::Expression(const ExpressionText& text, const std::vector<std::string>&)
{
  throw InputError(text.path, "this program was built without muParser, which evaluates expressions",
                   "install its development files (Debian: libmuparser-dev) and build again");
}

void Expression::evaluate(const double*, double*) const {}

std::size_t Expression::n_components() const { return 0; }

bool Expression::uses(const std::string&) const { return false; }

#endif

Expression::~Expression() = default;

namespace
{
/// The text of an expression. A number is kept with all its digits.
Format<std::string> expression_text(const std::string& unit)
{
  Format<std::string> format;
  format.expects = "a number or an expression in quotes";
  format.unit = unit;
  format.schema = {{"anyOf", {{{"type", "number"}}, {{"type", "string"}}}}};
  format.read = [expects = format.expects](const Json& json, const Place& place)
  {
    if (!json.is_number() && (!json.is_string() || json.get<std::string>().empty()))
      place.expected(expects, shown(json));
    return json.is_string() ? json.get<std::string>() : json.dump();
  };
  return format;
}

using Definitions = std::vector<std::pair<std::string, std::string>>;

Format<Definitions> definitions()
{
  const Format<std::string> text = expression_text("");
  Format<Definitions> format;
  format.expects = "an object of names, each with a number or an expression in quotes";
  format.schema = {{"type", "object"}, {"additionalProperties", text.schema}};
  format.read = [expects = format.expects, text](const Json& json, const Place& place)
  {
    if (!json.is_object())
      place.expected(expects, shown(json));
    Definitions result;
    for (const auto& [name, value] : json.items())
      if (name != "comment")
        result.emplace_back(name, text.read(value, place.key(name)));
    return result;
  };
  return format;
}
} // namespace

Format<ExpressionText>
expression_along_axes(const std::string& unit,
                      const std::function<std::vector<std::string>(unsigned int dimension)>& variables)
{
  Section<ExpressionText> section("A function as text");
  const auto set = [](ExpressionText& into, const std::array<std::string, 3>& components)
  {
    for (const std::string& component : components)
      if (!component.empty()) // those of axes that there are
        into.components.push_back(component);
  };
  std::string names;
  for (const std::string& name : variables(3))
    names += (names.empty() ? "" : ", ") + name;
  section.required("expression", set, fixed_list<3>(expression_text(unit), axes()),
                   "Components, functions of " + names + " (2-D: without Y and y)");
  section.optional("definitions", &ExpressionText::definitions, definitions(),
                   "Names for intermediate values, each a number or an expression that may use those before it");
  Format<ExpressionText> format = object_of(section);
  format.read = [read = format.read, variables](const Json& json, const Place& place)
  {
    ExpressionText text = read(json, place);
    text.path = place.path();
    const Expression compiles(text, variables(place.context().dimension));
    return text;
  };
  return format;
}
} // namespace kedge
