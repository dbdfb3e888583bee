#include <algorithm>
#include <chrono>
#include <cstring>
#include <fmt/format.h>
#include <kedge/base/kokkos.h>
#include <kedge/replay/kernel_profile.h>
#include <vector>

namespace kedge
{
namespace
{
using Clock = std::chrono::steady_clock;

/// Kokkos' callbacks are plain functions: what they write must be reachable without arguments.
struct Recording
{
  KernelProfile profile;
  bool prints = false;
  std::vector<std::pair<ProfiledKernel*, Clock::time_point>> open; ///< kernels that have begun, the last one innermost
  ProfiledKernel* copy = nullptr;                                  ///< the present one, if it is between memory spaces
  Clock::time_point copy_begin;
};

Recording& recording()
{
  static Recording one;
  return one;
}

void end(ProfiledKernel& entry, const Clock::time_point begin)
{
  const std::chrono::duration<double> passed = Clock::now() - begin;
  ++entry.calls;
  entry.seconds += passed.count();
}

void begin_kernel(const char* name, std::uint32_t, std::uint64_t* id)
{
  *id = 0;
  Kokkos::fence();
  if (recording().prints)
    fmt::print(stderr, "{}\n", name);
  recording().open.emplace_back(&recording().profile.kernels[name], Clock::now());
}

void end_kernel(std::uint64_t)
{
  if (recording().open.empty())
    return;
  Kokkos::fence();
  end(*recording().open.back().first, recording().open.back().second);
  recording().open.pop_back();
}

/// Of host memory: a mirror or, without a label, a vector.
bool is_hosts(const std::string& label)
{
  const std::string suffix = mirror_suffix;
  return label.empty() ||
         (label.size() > suffix.size() && label.compare(label.size() - suffix.size(), suffix.size(), suffix) == 0);
}

void begin_copy(Kokkos_Profiling_SpaceHandle to, const char* label, const void*, Kokkos_Profiling_SpaceHandle from,
                const char* from_label, const void*, const std::uint64_t bytes)
{
  Recording& at = recording();
  const bool is_fill = std::strcmp(from_label, "Scalar") == 0; // by one number, which is all that crosses
  const bool stays = mirrors_apart() ? is_hosts(label) == is_hosts(from_label) : std::strcmp(to.name, from.name) == 0;
  if (is_fill || stays)
    return;
  at.copy = &at.profile.copies[fmt::format("{} to {}: {} to {}", from.name, to.name, from_label, label)];
  at.copy->bytes += static_cast<double>(bytes);
  at.copy_begin = Clock::now();
}

void end_copy()
{
  Recording& at = recording();
  if (at.copy != nullptr)
    end(*at.copy, at.copy_begin);
  at.copy = nullptr;
}

std::string table(const std::map<std::string, ProfiledKernel>& entries, const std::size_t n)
{
  std::vector<std::pair<std::string, ProfiledKernel>> sorted(entries.begin(), entries.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& a, const auto& b) { return a.second.seconds > b.second.seconds; });
  std::string text;
  for (std::size_t i = 0; i < std::min(n, sorted.size()); ++i)
    text += fmt::format("{:>10.3g}{:>8}{:>10.3g}  {}\n", 1e3 * sorted[i].second.seconds, sorted[i].second.calls,
                        1e-6 * sorted[i].second.bytes, sorted[i].first.substr(0, 110));
  return text;
}
} // namespace

KernelProfiler::KernelProfiler(const KernelWatch watch)
{
  using namespace Kokkos::Tools::Experimental;
  recording() = Recording();
  recording().prints = watch == KernelWatch::names;
  set_begin_deep_copy_callback(begin_copy);
  set_end_deep_copy_callback(end_copy);
  if (watch == KernelWatch::none)
    return;
  set_begin_parallel_for_callback(begin_kernel);
  set_end_parallel_for_callback(end_kernel);
  set_begin_parallel_reduce_callback(begin_kernel);
  set_end_parallel_reduce_callback(end_kernel);
  set_begin_parallel_scan_callback(begin_kernel);
  set_end_parallel_scan_callback(end_kernel);
}

KernelProfiler::~KernelProfiler()
{
  using namespace Kokkos::Tools::Experimental;
  set_begin_deep_copy_callback(nullptr);
  set_end_deep_copy_callback(nullptr);
  set_begin_parallel_for_callback(nullptr);
  set_end_parallel_for_callback(nullptr);
  set_begin_parallel_reduce_callback(nullptr);
  set_end_parallel_reduce_callback(nullptr);
  set_begin_parallel_scan_callback(nullptr);
  set_end_parallel_scan_callback(nullptr);
}

const KernelProfile& KernelProfiler::profile() const { return recording().profile; }

double copied_bytes(const KernelProfile& profile)
{
  double sum = 0.;
  for (const auto& [name, copy] : profile.copies)
    sum += copy.bytes;
  return sum;
}

std::string format_profile(const KernelProfile& profile, const std::size_t n)
{
  std::string text = fmt::format("{:>10}{:>8}{:>10}  kernel or copy\n", "ms", "calls", "MB");
  return text + table(profile.kernels, n) + table(profile.copies, n);
}
} // namespace kedge
