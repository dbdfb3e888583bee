// Execution and memory spaces, device arrays and the device macro: Kokkos' default back end decides between CPU and
// GPU.
#pragma once

#include <Kokkos_Core.hpp>
#include <string>
#include <vector>

#define KEDGE_FUNCTION KOKKOS_INLINE_FUNCTION

namespace kedge
{
using ExecutionSpace = Kokkos::DefaultExecutionSpace;
using MemorySpace = ExecutionSpace::memory_space;

/// Array on the device. Host code accesses it through HostView mirrors.
template <typename T> using View = Kokkos::View<T, MemorySpace>;

/// Mirror of View in host memory. If the device is the host, both share their storage.
template <typename T> using HostView = typename View<T>::HostMirror;

/// Copies between host vectors and device arrays.
template <typename T> View<T*> upload(const std::vector<T>& host, const char* label)
{
  View<T*> device(Kokkos::view_alloc(std::string(label), Kokkos::WithoutInitializing), host.size());
  Kokkos::deep_copy(device, Kokkos::View<const T*, Kokkos::HostSpace>(host.data(), host.size()));
  return device;
}

template <typename T> std::vector<T> download(const View<T*>& device)
{
  const auto host = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), device);
  return std::vector<T>(host.data(), host.data() + host.extent(0));
}
} // namespace kedge
