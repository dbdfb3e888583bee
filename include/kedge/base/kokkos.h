// Execution and memory spaces and the device macro. This header and tpetra.h are the only places
// that differ between a CPU and a GPU build.
#pragma once

#include <Kokkos_Core.hpp>
#include <string>
#include <vector>

#define KEDGE_FUNCTION KOKKOS_INLINE_FUNCTION

namespace kedge
{
using ExecutionSpace = Kokkos::DefaultExecutionSpace;
using MemorySpace = ExecutionSpace::memory_space;

/// Array on the device; host code reaches it through HostView mirrors.
template <typename T> using View = Kokkos::View<T, MemorySpace>;

/// Mirror of View in host memory; the same storage where the device is the host.
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
