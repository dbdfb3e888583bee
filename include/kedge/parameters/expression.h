// Functions that the input gives as text, such as "G sin(pi X)". muParser evaluates them; a build without it refuses
// them where they are used.
#pragma once

#include <kedge/parameters/format.h>
#include <memory>

namespace kedge
{
/// Components of a vector as text, and definitions that they use.
struct ExpressionText
{
  std::vector<std::string> components;                          ///< none: there is no such function
  std::vector<std::pair<std::string, std::string>> definitions; ///< name and text; each may use those before it
  std::string path;                                             ///< in the input, for messages

  bool empty() const { return components.empty(); }
};

/// An ExpressionText that can be evaluated.
class Expression
{
public:
  /// `variables`: the names that may occur beside definitions, functions and pi. Throws InputError naming the JSON path
  /// of a text that cannot be evaluated.
  Expression(const ExpressionText& text, const std::vector<std::string>& variables);
  ~Expression();

  std::size_t n_components() const;
  /// Whether a text has this variable in it.
  bool uses(const std::string& variable) const;
  /// Reads a value per variable and writes one per component. They may be infinite or not numbers. Not thread-safe.
  void evaluate(const double* variables, double* components) const;

private:
  struct Content;
  std::unique_ptr<Content> content;
};

/// An object with the keys "expression", a list with a text or a number per axis, and "definitions". `variables` of the
/// dimension; reading compiles the text.
schema::Format<ExpressionText>
expression_along_axes(const std::string& unit,
                      const std::function<std::vector<std::string>(unsigned int dimension)>& variables);
} // namespace kedge
