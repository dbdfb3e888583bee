// Facts that follow from a schema alone: the sections of its keys, and the page of the manual.
#pragma once

#include <functional>
#include <kedge/parameters/json.h>
#include <string>
#include <vector>

namespace kedge::schema
{
/// Calls `visit` for every object in the schema, outermost first, with its path ("analysis[].adaptivity").
void for_each_section(const Json& schema,
                      const std::function<void(const std::string& path, const Json& section)>& visit);

/// Paths of the sections that have a key of this name. The path of the outermost section is empty.
std::vector<std::string> sections_with_key(const Json& schema, const std::string& key);

/// Reference of all keys in Markdown, one table per section.
std::string markdown_tables(const Json& schema);
} // namespace kedge::schema
