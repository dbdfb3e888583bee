// Formats say how one JSON value is read, checked, described and written back. A Section binds them to keys.
#pragma once

#include <array>
#include <functional>
#include <kedge/parameters/place.h>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kedge::schema
{
template <typename V> struct Format
{
  std::function<V(const Json&, const Place&)> read; ///< throws InputError
  std::function<Json(const V&)> write;              ///< for the published default; empty if there is none
  std::string expects;                              ///< "a number above 0 (m)"
  std::string unit;                                 ///< "-": dimensionless; empty: not a quantity
  Json schema;                                      ///< JSON Schema of the value
};

/// Limits of a number, e.g. Bounds().at_least(0).below(90).
class Bounds
{
public:
  Bounds& above(double limit);
  Bounds& at_least(double limit);
  Bounds& below(double limit);
  Bounds& at_most(double limit);

  bool hold(double value) const;
  std::string text() const; ///< " above 0", empty where unbounded
  void describe(Json& schema) const;

private:
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  bool open_below = false, open_above = false;
};
inline Bounds positive() { return Bounds().above(0.); }
inline Bounds not_negative() { return Bounds().at_least(0.); }

/// A finite number.
Format<double> number(const std::string& unit, const Bounds& bounds = {});
/// A whole number that is not negative; 3.0 is refused.
Format<unsigned int> count(const Bounds& bounds = {});
/// "on" or "off".
Format<bool> on_off();
/// "yes" or "no".
Format<bool> yes_no();
/// One of the words, kept as text.
Format<std::string> word(const std::vector<std::string>& words);
/// A file that exists and can be read; the result is resolved against the input file's folder.
Format<std::string> existing_file();
/// A folder below the run's output folder.
Format<std::string> output_folder();

/// Position of `json` in `words`. Throws InputError, which suggests the nearest spelling.
std::size_t read_word(const Json& json, const Place& place, const std::vector<std::string>& words);

/// One of several words, each standing for a value.
template <typename E> Format<E> choice(const std::vector<std::pair<std::string, E>>& options)
{
  std::vector<std::string> words;
  for (const auto& option : options)
    words.push_back(option.first);
  const Format<std::string> as_word = word(words);
  Format<E> format;
  format.read = [options, words](const Json& json, const Place& place)
  { return options[read_word(json, place, words)].second; };
  format.write = [options](const E& value)
  {
    for (const auto& option : options)
      if (option.second == value)
        return Json(option.first);
    return Json();
  };
  format.expects = as_word.expects;
  format.schema = as_word.schema;
  return format;
}

/// A number or one word that stands for `value`.
Format<double> number_or(const std::string& word, double value, const Format<double>& number);

/// A value that may be absent.
template <typename V> Format<std::optional<V>> maybe(const Format<V>& format)
{
  Format<std::optional<V>> result;
  result.read = [format](const Json& json, const Place& place) { return std::optional<V>(format.read(json, place)); };
  result.expects = format.expects;
  result.unit = format.unit;
  result.schema = format.schema;
  return result;
}

/// Throws unless `json` is a list with a length from `min` to `max`.
void require_list(const Json& json, const Place& place, const std::string& expects, std::size_t min, std::size_t max);

/// A list of any length from `min_items`.
template <typename V> Format<std::vector<V>> list_of(const Format<V>& entry, unsigned int min_items = 0)
{
  Format<std::vector<V>> format;
  format.expects = "a list" + std::string(min_items > 0 ? " of at least " + std::to_string(min_items) : "") +
                   ", each entry " + entry.expects;
  format.read = [entry, min_items, expects = format.expects](const Json& json, const Place& place)
  {
    require_list(json, place, expects, min_items, std::numeric_limits<std::size_t>::max());
    std::vector<V> values;
    for (std::size_t i = 0; i < json.size(); ++i)
      values.push_back(entry.read(json[i], place.entry(i)));
    return values;
  };
  format.write = [entry](const std::vector<V>& values)
  {
    Json json = Json::array();
    for (const V& value : values)
      json.push_back(entry.write ? entry.write(value) : Json());
    return json;
  };
  format.unit = entry.unit;
  format.schema = {{"type", "array"}, {"items", entry.schema}};
  if (min_items > 0)
    format.schema["minItems"] = min_items;
  return format;
}

/// Length and meaning of a list of fixed length, in 3-D and in 2-D.
struct Layout
{
  std::size_t length_3d, length_2d;
  std::string text_3d, text_2d; ///< "[x, y, z]"
};
/// [x, y, z], in 2-D [x, z].
Layout axes();

/// A list with one entry per item of the layout. In 2-D the entries beyond the list keep their default.
template <std::size_t N, typename V> Format<std::array<V, N>> fixed_list(const Format<V>& entry, const Layout& layout)
{
  Format<std::array<V, N>> format;
  const std::string in_2d = layout.text_2d == layout.text_3d ? "" : " (2-D: " + layout.text_2d + ")";
  format.expects = "a list " + layout.text_3d + in_2d + ", each entry " + entry.expects;
  format.read = [entry, layout](const Json& json, const Place& place)
  {
    const bool flat = place.context().dimension == 2;
    const std::size_t length = flat ? layout.length_2d : layout.length_3d;
    const std::string expects = "a list " + (flat ? layout.text_2d : layout.text_3d) + ", each entry " + entry.expects;
    require_list(json, place, expects, length, length);
    std::array<V, N> values{};
    for (std::size_t i = 0; i < length; ++i)
      values[i] = entry.read(json[i], place.entry(i));
    return values;
  };
  if (entry.write)
    format.write = [entry, layout](const std::array<V, N>& values)
    {
      Json json = Json::array();
      for (std::size_t i = 0; i < layout.length_3d; ++i)
        json.push_back(entry.write(values[i]));
      return json;
    };
  format.unit = entry.unit;
  format.schema = {
      {"type", "array"}, {"items", entry.schema}, {"minItems", layout.length_2d}, {"maxItems", layout.length_3d}};
  return format;
}

/// Coordinates or components along the axes.
Format<std::array<double, 3>> vector(const std::string& unit, const Bounds& bounds = {});
} // namespace kedge::schema
