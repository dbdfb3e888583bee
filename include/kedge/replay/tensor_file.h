// Arrays by name in one file, in the format of safetensors: the length of the header (8 bytes), the header (JSON), then
// the arrays as they lie in memory, row by row. NumPy reads it in five lines.
#pragma once

#include <fstream>
#include <kedge/base/kokkos.h>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace kedge
{
namespace internal
{
/// How the format names a type of number. Other plain data are bytes.
template <typename T> constexpr const char* tensor_type()
{
  if constexpr (std::is_floating_point_v<T>)
    return sizeof(T) == 8 ? "F64" : "F32";
  else if constexpr (!std::is_arithmetic_v<T> || sizeof(T) == 1)
    return "U8";
  else if constexpr (std::is_signed_v<T>)
    return sizeof(T) == 8 ? "I64" : "I32";
  else
    return sizeof(T) == 8 ? "U64" : "U32";
}

template <typename View> constexpr std::size_t width_of()
{
  if constexpr (View::rank == 2)
    return View::static_extent(1);
  else
    return 1;
}

/// The same entry of a view with one or two axes.
template <typename View> decltype(auto) entry_of(const View& view, const std::size_t row, const std::size_t column)
{
  if constexpr (View::rank == 2)
    return view(row, column);
  else
    return view(row);
}
} // namespace internal

/// Writes arrays: vectors, views with one axis or with a second one of fixed length, and single numbers.
class TensorWriter
{
public:
  explicit TensorWriter(const std::string& path_) : path(path_) {}

  /// Calls `visit(*this)`, which hands over all arrays, twice: for the header, then for the numbers, so that nothing is
  /// copied before it is written. Throws FileError.
  template <typename Visit> void write(const Visit& visit)
  {
    visit(*this);
    begin_numbers();
    visit(*this);
    close();
  }

  template <typename T> void operator()(const char* name, const std::vector<T>& values)
  {
    array(name, internal::tensor_type<T>(), Shape{values.size()}, values.size() * sizeof(T), values.data());
  }

  template <typename T, typename... P> void operator()(const char* name, const Kokkos::View<T, P...>& view)
  {
    using Array = Kokkos::View<T, P...>;
    using Number = typename Array::non_const_value_type;
    constexpr std::size_t width = internal::width_of<Array>();
    const std::size_t n = view.extent(0);
    std::vector<Number> rows;
    if (header_is_written)
    {
      const auto host = copy_to_host(view);
      rows.resize(n * width);
      for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = internal::entry_of(host, i / width, i % width);
    }
    array(name, internal::tensor_type<Number>(), Shape{n, std::is_arithmetic_v<Number> ? width : sizeof(Number)},
          n * width * sizeof(Number), rows.data());
  }

  template <typename T> std::enable_if_t<std::is_arithmetic_v<T>> operator()(const char* name, const T& value)
  {
    array(name, internal::tensor_type<T>(), Shape{1}, sizeof(T), &value);
  }

private:
  using Shape = std::vector<std::size_t>;
  void array(const char* name, const char* type, const Shape& shape, std::size_t bytes, const void* data);
  void begin_numbers();
  void close();

  std::string path, draft;
  std::ofstream file;
  nlohmann::json header;
  std::size_t length = 0; ///< of all arrays so far
  bool header_is_written = false;
};

/// Reads them, in any order. What a view has no axis for in the file, or a number of another type, is an error.
class TensorReader
{
public:
  /// Throws FileError, as all that follows.
  explicit TensorReader(const std::string& path);

  template <typename T> void operator()(const char* name, std::vector<T>& values)
  {
    values.resize(bytes_of(name, internal::tensor_type<T>(), sizeof(T)) / sizeof(T));
    read(name, values.data());
  }

  template <typename T, typename... P> void operator()(const char* name, Kokkos::View<T, P...>& view)
  {
    using Array = Kokkos::View<T, P...>;
    using Number = typename Array::non_const_value_type;
    constexpr std::size_t width = internal::width_of<Array>();
    std::vector<Number> rows(bytes_of(name, internal::tensor_type<Number>(), width * sizeof(Number)) / sizeof(Number));
    read(name, rows.data());
    view = Array(std::string(name), rows.size() / width);
    const auto host = make_mirror(view);
    for (std::size_t i = 0; i < rows.size(); ++i)
      internal::entry_of(host, i / width, i % width) = rows[i];
    Kokkos::deep_copy(view, host);
  }

  template <typename T> std::enable_if_t<std::is_arithmetic_v<T>> operator()(const char* name, T& value)
  {
    std::vector<T> values;
    (*this)(name, values);
    value = values.at(0);
  }

private:
  /// Of an array, whose rows have `row` bytes.
  std::size_t bytes_of(const char* name, const char* type, std::size_t row) const;
  void read(const char* name, void* data);

  std::string path;
  std::ifstream file;
  nlohmann::json header;
  std::size_t begin = 0; ///< of the arrays in the file
};
} // namespace kedge
