#include <csignal>
#include <filesystem>
#include <kedge/base/communication.h>
#include <kedge/output/earlier_files.h>
#include <kedge/simulation/checkpoints.h>
#include <sstream>
#include <unistd.h>

namespace kedge
{
namespace
{
volatile std::sig_atomic_t told = 0; // the signal; a handler can reach nothing else
volatile std::sig_atomic_t speaks = 0;

/// A run does not listen to a signal that it was started to ignore, as nohup and background jobs ask.
struct Listening
{
  int signal;
  volatile std::sig_atomic_t listens;
  void (*before)(int); ///< the handler to give back
};
Listening all_signals[] = {{SIGTERM, 0, SIG_DFL}, {SIGINT, 0, SIG_DFL}, {SIGUSR1, 0, SIG_DFL}, {SIGHUP, 0, SIG_DFL}};

bool is_ignored(const int signal)
{
  struct sigaction now;
  return sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

void note(const int signal)
{
  if (speaks != 0 && told == 0)
  {
    constexpr char text[] =
        "\nkedge: told to end: after this step, with a restart file; a second SIGTERM or Ctrl-C ends it at once\n";
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, sizeof(text) - 1);
  }
  if (told == 0)
    told = signal;
  if (signal == SIGTERM || signal == SIGINT)
    for (const Listening& other : all_signals)
      if (other.listens != 0 && (other.signal == SIGTERM || other.signal == SIGINT))
        std::signal(other.signal, SIG_DFL);
}
} // namespace

const char* name_of_signal(const int signal)
{
  return signal == SIGTERM ? "SIGTERM" : signal == SIGINT ? "SIGINT" : signal == SIGHUP ? "SIGHUP" : "SIGUSR1";
}

std::string restart_folder(const OutputParameters& parameters, const std::string& output_directory)
{
  return (std::filesystem::path(output_directory) / parameters.checkpoint_directory).string();
}

CheckpointSchedule::CheckpointSchedule(const OutputParameters& parameters, const std::string& output_directory)
    : names(restart_folder(parameters, output_directory))
{
  told = 0;
  speaks = rank_of(MPI_COMM_WORLD) == 0;
  for (Listening& one : all_signals)
    if (!is_ignored(one.signal))
    {
      one.listens = 1;
      one.before = std::signal(one.signal, note);
    }
  if (parameters.checkpoint_every.empty())
    return;
  std::istringstream text(parameters.checkpoint_every);
  double number = 0.;
  std::string unit;
  text >> number >> unit;
  if (unit.empty())
    every_steps = static_cast<unsigned int>(number);
  else
    every_seconds = number * (unit == "h" ? 3600. : unit == "min" ? 60. : 1.);
}

CheckpointSchedule::~CheckpointSchedule()
{
  for (Listening& one : all_signals)
    if (one.listens != 0)
    {
      one.listens = 0;
      std::signal(one.signal, one.before);
    }
}

void CheckpointSchedule::make_folder() const
{
  std::error_code ignored;
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::filesystem::create_directories(names.folder, ignored);
}

void CheckpointSchedule::remove_files() const
{
  if (rank_of(MPI_COMM_WORLD) != 0)
    return;
  for (const std::string& path : {names.latest, names.before, names.failed})
    remove_earlier_file(path);
}

bool CheckpointSchedule::due()
{
  ++steps;
  const auto now = std::chrono::steady_clock::now();
  const bool by_time = every_seconds > 0. && std::chrono::duration<double>(now - last).count() >= every_seconds;
  ended_by = static_cast<int>(max_over_ranks(told, MPI_COMM_WORLD));
  const bool result =
      ended_by != 0 || (every_steps > 0 && steps >= every_steps) || max_over_ranks(by_time, MPI_COMM_WORLD) > 0.;
  if (result)
  {
    steps = 0;
    last = now;
  }
  return result;
}
} // namespace kedge
