// What every law of the list says of itself: its input keys, its state variables, and what a material point gives it.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <string>

namespace kedge
{
/// Limits of a constant; a limit counts as inside unless it is marked as open.
struct Range
{
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  bool open_below = false, open_above = false;
};

namespace ranges
{
inline constexpr Range positive = {0., std::numeric_limits<double>::infinity(), true, false};
inline constexpr Range not_negative = {0., std::numeric_limits<double>::infinity(), false, false};
inline constexpr Range angle = {0., 90., false, true}; ///< degrees
} // namespace ranges

/// Stands for a constant that is not given and for the constants of laws that a material does not use.
inline constexpr double unset = std::numeric_limits<double>::quiet_NaN();

/// An input key of "material" that sets a constant of a law. Laws that share a key share the object.
struct LawKey
{
  const char* name;
  const char* unit;
  Range range;
  bool required;
  double standard; ///< value where an optional key is not given; `unset`: the law goes without it
  const char* sentence;
};

constexpr LawKey required_key(const char* name, const char* unit, const Range& range, const char* sentence)
{
  return {name, unit, range, true, unset, sentence};
}

constexpr LawKey optional_key(const char* name, const char* unit, const Range& range, const double standard,
                              const char* sentence)
{
  return {name, unit, range, false, standard, sentence};
}

/// The values of a material's keys by their names.
struct LawConstants
{
  std::map<std::string, double> values;

  bool has(const LawKey& key) const { return values.count(key.name) > 0; }
  double operator[](const LawKey& key) const
  {
    const auto found = values.find(key.name);
    return found == values.end() ? key.standard : found->second;
  }
};

/// Takes a key, what is wrong with it and what helps, and throws.
using Refuse = std::function<void(const LawKey& key, const std::string& problem, const std::string& remedy)>;

/// A number as messages show it.
std::string shown_number(double value);

/// A number that a law remembers at each material point.
struct StateVariable
{
  const char* name;
  const char* unit;
  const char* sentence;
};

/// Where and under which load a material point is generated.
struct Generation
{
  double depth;           ///< below the surface of the soil, m
  double vertical_stress; ///< Pa, compression positive
};

/// What a law may know of a material point.
struct MaterialPoint
{
  double young;        ///< Young's modulus, Pa
  double cell_size;    ///< edge of the cell in which the point is, m
  const double* state; ///< the law's state variables at the start of the increment; not read by a law without them
};
} // namespace kedge
