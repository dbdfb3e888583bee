// Converts JSON text to a document and back. It is stricter than the standard: an object may hold a key only once.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace kedge::schema
{
/// Keeps the keys in the order of the file, so that copies and generated pages read like their source.
using Json = nlohmann::ordered_json;

/// Parses `text`. The InputError of a syntax error names `source`, line and column; that of a repeated key names its
/// JSON path.
Json parse_json(const std::string& text, const std::string& source);

/// Replaces one value of the document. `assignment` is "path=value": the path has keys and array positions (from 0),
/// separated by dots; the value is JSON or a bare word. Missing keys are added. Throws InputError with the path
/// "--set ...".
void apply_override(Json& document, const std::string& assignment);

/// A value as an error message shows it: short, on one line.
std::string shown(const Json& value);
} // namespace kedge::schema
