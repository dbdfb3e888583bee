#include <algorithm>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/parameters/json.h>
#include <vector>

namespace kedge::schema
{
namespace
{
/// Builds the document from the parser's events. The library's own builder would silently keep one of two equal keys.
class Builder : public nlohmann::json_sax<Json>
{
public:
  Builder(const std::string& text_, const std::string& source_) : text(text_), source(source_) {}

  Json take() { return std::move(document); }

  bool null() override { return place(nullptr); }
  bool boolean(bool value) override { return place(value); }
  bool number_integer(number_integer_t value) override { return place(value); }
  bool number_unsigned(number_unsigned_t value) override { return place(value); }
  bool number_float(number_float_t value, const string_t&) override { return place(value); }
  bool string(string_t& value) override { return place(value); }
  bool binary(binary_t&) override { return false; } // cannot occur in text
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override
  {
    if (nest.back()->contains(name))
      throw InputError(path() + (path().empty() ? "" : ".") + name, "the key is given twice in " + source,
                       "keep one of the two");
    names.back() = name;
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override
  {
    const std::size_t end = std::min(text.size(), position == 0 ? 0 : position - 1);
    const auto line = 1 + std::count(text.begin(), text.begin() + end, '\n');
    const std::size_t start = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
    const std::size_t column = start == std::string::npos ? end + 1 : end - start;

    std::string problem = error.what(); // "[json.exception...] parse error at ...: syntax error while ... - unexpected"
    const std::size_t detail = problem.find(" - ");
    problem = detail == std::string::npos ? problem.substr(problem.find("] ") + 2) : problem.substr(detail + 3);
    throw InputError(source, "line " + std::to_string(line) + ", column " + std::to_string(column) + ": " + problem,
                     error.id == out_of_range ? "write a number that double precision can hold"
                                              : "JSON allows no comments, no comma after the last entry, no NaN and no "
                                                "Infinity");
  }

private:
  static constexpr int out_of_range = 406;    // the library's number for it
  static constexpr std::size_t deepest = 100; // deep ones would overflow the stack where they are copied

  Json* store(Json value)
  {
    if (nest.empty())
    {
      document = std::move(value);
      return &document;
    }
    Json& parent = *nest.back();
    if (parent.is_array())
    {
      parent.push_back(std::move(value));
      return &parent.back();
    }
    return &(parent[names.back()] = std::move(value));
  }
  bool place(Json value)
  {
    store(std::move(value));
    return true;
  }
  bool open(Json value)
  {
    if (nest.size() == deepest)
      throw InputError(source, fmt::format("objects and lists lie more than {} deep in each other", deepest),
                       "no key of an input needs that");
    nest.push_back(store(std::move(value)));
    names.emplace_back();
    return true;
  }
  bool close()
  {
    nest.pop_back();
    names.pop_back();
    return true;
  }
  /// Path of the innermost open object.
  std::string path() const
  {
    std::string result;
    for (std::size_t i = 0; i + 1 < nest.size(); ++i)
      result += nest[i]->is_array() ? "[" + std::to_string(nest[i]->size() - 1) + "]"
                                    : (result.empty() ? "" : ".") + names[i];
    return result;
  }

  const std::string &text, &source;
  Json document;
  std::vector<Json*> nest; // pointers stay valid: a container grows only while none of its entries is open
  std::vector<std::string> names;
};

/// Keys and positions of "analysis.1.load steps" or, as error messages write it, "analysis[1].load steps".
std::vector<std::string> segments(const std::string& path)
{
  std::vector<std::string> result(1);
  for (const char c : path)
    if (c == '.' || c == '[')
      result.emplace_back();
    else if (c != ']')
      result.back() += c;
  return result;
}

Json override_value(const std::string& text)
{
  try
  {
    return parse_json(text, "--set");
  }
  catch (const InputError&) // not JSON: a bare word
  {
    return text;
  }
}

[[noreturn]] void refuse(const std::string& assignment, const std::string& problem, const std::string& remedy)
{
  throw InputError("--set " + assignment, problem, remedy);
}

Json& list_entry(Json& list, const std::string& segment, const std::string& assignment)
{
  const bool digits = !segment.empty() && segment.size() < 10 &&
                      std::all_of(segment.begin(), segment.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits || std::stoul(segment) >= list.size())
    refuse(assignment, "\"" + segment + "\" is not a position in a list of " + std::to_string(list.size()),
           list.empty() ? "replace the whole list"
                        : "positions count from 0, so use 0 to " + std::to_string(list.size() - 1));
  return list[std::stoul(segment)];
}
} // namespace

Json parse_json(const std::string& text, const std::string& source)
{
  Builder builder(text, source);
  Json::sax_parse(text, &builder);
  return builder.take();
}

void apply_override(Json& document, const std::string& assignment)
{
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos)
    refuse(assignment, "there is no \"=\"", "write --set \"path=value\", for example \"analysis.0.load steps=40\"");

  Json* target = &document;
  for (const std::string& segment : segments(assignment.substr(0, equals)))
  {
    if (segment.empty())
      refuse(assignment, "the path has an empty part", "separate keys by single dots");
    if (target->is_array())
      target = &list_entry(*target, segment, assignment);
    else if (target->is_object() || target->is_null())
      target = &(*target)[segment]; // may add a key; the check of the whole document refuses unknown ones
    else
      refuse(assignment, "\"" + segment + "\" cannot be a key inside " + shown(*target) + ", which holds no keys",
             "shorten the path");
  }
  *target = override_value(assignment.substr(equals + 1));
}

std::string shown(const Json& value)
{
  if (value.is_object())
    return "an object";
  if (value.is_array())
    return value.empty() ? "an empty list" : "a list of " + std::to_string(value.size());
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}
} // namespace kedge::schema
