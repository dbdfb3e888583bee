// A section is one JSON object of the input. Each key is declared once, beside the struct that receives it; reading,
// checks, JSON Schema and manual all follow from that declaration.
#pragma once

#include <functional>
#include <kedge/parameters/format.h>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace kedge::schema
{
/// How the value of a neighbouring key, a text, decides whether a key is allowed or required.
struct Condition
{
  enum class Kind
  {
    none,
    only_for,   ///< elsewhere the key is an error
    needed_for, ///< elsewhere the key is optional
    unused_for  ///< there the key is checked for its form only
  };
  Kind kind = Kind::none;
  std::string key;
  std::vector<std::string> values;
};

/// Everything about a key except the member that it fills.
struct Key
{
  enum class Presence
  {
    required,
    optional,
    ignored
  };
  std::string name, sentence, expects, unit;
  Presence presence = Presence::required;
  Json schema;
  Json standard; ///< default; null if there is none to show
  Condition condition;

  /// The key belongs to sections in which `neighbour` has one of the values.
  Key& only_for(const std::string& neighbour, const std::vector<std::string>& values);
  /// The key is required where `neighbour` has one of the values, optional elsewhere.
  Key& needed_for(const std::string& neighbour, const std::vector<std::string>& values);
  /// The key has no effect where `neighbour` has one of the values.
  Key& unused_for(const std::string& neighbour, const std::vector<std::string>& values);
};

/// The part of a section that does not depend on the struct it fills.
class SectionKeys
{
public:
  explicit SectionKeys(std::string sentence_) : sentence(std::move(sentence_)) {}
  /// JSON Schema (draft 2020-12) of the object, with the annotations "unit", "status", "expected" and "about".
  Json schema() const;

protected:
  /// What to do with a key in a given object.
  enum class Use
  {
    take,
    check_only,
    skip,
    use_default
  };
  Use use_of(const Key& key, const Json& object, const Place& place) const;
  void check_names(const Json& object, const Place& place) const;

  std::string sentence;
  std::vector<Key> keys;
};

/// A section that fills a T. Members are given as a pointer to member, a function T& -> V&, or a setter (T&, V).
/// The default of an optional key is what T{} holds.
template <typename T> class Section : public SectionKeys
{
public:
  using SectionKeys::SectionKeys;
  using Check = std::function<void(const T&, const Place&)>;

  template <typename V, typename Member>
  Key& required(const std::string& name, Member member, const Format<V>& format, const std::string& meaning)
  {
    return add(name, Key::Presence::required, format, meaning, {reader(member, format), {}});
  }

  template <typename V, typename Member>
  Key& optional(const std::string& name, Member member, const Format<V>& format, const std::string& meaning)
  {
    Key& key = add(name, Key::Presence::optional, format, meaning, {reader(member, format), {}});
    if constexpr (!std::is_invocable_v<Member, T&, V>)
      if (format.write)
      {
        T standard{};
        key.standard = format.write(std::invoke(member, standard));
      }
    return key;
  }

  /// An optional key whose default is not what T{} holds.
  template <typename V, typename Member>
  Key& optional(const std::string& name, Member member, const Format<V>& format, const std::string& meaning,
                const V& standard)
  {
    const auto set = [member, standard](T& into) { std::invoke(member, into) = standard; };
    Key& key = add(name, Key::Presence::optional, format, meaning, {reader(member, format), set});
    key.standard = format.write(standard);
    return key;
  }

  /// A key that other programs read; any value is accepted.
  Key& ignored(const std::string& name, const std::string& meaning)
  {
    Format<Json> anything;
    anything.expects = "any value";
    anything.schema = Json::object();
    return add(name, Key::Presence::ignored, anything, meaning, {});
  }

  /// A nested object that fills members of the same T.
  Key& group(const std::string& name, Key::Presence presence, const Section& inner, const std::string& meaning)
  {
    Format<Json> object;
    object.expects = "an object";
    object.schema = inner.schema();
    const auto read = [inner](const Json& json, T& into, const Place& place) { inner.read(json, into, place); };
    return add(name, presence, object, meaning, {read, {}});
  }

  /// Adds the keys of another section at this level.
  template <typename U> void include(const Section<U>& other, U T::*member)
  {
    for (std::size_t i = 0; i < other.keys.size(); ++i)
    {
      const auto& [read, set] = other.bindings[i];
      Binding binding;
      if (read)
        binding.read = [read = read, member](const Json& json, T& into, const Place& place)
        { read(json, into.*member, place); };
      if (set)
        binding.set_default = [set = set, member](T& into) { set(into.*member); };
      keys.push_back(other.keys[i]);
      bindings.push_back(binding);
    }
    for (const auto& rule : other.checks)
      checks.push_back([rule, member](const T& value, const Place& place) { rule(value.*member, place); });
  }

  /// A rule about several members. It is called after all keys were read and throws by place.key(...).fail(...).
  void check(const Check& rule) { checks.push_back(rule); }

  void read(const Json& object, T& into, const Place& place) const
  {
    check_names(object, place);
    for (std::size_t i = 0; i < keys.size(); ++i)
    {
      const Use use = use_of(keys[i], object, place);
      if (use == Use::use_default && bindings[i].set_default)
        bindings[i].set_default(into);
      if (use != Use::take && use != Use::check_only)
        continue;
      T unused{};
      bindings[i].read(object.at(keys[i].name), use == Use::take ? into : unused,
                       place.key(keys[i].name).meaning(keys[i].sentence));
    }
    for (const Check& rule : checks)
      rule(into, place);
  }

private:
  template <typename U> friend class Section;
  using Reader = std::function<void(const Json&, T&, const Place&)>;
  struct Binding
  {
    Reader read;
    std::function<void(T&)> set_default;
  };

  template <typename V, typename Member> static Reader reader(Member member, const Format<V>& format)
  {
    return [member, read = format.read](const Json& json, T& into, const Place& place)
    {
      if constexpr (std::is_invocable_v<Member, T&, V>)
        member(into, read(json, place));
      else
        std::invoke(member, into) = read(json, place);
    };
  }

  template <typename V>
  Key& add(const std::string& name, Key::Presence presence, const Format<V>& format, const std::string& meaning,
           const Binding& binding)
  {
    bindings.push_back(binding);
    keys.push_back({name, meaning, format.expects, format.unit, presence, format.schema, {}, {}});
    return keys.back();
  }

  std::vector<Binding> bindings;
  std::vector<Check> checks;
};

/// A nested object that fills a T of its own.
template <typename T> Format<T> object_of(const Section<T>& section)
{
  Format<T> format;
  format.read = [section](const Json& json, const Place& place)
  {
    T value{};
    section.read(json, value, place);
    return value;
  };
  format.expects = "an object";
  format.schema = section.schema();
  return format;
}
} // namespace kedge::schema
