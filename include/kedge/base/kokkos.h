// Execution and memory spaces, device arrays and the device macro: Kokkos' default back end decides between CPU and
// GPU.
#pragma once

#include <Kokkos_Core.hpp>
#include <string>
#include <type_traits>
#include <vector>

#define KEDGE_FUNCTION KOKKOS_INLINE_FUNCTION

namespace kedge
{
using ExecutionSpace = Kokkos::DefaultExecutionSpace;
using MemorySpace = ExecutionSpace::memory_space;

/// Whether kernels and the host see the same memory.
constexpr bool device_is_host = std::is_same<MemorySpace, Kokkos::HostSpace>::value;

/// Whether one thread runs the kernels: what it adds up needs no atomic, and rooms for one item serve all in turn.
#ifdef KOKKOS_ENABLE_SERIAL
constexpr bool one_thread = std::is_same<ExecutionSpace, Kokkos::Serial>::value;
#else
constexpr bool one_thread = false;
#endif

/// Adds to a number that several threads may change.
KEDGE_FUNCTION void add_to(double& target, const double value)
{
  if constexpr (one_thread)
    target += value;
  else
    Kokkos::atomic_add(&target, value);
}

/// Array on the device. Host code accesses it through HostView mirrors.
template <typename T> using View = Kokkos::View<T, MemorySpace>;

/// Mirror of View in host memory. If the device is the host, both share their storage.
template <typename T> using HostView = typename View<T>::HostMirror;

/// Whether mirrors have storage of their own also where the device is the host, so that tests without a GPU count its
/// copies and notice a missing one: the environment has KEDGE_MIRRORS_APART=1.
bool mirrors_apart();

/// Of the labels of mirrors with their own storage.
constexpr const char* mirror_suffix = " on the host";

/// Where the host reads and writes what the device has; it holds the device's values only if both share their storage.
template <typename Array> typename Array::HostMirror make_mirror(const Array& device)
{
  using Mirror = typename Array::HostMirror;
  if constexpr (device_is_host)
    if (!mirrors_apart())
      return Kokkos::create_mirror_view(device);
  return Mirror(Kokkos::view_alloc(device.label() + mirror_suffix, Kokkos::WithoutInitializing), device.layout());
}

/// A mirror with the device's values.
template <typename Array> typename Array::HostMirror copy_to_host(const Array& device)
{
  const typename Array::HostMirror host = make_mirror(device);
  Kokkos::deep_copy(host, device);
  return host;
}

/// The values of a mirror on the device; where that is the host, both may share their storage.
template <typename T> View<T*> copy_to_device(const HostView<T*>& host)
{
  if constexpr (device_is_host)
    if (!mirrors_apart())
      return host;
  View<T*> device(Kokkos::view_alloc(host.label(), Kokkos::WithoutInitializing), host.extent(0));
  Kokkos::deep_copy(device, host);
  return device;
}

/// Copies between host vectors and device arrays.
template <typename T> View<T*> upload(const std::vector<T>& host, const char* label)
{
  View<T*> device(Kokkos::view_alloc(std::string(label), Kokkos::WithoutInitializing), host.size());
  Kokkos::deep_copy(device, Kokkos::View<const T*, Kokkos::HostSpace>(host.data(), host.size()));
  return device;
}

template <typename T> std::vector<T> download(const View<T*>& device)
{
  const auto host = copy_to_host(device);
  return std::vector<T>(host.data(), host.data() + host.extent(0));
}
} // namespace kedge
