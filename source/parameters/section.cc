#include <algorithm>
#include <kedge/parameters/section.h>
#include <kedge/parameters/words.h>

namespace kedge::schema
{
namespace
{
const char* const free_key = "comment"; // allowed in every object

bool holds(const Condition& condition, const Json& object)
{
  const auto neighbour = object.find(condition.key);
  return neighbour != object.end() && neighbour->is_string() &&
         std::count(condition.values.begin(), condition.values.end(), neighbour->get<std::string>()) > 0;
}

bool is_required(const Key& key, const Json& object)
{
  if (key.condition.kind == Condition::Kind::needed_for)
    return holds(key.condition, object);
  return key.presence == Key::Presence::required &&
         (key.condition.kind != Condition::Kind::only_for || holds(key.condition, object));
}

std::string described(const Condition& condition)
{
  return quoted(condition.key) + ": " + alternatives(condition.values);
}

std::string status(const Key& key)
{
  const std::string plain = key.presence == Key::Presence::required   ? "required"
                            : key.presence == Key::Presence::optional ? "optional"
                                                                      : "ignored";
  switch (key.condition.kind)
  {
    case Condition::Kind::only_for:
      return plain + ", only with " + described(key.condition);
    case Condition::Kind::needed_for:
      return "required with " + described(key.condition);
    case Condition::Kind::unused_for:
      return plain + ", without effect with " + described(key.condition);
    case Condition::Kind::none:
      break;
  }
  return plain;
}

Json property(const Key& key)
{
  Json result = {{"description", key.sentence}};
  if (!key.unit.empty())
    result["unit"] = key.unit;
  for (const auto& [name, value] : key.schema.items())
    result[name == "description" ? "about" : name] = value; // the description of a nested section moves to "about"
  if (!key.standard.is_null())
    result["default"] = key.standard;
  result["expected"] = key.expects;
  result["status"] = status(key);
  return result;
}

/// The JSON Schema rule of a conditional key; null if it needs none.
Json rule(const Key& key)
{
  if (key.condition.kind == Condition::Kind::none || key.condition.kind == Condition::Kind::unused_for)
    return {};
  Json result = {{"if",
                  {{"properties", {{key.condition.key, {{"enum", key.condition.values}}}}},
                   {"required", Json::array({key.condition.key})}}}};
  if (key.condition.kind == Condition::Kind::needed_for || key.presence == Key::Presence::required)
    result["then"] = {{"required", Json::array({key.name})}};
  if (key.condition.kind == Condition::Kind::only_for)
    result["else"] = {{"properties", {{key.name, false}}}};
  return result;
}

Key& with(Key& key, Condition::Kind kind, const std::string& neighbour, const std::vector<std::string>& values)
{
  key.condition = {kind, neighbour, values};
  return key;
}
} // namespace

Key& Key::only_for(const std::string& neighbour, const std::vector<std::string>& values)
{
  return with(*this, Condition::Kind::only_for, neighbour, values);
}

Key& Key::needed_for(const std::string& neighbour, const std::vector<std::string>& values)
{
  return with(*this, Condition::Kind::needed_for, neighbour, values);
}

Key& Key::unused_for(const std::string& neighbour, const std::vector<std::string>& values)
{
  return with(*this, Condition::Kind::unused_for, neighbour, values);
}

Json SectionKeys::schema() const
{
  Json properties = Json::object(), required = Json::array(), rules = Json::array();
  for (const Key& key : keys)
  {
    properties[key.name] = property(key);
    if (key.presence == Key::Presence::required && key.condition.kind == Condition::Kind::none)
      required.push_back(key.name);
    if (const Json stated = rule(key); !stated.is_null())
      rules.push_back(stated);
  }
  properties[free_key] = {{"description", "Any text; not read"}, {"expected", "any value"}, {"status", "ignored"}};

  Json result = {{"description", sentence}, {"type", "object"}, {"properties", properties}};
  if (!required.empty())
    result["required"] = required;
  result["additionalProperties"] = false;
  if (!rules.empty())
    result["allOf"] = rules;
  return result;
}

void SectionKeys::check_names(const Json& object, const Place& place) const
{
  if (!object.is_object())
    place.expected("an object", shown(object));
  std::vector<std::string> known;
  for (const Key& key : keys)
    known.push_back(key.name);

  for (const auto& [name, value] : object.items())
  {
    if (name == free_key || std::count(known.begin(), known.end(), name) > 0)
      continue;
    const std::string near = nearest(name, known);
    if (!near.empty())
      place.key(name).fail("unknown key", "did you mean " + quoted(near) + "?");
    const auto& find = place.context().sections_with_key;
    const std::vector<std::string> elsewhere = find ? find(name) : std::vector<std::string>();
    if (!elsewhere.empty())
      place.key(name).fail("unknown key here", elsewhere.front().empty() ? "it belongs at the top level"
                                                                         : "it belongs in " + alternatives(elsewhere));
    place.key(name).fail("unknown key", "remove it; the keys here are " + alternatives(known));
  }
}

SectionKeys::Use SectionKeys::use_of(const Key& key, const Json& object, const Place& place) const
{
  if (!object.contains(key.name))
  {
    if (is_required(key, object))
    {
      const bool conditional = key.condition.kind != Condition::Kind::none;
      place.key(key.name).fail("this required key is missing" +
                                   (conditional ? " (required with " + described(key.condition) + ")" : ""),
                               "add " + quoted(key.name) + ", " + key.expects + " (" + key.sentence + ")");
    }
    return Use::use_default;
  }
  if (key.presence == Key::Presence::ignored)
    return Use::skip;
  if (key.condition.kind == Condition::Kind::only_for && !holds(key.condition, object))
  {
    const auto neighbour = object.find(key.condition.key);
    place.key(key.name).fail("the key belongs to " + described(key.condition) + ", but " + quoted(key.condition.key) +
                                 (neighbour == object.end() ? " is not given" : " is " + shown(*neighbour)),
                             "remove the key or change " + quoted(key.condition.key));
  }
  return key.condition.kind == Condition::Kind::unused_for && holds(key.condition, object) ? Use::check_only
                                                                                           : Use::take;
}
} // namespace kedge::schema
