// Execution and memory spaces and the device macro. This header and tpetra.h are the only places
// that differ between a CPU and a GPU build.
#pragma once

#include <Kokkos_Core.hpp>

#define KEDGE_FUNCTION KOKKOS_INLINE_FUNCTION

namespace kedge
{
using ExecutionSpace = Kokkos::DefaultExecutionSpace;
using MemorySpace = ExecutionSpace::memory_space;

/// Array on the device; host code reaches it through HostView mirrors.
template <typename T> using View = Kokkos::View<T, MemorySpace>;

/// Mirror of View in host memory; the same storage where the device is the host.
template <typename T> using HostView = typename View<T>::HostMirror;
} // namespace kedge
