// A list of laws, from which their storage, their names and the one dispatch over them follow.
#pragma once

#include <algorithm>
#include <kedge/materials/law.h>
#include <kedge/materials/response.h>
#include <type_traits>

namespace kedge
{
/// Stands for a law in calls of generic lambdas.
template <typename Law> struct LawTag
{
  using type = Law;
};

namespace internal
{
template <template <typename> class Part, typename Law, typename = void> struct Has : std::false_type
{
};
template <template <typename> class Part, typename Law> struct Has<Part, Law, std::void_t<Part<Law>>> : std::true_type
{
};

template <typename Law> using Name = std::enable_if_t<std::is_same_v<decltype(Law::name), const char* const>>;
template <typename Law>
using Keys = std::enable_if_t<std::is_same_v<std::decay_t<decltype(Law::keys[0])>, const LawKey*>>;
template <typename Law>
using Variables = std::enable_if_t<std::is_same_v<std::decay_t<decltype(Law::state_variables[0])>, StateVariable>>;
template <typename Law>
using Make = std::enable_if_t<std::is_same_v<decltype(Law::make(std::declval<const LawConstants&>())), Law>>;
template <typename Law>
using Check = decltype(Law::check(std::declval<const LawConstants&>(), std::declval<const Refuse&>()));
template <typename Law>
using Memory = std::enable_if_t<std::is_same_v<decltype(std::declval<const Law&>().remembers()), bool> &&
                                std::is_void_v<decltype(std::declval<const Law&>().initialise(
                                    std::declval<const Generation&>(), std::declval<double*>()))>>;
template <typename Law, bool with_tangent>
using Answer = decltype(std::declval<const Law&>().template respond<with_tangent>(
    std::declval<const Eigen::Vector3d&>(), std::declval<const MaterialPoint&>(),
    std::declval<const HenckyElasticity&>(), std::declval<double*>()));
template <typename Law>
using Respond =
    std::enable_if_t<std::is_same_v<Answer<Law, true>, Response> && std::is_same_v<Answer<Law, false>, Response>>;

/// Names what a law lacks.
template <typename Law> struct CheckedLaw
{
  static_assert(Has<Name, Law>::value, "a law needs `static constexpr const char* name`, the word of the key \"type\"");
  static_assert(Has<Keys, Law>::value, "a law needs `static constexpr std::array<const LawKey*, n> keys`");
  static_assert(Has<Variables, Law>::value,
                "a law needs `static constexpr std::array<StateVariable, n> state_variables`");
  static_assert(Has<Make, Law>::value, "a law needs `static Law make(const LawConstants&)`");
  static_assert(Has<Check, Law>::value, "a law needs `static void check(const LawConstants&, const Refuse&)`");
  static_assert(Has<Respond, Law>::value,
                "a law needs `template <bool with_tangent> Response respond(const Eigen::Vector3d&, const "
                "MaterialPoint&, const HenckyElasticity&, double* next_state) const`");
  static_assert(Law::state_variables.size() == 0 || Has<Memory, Law>::value,
                "a law with state variables needs `bool remembers() const` and `void initialise(const Generation&, "
                "double* state) const`");
  static_assert(std::is_trivially_copyable_v<Law>, "a law is copied to the device byte by byte");
  static constexpr std::size_t n_state = Law::state_variables.size();
};

constexpr bool same_text(const char* a, const char* b)
{
  while (*a != '\0' && *a == *b)
    ++a, ++b;
  return *a == *b;
}

/// Whether keys of the same name are the same object.
template <std::size_t n, std::size_t m>
constexpr bool share_keys(const std::array<const LawKey*, n>& one, const std::array<const LawKey*, m>& other)
{
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < m; ++j)
      if (one[i] != other[j] && same_text(one[i]->name, other[j]->name))
        return false;
  return true;
}

template <typename Law, typename... Laws> constexpr bool shares_keys_with()
{
  return (share_keys(Law::keys, Laws::keys) && ...);
}
} // namespace internal

template <typename... Laws> class LawList
{
  template <typename Law> struct Slot
  {
    Law law;
  };

public:
  static constexpr unsigned int size = sizeof...(Laws);
  /// State variables that a material point must hold for whichever law it has.
  static constexpr std::size_t max_state = std::max({std::size_t(1), internal::CheckedLaw<Laws>::n_state...});

  /// The constants of all laws, those of laws not in use unset.
  struct Storage : Slot<Laws>...
  {
    template <typename Law> KEDGE_FUNCTION Law& get()
    {
      static_assert(contains<Law>(), "this law is not in the list of materials/laws.h");
      return static_cast<Slot<Law>&>(*this).law;
    }
    template <typename Law> KEDGE_FUNCTION const Law& get() const
    {
      static_assert(contains<Law>(), "this law is not in the list of materials/laws.h");
      return static_cast<const Slot<Law>&>(*this).law;
    }
  };

  template <typename Law> static constexpr bool contains() { return (std::is_same_v<Law, Laws> || ...); }

  /// Position of a law in the list.
  template <typename Law> static constexpr unsigned int index()
  {
    static_assert(contains<Law>(), "this law is not in the list of materials/laws.h");
    unsigned int position = 0;
    (void)((std::is_same_v<Law, Laws> ? true : (++position, false)) || ...);
    return position;
  }

  /// Calls f(LawTag<Law>) for every law in the order of the list.
  template <typename Function> static void for_each(const Function& f) { (f(LawTag<Laws>{}), ...); }

  /// Calls f(LawTag<Law>) for the law at a position.
  template <typename Function> static void visit(const unsigned int position, const Function& f)
  {
    for_each(
        [&](const auto law)
        {
          if (position == index<typename decltype(law)::type>())
            f(law);
        });
  }

  /// What the law at a position answers.
  template <bool with_tangent>
  KEDGE_FUNCTION static Response respond(const unsigned int position, const Storage& laws,
                                         const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                         const HenckyElasticity& elasticity, double* next_state)
  {
    return respond_from<with_tangent, Laws...>(position, laws, trial_strain, point, elasticity, next_state);
  }

private:
  template <bool with_tangent, typename Law, typename... Others>
  KEDGE_FUNCTION static Response respond_from(const unsigned int position, const Storage& laws,
                                              const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                              const HenckyElasticity& elasticity, double* next_state)
  {
    constexpr unsigned int own = index<Law>();
    if constexpr (sizeof...(Others) > 0)
      if (position != own)
        return respond_from<with_tangent, Others...>(position, laws, trial_strain, point, elasticity, next_state);
    return laws.template get<Law>().template respond<with_tangent>(trial_strain, point, elasticity, next_state);
  }

  static_assert((internal::shares_keys_with<Laws, Laws...>() && ...),
                "laws with a key of the same name must share its declaration");
};
} // namespace kedge
