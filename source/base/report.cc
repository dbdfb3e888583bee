#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <kedge/base/failure.h>
#include <kedge/base/report.h>
#include <sys/ioctl.h>
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
/// Whether lines on the standard output can be drawn anew. mpirun gives its ranks terminals without a size whatever its
/// own output is; scripts/mpirun says with KEDGE_TERMINAL that that one is a terminal.
bool is_on_terminal()
{
  winsize size{};
  if (!isatty(STDOUT_FILENO) || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0)
    return false;
  return size.ws_col > 0 || std::getenv("KEDGE_TERMINAL");
}
} // namespace

std::string format_progress(const ProgressLine& shown)
{
  const double fraction = shown.fraction();
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

Report::Report(const bool speak_, const bool quiet_, const double interval_)
    : speak(speak_), quiet(quiet_), on_terminal(is_on_terminal()), interval(interval_)
{
}

void Report::line(const std::string& text)
{
  close_line();
  if (speak && !quiet)
    print(stdout, text + "\n");
}

void Report::warn(const std::string& text)
{
  close_line();
  given_warnings.push_back(text);
  if (speak)
    print(stderr, "warning: " + text + "\n");
}

void Report::progress(const ProgressLine& shown)
{
  using Clock = std::chrono::steady_clock;
  const Clock::time_point now = Clock::now();
  const auto seconds_since = [now](const Clock::time_point& then)
  { return std::chrono::duration<double>(now - then).count(); };
  const double fraction = shown.fraction();
  const bool is_first = shown.stage != last_stage; // step of the stage, or after a restart
  if (is_first)
  {
    last_stage = shown.stage;
    first_seen = now;
    first_fraction = fraction;
  }
  if (!speak || quiet)
    return;
  const double done = fraction - first_fraction;
  const std::string left =
      done > 0. ? " left " + format_duration(seconds_since(first_seen) * (1. - fraction) / done) : "";
  const std::string text = format_progress(shown) + left;
  if (on_terminal)
    print(stdout, "\r" + text + "\x1b[K");
  else if (is_first || seconds_since(last_line) >= interval)
  {
    print(stdout, text + "\n");
    last_line = now;
    waiting.clear();
  }
  else
    waiting = text;
  line_open = on_terminal;
}

void Report::end_progress()
{
  close_line();
  if (!waiting.empty())
    print(stdout, waiting + "\n");
  waiting.clear();
}

/// So that other text begins on a line of its own.
void Report::close_line()
{
  if (line_open)
    print(stdout, "\n");
  line_open = false;
}

Timings::Scope::Scope(Timings& timings_, const char* phase_)
    : timings(timings_), phase(phase_), start(std::chrono::steady_clock::now()), within_others(timings.within)
{
  timings.within = 0.;
}

Timings::Scope::~Scope()
{
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  timings.totals[phase] += elapsed - timings.within;
  timings.within = within_others + elapsed;
}

double peak_memory()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * static_cast<double>(usage.ru_maxrss);
}
} // namespace kedge
