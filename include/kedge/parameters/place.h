// Where in the input a value stands: the path that an error message shows, and what reading it may need to know.
#pragma once

#include <functional>
#include <kedge/parameters/json.h>
#include <string>
#include <vector>

namespace kedge::schema
{
/// What holds for the whole document.
struct InputContext
{
  unsigned int dimension = 3;
  std::string folder; ///< of the input file; paths in it are relative to this
  /// Sections that know a key, for the hint where a misplaced key belongs; may be empty.
  std::function<std::vector<std::string>(const std::string& key)> sections_with_key;
};

/// A position in the document such as `analysis[1].load steps`. Refers to the context, which must outlive it.
class Place
{
public:
  explicit Place(const InputContext& context) : input(&context) {}

  Place key(const std::string& name) const;
  Place entry(std::size_t position) const;
  /// The same place with a sentence that says what the value means, which errors repeat.
  Place meaning(const std::string& sentence) const;

  const std::string& path() const { return text; }
  const InputContext& context() const { return *input; }

  /// Throws InputError for this place.
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const;
  /// Throws InputError "expected ..., found ..."; without a remedy the value's meaning is given.
  [[noreturn]] void expected(const std::string& what, const std::string& found, const std::string& remedy = "") const;

private:
  const InputContext* input;
  std::string text, sentence;
};
} // namespace kedge::schema
