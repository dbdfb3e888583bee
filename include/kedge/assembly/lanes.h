// Vectors of dim numbers in whole SIMD registers.
#pragma once

#include <Eigen/Core>
#include <kedge/base/kokkos.h>

namespace kedge
{
/// dim numbers in whole SIMD registers. The lane behind them holds what happens to follow in memory, and counts for
/// nothing.
template <int dim> struct Lanes
{
  static constexpr int size = dim + dim % 2;
  using Type = Eigen::Array<double, size, 1>;

  template <typename Number>
  KEDGE_FUNCTION static Eigen::Map<const Eigen::Array<Number, size, 1>> map(const Number* from)
  {
    return Eigen::Map<const Eigen::Array<Number, size, 1>>(from);
  }
  template <typename Number> KEDGE_FUNCTION static Type read(const Number* from)
  {
    return map(from).template cast<double>();
  }
};

/// By particle, rows of Lanes one after the other, neighbours in memory.
template <typename Number> using Rows = Kokkos::View<Number**, Kokkos::LayoutRight, MemorySpace>;
} // namespace kedge
