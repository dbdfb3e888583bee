// What kernels and copies between host and device take, by the callbacks of Kokkos' tools.
#pragma once

#include <map>
#include <string>

namespace kedge
{
/// Calls of kernels of one name, or copies of one array from one memory to another.
struct ProfiledKernel
{
  unsigned long calls = 0;
  double seconds = 0.;
  double bytes = 0.; ///< of copies
};

/// By name: kernels; copies from one memory space to another (not those within one).
struct KernelProfile
{
  std::map<std::string, ProfiledKernel> kernels, copies;
};

/// Counts copies between memory spaces and, if `times_kernels`, times every kernel, which it then waits for: work that
/// host and device would do at once comes one after the other. One at a time in a program.
class KernelProfiler
{
public:
  explicit KernelProfiler(bool times_kernels);
  ~KernelProfiler();
  KernelProfiler(const KernelProfiler&) = delete;
  KernelProfiler& operator=(const KernelProfiler&) = delete;

  /// What has happened since the profiler was made.
  const KernelProfile& profile() const;
};

/// Bytes of all copies between memory spaces.
double copied_bytes(const KernelProfile& profile);

/// Tables for people: the `n` kernels and copies that take longest.
std::string format_profile(const KernelProfile& profile, std::size_t n);
} // namespace kedge
