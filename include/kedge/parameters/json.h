// JSON text to a document and back, stricter than the standard: a key may stand only once in an object.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace kedge::schema
{
/// Keeps the keys in the order of the file, so that copies and generated pages read like their source.
using Json = nlohmann::ordered_json;

/// Parses `text`. Throws InputError that names `source` with line and column (syntax), or the JSON path (a key given
/// twice).
Json parse_json(const std::string& text, const std::string& source);

/// Replaces one value of the document. `assignment` is "path=value": keys and array positions (from 0) separated by
/// dots, a value in JSON or a bare word. Keys that do not exist are added. Throws InputError with the path "--set ...".
void apply_override(Json& document, const std::string& assignment);

/// A value as an error message shows it: short, on one line.
std::string shown(const Json& value);
} // namespace kedge::schema
