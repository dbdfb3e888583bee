// Copies between the handler's properties and the arrays of the mirrored fields, one particle at a time.
#pragma once

#include <kedge/particles/arrays.h>

namespace kedge
{
/// An array of a mirrored field on the host.
template <typename Array> struct HostCopy
{
  MirroredField<Array> field;
  typename Array::HostMirror values;

  static constexpr bool is_scalar = Array::rank == 1;
  static constexpr unsigned int n = is_scalar ? 1 : Array::static_extent(1);

  auto& at(const std::size_t p, const unsigned int i) const
  {
    if constexpr (is_scalar)
      return values(p);
    else
      return values(p, i);
  }

  /// From the properties of particle p.
  void take(const std::size_t p, const double* data) const
  {
    using Value = typename Array::value_type;
    for (unsigned int i = 0; i < n; ++i)
      at(p, i) = field.on_commit == OnCommit::adds ? Value(0) : static_cast<Value>(data[field.offset + i]);
  }

  /// To the properties of particle p, as the field says.
  void commit(const std::size_t p, double* data) const
  {
    for (unsigned int i = 0; i < n; ++i)
      if (field.on_commit == OnCommit::replaces)
        data[field.offset + i] = at(p, i);
      else if (field.on_commit == OnCommit::adds)
        data[field.offset + i] += at(p, i);
  }
};

/// Calls visit(mirrored field, its array) for every mirrored field.
template <typename Arrays, typename Visit> void for_each_array(Arrays& arrays, const Visit& visit)
{
  std::apply([&](const auto&... field) { (visit(field, arrays.*field.array), ...); }, mirrored_fields);
}

/// Arrays for n particles, not filled.
inline void allocate_arrays(ParticleArrays& arrays, const std::size_t n)
{
  const auto allocate = [n](auto& array, const std::string& label)
  { array = std::decay_t<decltype(array)>(Kokkos::view_alloc(label, Kokkos::WithoutInitializing), n); };
  arrays.n = n;
  allocate(arrays.elastic_left_cauchy_green, "left Cauchy-Green");
  allocate(arrays.cell_size, "cell size");
  allocate(arrays.trial_deformation, "trial dF");
  allocate(arrays.trial_frame, "trial frame");
  for_each_array(arrays, [&](const auto&, auto& array) { allocate(array, "mirrored field"); });
}

/// Bytes per particle of all arrays.
inline double bytes_per_particle(const ParticleArrays& arrays)
{
  double bytes = sizeof(double) * (6. + 1. + 9. + 12.);
  for_each_array(arrays,
                 [&](const auto&, const auto& array)
                 {
                   using Array = std::decay_t<decltype(array)>;
                   bytes += sizeof(typename Array::value_type) * HostCopy<Array>::n;
                 });
  return bytes;
}

/// The arrays on the host, to be filled (`with_values` false) or read.
inline auto host_copies(const ParticleArrays& arrays, const bool with_values)
{
  return std::apply(
      [&](const auto&... field)
      {
        const auto copy = [&](const auto& f)
        {
          const auto& array = arrays.*f.array;
          using Array = std::decay_t<decltype(array)>;
          const auto values = make_mirror(array);
          if (with_values && f.on_commit != OnCommit::nothing)
            Kokkos::deep_copy(values, array);
          return HostCopy<Array>{f, values};
        };
        return std::make_tuple(copy(field)...);
      },
      mirrored_fields);
}
} // namespace kedge
