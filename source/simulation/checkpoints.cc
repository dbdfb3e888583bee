#include <csignal>
#include <filesystem>
#include <kedge/base/communication.h>
#include <kedge/simulation/checkpoints.h>
#include <sstream>

namespace kedge
{
namespace
{
volatile std::sig_atomic_t told = 0; // the signal; a handler can reach nothing else

void note(const int signal) { told = signal; }
} // namespace

std::string restart_path(const OutputParameters& parameters, const std::string& output_directory)
{
  return (std::filesystem::path(output_directory) / parameters.checkpoint_directory / "restart.h5").string();
}

CheckpointSchedule::CheckpointSchedule(const OutputParameters& parameters, const std::string& output_directory)
    : file(restart_path(parameters, output_directory))
{
  told = 0;
  std::signal(SIGUSR1, note);
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
  std::signal(SIGTERM, note);
}

CheckpointSchedule::~CheckpointSchedule()
{
  for (const int signal : {SIGUSR1, SIGTERM})
    std::signal(signal, SIG_DFL);
}

void CheckpointSchedule::make_folder() const
{
  std::error_code ignored;
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::filesystem::create_directories(std::filesystem::path(file).parent_path(), ignored);
}

const char* CheckpointSchedule::told_to_end() const
{
  return ended_by == 0 ? nullptr : ended_by == SIGUSR1 ? "SIGUSR1" : "SIGTERM";
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
