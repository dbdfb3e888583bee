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

/// What is done with kernels.
enum class KernelWatch
{
  none,  ///< only copies are counted
  time,  ///< every kernel is waited for: work that host and device would do at once comes one after the other
  names, ///< in addition each name is printed to stderr before the kernel begins: the last one hangs, or dies
};

/// By name: kernels; copies from one memory space to another (not those within one).
struct KernelProfile
{
  std::map<std::string, ProfiledKernel> kernels, copies;
};

/// Counts copies between memory spaces and watches kernels. One at a time in a program.
class KernelProfiler
{
public:
  explicit KernelProfiler(KernelWatch watch);
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
