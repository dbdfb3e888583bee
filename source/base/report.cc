#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <kedge/base/report.h>
#include <sys/resource.h>
#include <unistd.h>

namespace kedge
{
namespace
{
constexpr int bar_width = 12;

std::string format_duration(const double seconds)
{
  const long total = std::lround(seconds);
  if (total >= 3600)
    return fmt::format("{}h{:02d}m", total / 3600, (total / 60) % 60);
  return total >= 60 ? fmt::format("{}m{:02d}s", total / 60, total % 60) : fmt::format("{}s", total);
}
} // namespace

std::string format_progress(const ProgressLine& shown)
{
  const double fraction = shown.end > 0. ? std::min(1., shown.time / shown.end) : 1.;
  const int filled = static_cast<int>(fraction * bar_width);
  std::string bar;
  for (int i = 0; i < bar_width; ++i)
    bar += i < filled ? "█" : "░";
  const std::string start =
      fmt::format("stage {}/{} {} {:5.1f}% t {:.4g}/{:.4g} step {} Δt {:.3g}", shown.stage, shown.n_stages, bar,
                  100. * fraction, shown.time, shown.end, shown.step, shown.increment);
  const std::string end = fmt::format("cuts {} del {} N {}", shown.cuts, shown.deleted, shown.particles);
  return shown.is_explicit
             ? fmt::format("{} time steps {} {}", start, shown.iterations, end)
             : fmt::format("{} NR {} {} Krylov {}", start, shown.iterations, end, shown.krylov_iterations);
}

Report::Report(const bool speak_, const bool quiet_) : speak(speak_), quiet(quiet_), on_terminal(isatty(STDOUT_FILENO))
{
}

void Report::line(const std::string& text)
{
  end_progress();
  if (speak && !quiet)
  {
    fmt::print("{}\n", text);
    std::fflush(stdout);
  }
}

void Report::warn(const std::string& text)
{
  end_progress();
  given_warnings.push_back(text);
  if (speak)
    fmt::print(stderr, "warning: {}\n", text);
}

void Report::progress(const ProgressLine& shown)
{
  const double fraction = shown.end > 0. ? std::min(1., shown.time / shown.end) : 1.;
  if (shown.stage != last_stage) // in its first step, or in the first one after a restart
  {
    last_stage = shown.stage;
    last_percent = -1;
    first_seen = std::chrono::steady_clock::now();
    first_fraction = fraction;
  }
  const int percent = static_cast<int>(100. * fraction + 1e-6);
  if (!speak || quiet || (!on_terminal && percent == last_percent))
    return;
  last_percent = percent;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - first_seen).count();
  const double since = fraction - first_fraction;
  const std::string left = since > 0. ? " left " + format_duration(elapsed * (1. - fraction) / since) : "";
  fmt::print("{}{}{}{}", on_terminal ? "\r" : "", format_progress(shown), left, on_terminal ? "\x1b[K" : "\n");
  std::fflush(stdout);
  line_open = on_terminal;
}

void Report::end_progress()
{
  if (line_open)
    fmt::print("\n");
  line_open = false;
}

Timings::Scope::Scope(Timings& timings_, const char* phase_)
    : timings(timings_), phase(phase_), start(std::chrono::steady_clock::now())
{
}

Timings::Scope::~Scope()
{
  timings.totals[phase] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double peak_memory()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * static_cast<double>(usage.ru_maxrss);
}
} // namespace kedge
