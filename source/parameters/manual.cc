#include <kedge/parameters/manual.h>

namespace kedge::schema
{
namespace
{
using Visit = std::function<void(const std::string&, const Json&)>;

/// The object inside a value: the value itself or the entries of a list; null if there is none.
const Json* object_in(const Json& schema, std::string& path)
{
  if (schema.contains("properties"))
    return &schema;
  if (!schema.contains("items"))
    return nullptr;
  path += "[]";
  return object_in(schema.at("items"), path);
}

void walk(const Json& section, const std::string& path, const Visit& visit)
{
  visit(path, section);
  for (const auto& [name, value] : section.at("properties").items())
  {
    std::string inner = (path.empty() ? "" : path + ".") + name;
    if (const Json* object = object_in(value, inner))
      walk(*object, inner, visit);
  }
}

std::string cell(std::string text)
{
  for (std::size_t i = text.find('|'); i != std::string::npos; i = text.find('|', i + 2))
    text.insert(i, "\\");
  return text;
}

std::string row(const std::string& name, const Json& property)
{
  const std::string standard = property.contains("default") ? "`" + property.at("default").dump() + "`" : "";
  return "| `" + name + "` | " + cell(property.at("expected").get<std::string>()) + " | " +
         cell(property.value("unit", "")) + " | " + cell(standard) + " | " +
         cell(property.at("status").get<std::string>()) + " | " + cell(property.at("description").get<std::string>()) +
         " |\n";
}
} // namespace

void for_each_section(const Json& schema, const Visit& visit) { walk(schema, "", visit); }

std::vector<std::string> sections_with_key(const Json& schema, const std::string& key)
{
  std::vector<std::string> paths;
  for_each_section(schema,
                   [&](const std::string& path, const Json& section)
                   {
                     if (section.at("properties").contains(key))
                       paths.push_back(path);
                   });
  return paths;
}

std::string markdown_tables(const Json& schema)
{
  std::string page;
  for_each_section(schema,
                   [&](const std::string& path, const Json& section)
                   {
                     page += "\n## " + (path.empty() ? "Top level" : "`" + path + "`") + "\n\n" +
                             section.value("about", section.at("description").get<std::string>()) +
                             ".\n\n| key | value | unit | default | status | meaning |\n|---|---|---|---|---|---|\n";
                     for (const auto& [name, property] : section.at("properties").items())
                       if (name != "comment" || path.empty())
                         page += row(name, property);
                   });
  return page;
}
} // namespace kedge::schema
