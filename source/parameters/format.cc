#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <kedge/parameters/format.h>
#include <kedge/parameters/words.h>

namespace kedge::schema
{
namespace
{
std::string plain_number(double value)
{
  return Json(std::fabs(value) < 1e15 && value == static_cast<long>(value) ? Json(static_cast<long>(value))
                                                                           : Json(value))
      .dump();
}

/// Beyond this products of a few numbers overflow.
constexpr double largest_number = 1e100;

/// A number in quotes is a frequent mistake, so it has a remedy of its own.
void refuse_quoted_number(const Json& json, const Place& place, const std::string& expects)
{
  if (json.is_string() && Json::parse(json.get<std::string>(), nullptr, false).is_number())
    place.expected(expects, shown(json), "write the number without quotes");
}
} // namespace

Bounds& Bounds::above(double limit)
{
  lower = limit;
  open_below = true;
  return *this;
}

Bounds& Bounds::at_least(double limit)
{
  lower = limit;
  open_below = false;
  return *this;
}

Bounds& Bounds::below(double limit)
{
  upper = limit;
  open_above = true;
  return *this;
}

Bounds& Bounds::at_most(double limit)
{
  upper = limit;
  open_above = false;
  return *this;
}

bool Bounds::hold(double value) const
{
  return (open_below ? value > lower : value >= lower) && (open_above ? value < upper : value <= upper);
}

std::string Bounds::text() const
{
  std::string result;
  if (std::isfinite(lower))
    result += (open_below ? " above " : " of at least ") + plain_number(lower);
  if (std::isfinite(upper))
    result += std::string(result.empty() ? "" : " and") + (open_above ? " below " : " at most ") + plain_number(upper);
  return result;
}

void Bounds::describe(Json& schema) const
{
  if (std::isfinite(lower))
    schema[open_below ? "exclusiveMinimum" : "minimum"] = lower;
  if (std::isfinite(upper))
    schema[open_above ? "exclusiveMaximum" : "maximum"] = upper;
}

Format<double> number(const std::string& unit, const Bounds& bounds)
{
  Format<double> format;
  format.unit = unit;
  format.expects = "a number" + bounds.text() + (unit == "-" ? "" : " (" + unit + ")");
  format.read = [bounds, expects = format.expects](const Json& json, const Place& place)
  {
    refuse_quoted_number(json, place, expects);
    if (!json.is_number() || !bounds.hold(json.get<double>()))
      place.expected(expects, shown(json));
    if (std::fabs(json.get<double>()) > largest_number)
      place.expected(expects + " of a size up to " + plain_number(largest_number), shown(json), "check its unit");
    return json.get<double>();
  };
  format.write = [](const double& value) { return Json(value); };
  format.schema = {{"type", "number"}};
  bounds.describe(format.schema);
  return format;
}

Format<unsigned int> count(const Bounds& bounds)
{
  Format<unsigned int> format;
  format.unit = "-";
  format.expects = "a whole number" + bounds.text();
  format.read = [bounds, expects = format.expects](const Json& json, const Place& place)
  {
    refuse_quoted_number(json, place, expects);
    if (json.is_number_float() && json.get<double>() == std::floor(json.get<double>()))
      place.expected(expects, shown(json), "write it without a decimal point or exponent");
    if (!json.is_number_integer() || !bounds.hold(json.get<double>()) || json.get<double>() < 0 ||
        json.get<double>() > std::numeric_limits<unsigned int>::max())
      place.expected(expects, shown(json));
    return json.get<unsigned int>();
  };
  format.write = [](const unsigned int& value) { return Json(value); };
  format.schema = {{"type", "integer"}};
  bounds.describe(format.schema);
  return format;
}

Format<bool> on_off() { return choice<bool>({{"on", true}, {"off", false}}); }
Format<bool> yes_no() { return choice<bool>({{"yes", true}, {"no", false}}); }

std::size_t read_word(const Json& json, const Place& place, const std::vector<std::string>& words)
{
  const std::string expects = alternatives(words);
  if (json.is_boolean() && words.size() == 2)
    place.expected(expects, shown(json), "write " + quoted(words[json.get<bool>() ? 0 : 1]));
  if (!json.is_string())
    place.expected(expects, shown(json));
  const auto found = std::find(words.begin(), words.end(), json.get<std::string>());
  if (found == words.end())
  {
    const std::string near = nearest(json.get<std::string>(), words);
    place.expected(expects, shown(json), near.empty() ? "" : "did you mean " + quoted(near) + "?");
  }
  return static_cast<std::size_t>(found - words.begin());
}

Format<std::string> word(const std::vector<std::string>& words)
{
  Format<std::string> format;
  format.read = [words](const Json& json, const Place& place) { return words[read_word(json, place, words)]; };
  format.write = [](const std::string& value) { return Json(value); };
  format.expects = alternatives(words);
  format.schema = {{"type", "string"}, {"enum", words}};
  return format;
}

Format<double> number_or(const std::string& word, double value, const Format<double>& number)
{
  Format<double> format;
  format.unit = number.unit;
  format.expects = number.expects + " or " + quoted(word);
  format.read = [=, expects = format.expects](const Json& json, const Place& place)
  {
    if (json.is_string() && json.get<std::string>() == word)
      return value;
    if (!json.is_number())
      place.expected(expects, shown(json));
    return number.read(json, place);
  };
  format.write = [word, value](const double& v) { return v == value ? Json(word) : Json(v); };
  format.schema = {{"anyOf", {number.schema, {{"const", word}}}}};
  return format;
}

namespace
{
Format<std::string> text(const std::string& expects)
{
  Format<std::string> format;
  format.expects = expects;
  format.write = [](const std::string& value) { return Json(value); };
  format.schema = {{"type", "string"}, {"minLength", 1}};
  return format;
}

std::string read_text(const Json& json, const Place& place, const std::string& expects)
{
  if (!json.is_string() || json.get<std::string>().empty())
    place.expected(expects, shown(json));
  return json.get<std::string>();
}
} // namespace

Format<std::string> existing_file()
{
  Format<std::string> format = text("the path of a file");
  format.read = [expects = format.expects](const Json& json, const Place& place)
  {
    namespace fs = std::filesystem;
    const fs::path path = fs::path(place.context().folder) / read_text(json, place, expects);
    std::error_code ignored;
    if (!fs::exists(path, ignored))
      place.fail("there is no file " + quoted(path.string()),
                 "correct the path; it is relative to the folder of the input file");
    if (!fs::is_regular_file(path, ignored) || !std::ifstream(path)) // a pipe would wait for its writer
      place.fail(quoted(path.string()) + " cannot be read as a file", "name a file that you may read");
    return path.string();
  };
  return format;
}

Format<std::string> output_folder()
{
  Format<std::string> format = text("the name of a folder below the run's output folder");
  format.read = [expects = format.expects](const Json& json, const Place& place)
  {
    const std::string name = read_text(json, place, expects);
    const std::filesystem::path path(name);
    if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
      place.expected(expects, quoted(name), "give a relative path without \"..\"");
    return name;
  };
  return format;
}

void require_list(const Json& json, const Place& place, const std::string& expects, std::size_t min, std::size_t max)
{
  if (!json.is_array() || json.size() < min || json.size() > max)
    place.expected(expects, shown(json));
}

Layout axes() { return {3, 2, "[x, y, z]", "[x, z]"}; }

Format<std::array<double, 3>> vector(const std::string& unit, const Bounds& bounds)
{
  return fixed_list<3>(number(unit, bounds), axes());
}
} // namespace kedge::schema
