// Place of a value in the input: the path that an error message shows, and the context that reading may need.
#pragma once

#include <functional>
#include <kedge/parameters/json.h>
#include <string>
#include <vector>

namespace kedge::schema
{
/// Facts that hold for the whole document.
struct InputContext
{
  unsigned int dimension = 3;
  std::string folder; ///< of the input file; paths in it are relative to this
  /// Sections that know a key, to tell the user where a misplaced key belongs; may be empty.
  std::function<std::vector<std::string>(const std::string& key)> sections_with_key;
};

/// A position in the document such as `analysis[1].load steps`. Refers to the context, which must outlive it.
class Place
{
public:
  explicit Place(const InputContext& context) : input(&context) {}

  Place key(const std::string& name) const;
  Place entry(std::size_t position) const;
  /// The same place with a sentence that says what the value means; errors repeat it.
  Place meaning(const std::string& sentence) const;

  const std::string& path() const { return text; }
  const InputContext& context() const { return *input; }

  /// Throws InputError for this place.
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const;
  /// Throws InputError "expected ..., found ...". Without a remedy it repeats the meaning of the value.
  [[noreturn]] void expected(const std::string& what, const std::string& found, const std::string& remedy = "") const;

private:
  const InputContext* input;
  std::string text, sentence;
};
} // namespace kedge::schema
