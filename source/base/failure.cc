#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <system_error>
#include <thread>

namespace kedge
{
namespace
{
/// How long a rank waits for the others to fail too. They come from the same collective, so they are not far.
constexpr std::chrono::milliseconds patience(1000), pause(1);

MPI_Comm channel = MPI_COMM_NULL; // of its own: the other ranks may be anywhere in another one
bool is_alone = false;

/// A message that echoes an input of megabytes helps nobody.
std::string shortened(const std::string& message)
{
  constexpr std::size_t half = 1000;
  return message.size() <= 2 * half + 100 ? message
                                          : message.substr(0, half) + " [...] " + message.substr(message.size() - half);
}

[[noreturn]] void throw_again(const Failure& failure, const std::string& whose)
{
  const std::string message = whose + failure.message;
  switch (failure.code)
  {
    case bad_input:
      throw InputError(Whole{failure.path, message});
    case solver_failure:
      throw SolverError(message);
    case file_failure:
      if (failure.is_of_disk)
        throw DiskError(Whole{failure.path, message});
      throw FileError(Whole{failure.path, message});
    case success:
    case mistake:
    case interrupted:
    case told_to_end:
      break;
  }
  throw ProgramError(message);
}

/// Equal texts have equal numbers, on every rank (FNV-1a).
unsigned int number_of(const std::string& text)
{
  unsigned int number = 2166136261u;
  for (const char letter : text)
    number = (number ^ static_cast<unsigned char>(letter)) * 16777619u;
  return number;
}

void abort_unless_caught()
{
  Failure failure{mistake, "", "the program was terminated", false};
  if (std::current_exception())
    failure = current_failure();
  abort_all_ranks(failure);
}
} // namespace

Failure current_failure()
{
  try
  {
    throw;
  }
  catch (const InputError& error)
  {
    return {bad_input, error.path, shortened(error.what())};
  }
  catch (const SolverError& error)
  {
    return {solver_failure, "", error.what()};
  }
  catch (const DiskError& error)
  {
    return {file_failure, error.path, error.what(), true, true};
  }
  catch (const FileError& error)
  {
    return {file_failure, error.path, error.what()};
  }
  catch (const ProgramError& error)
  {
    return {mistake, "", error.what()};
  }
  catch (const std::system_error& error) // of a stream such as the terminal
  {
    return {file_failure, "", error.what(), false};
  }
  catch (const std::bad_alloc&)
  {
    return {mistake, "", "there is too little memory; use more nodes, fewer ranks on each, or larger cells", false};
  }
  catch (const std::exception& error)
  {
    return {mistake, "", fmt::format("{} (a mistake in the program: please report it with the input)", error.what()),
            false};
  }
  catch (...)
  {
    return {mistake, "", "an unknown error (a mistake in the program: please report it with the input)", false};
  }
}

void agree(const MPI_Comm communicator, const std::function<void()>& work)
{
  const int size = size_of(communicator), rank = rank_of(communicator);
  if (size == 1)
    return work();
  Failure mine;
  try
  {
    work();
  }
  catch (...)
  {
    mine = current_failure();
  }
  // Ranks with a DiskError come last: an error that ends the run must not be lost behind it.
  const int place = mine.code == success ? 2 * size : mine.is_of_disk ? size + rank : rank;
  const int first_place = static_cast<int>(min_over_ranks(place, communicator)), first = first_place % size;
  if (first_place == 2 * size)
    return;
  Failure agreed = mine;
  agreed.is_of_disk = first_place >= size;
  int code = mine.code;
  MPI_Bcast(&code, 1, MPI_INT, first, communicator);
  agreed.code = static_cast<ExitCode>(code);
  broadcast(agreed.path, first, communicator);
  broadcast(agreed.message, first, communicator);
  const bool by_all = min_over_ranks(agreed.message == mine.message, communicator) > 0.;
  throw_again(agreed, by_all ? "" : fmt::format("rank {}: ", first));
}

bool fails_everywhere(const std::string& place)
{
  const int size = size_of(MPI_COMM_WORLD);
  if (size == 1)
    return true;
  if (is_alone || channel == MPI_COMM_NULL)
    return false;
  static std::vector<unsigned int> all; // outlive this call: the last rank may come after it
  static unsigned int here = 0;
  const Failure failure = current_failure();
  here = number_of(place + (failure.is_named ? failure.message : ""));
  all.assign(size, 0);
  MPI_Request request;
  MPI_Iallgather(&here, 1, MPI_UNSIGNED, all.data(), 1, MPI_UNSIGNED, channel, &request);
  const auto end = std::chrono::steady_clock::now() + patience;
  int done = 0;
  for (MPI_Test(&request, &done, MPI_STATUS_IGNORE); !done && std::chrono::steady_clock::now() < end;
       MPI_Test(&request, &done, MPI_STATUS_IGNORE))
    std::this_thread::sleep_for(pause);
  is_alone = !done;
  for (const unsigned int other : all)
    is_alone = is_alone || other != here;
  return !is_alone;
}

void rethrow_if_alone(const std::string& place)
{
  if (!fails_everywhere(place))
    throw;
}

std::string try_to_write(const std::string& place, const std::function<void()>& work)
{
  try
  {
    work();
  }
  catch (const DiskError& error)
  {
    rethrow_if_alone(place);
    return error.what();
  }
  return "";
}

void print(std::FILE* stream, const std::string& text)
{
  std::fputs(text.c_str(), stream);
  std::fflush(stream);
  std::clearerr(stream);
}

int exit_code_of(const std::string& name, const std::function<int()>& program)
{
  try
  {
    return program();
  }
  catch (...)
  {
    const Failure failure = current_failure();
    if (!failure.is_named || !fails_everywhere("program"))
      abort_all_ranks(failure);
    if (rank_of(MPI_COMM_WORLD) == 0)
      print(stderr, fmt::format("{}: {}\n", name, failure.message));
    return failure.code;
  }
}

void abort_all_ranks(const Failure& failure)
{
  std::fflush(stdout);
  const bool has_others = size_of(MPI_COMM_WORLD) > 1;
  const std::string whose = has_others ? fmt::format("rank {}: ", rank_of(MPI_COMM_WORLD)) : "";
  print(stderr, fmt::format("kedge: {}{}\n", whose, failure.message));
  if (has_others)
    MPI_Abort(MPI_COMM_WORLD, failure.code);
  std::_Exit(failure.code);
}

void open_failure_channel()
{
  MPI_Comm_dup(MPI_COMM_WORLD, &channel);
  std::set_terminate(abort_unless_caught);
}

void close_failure_channel() { MPI_Comm_free(&channel); }
} // namespace kedge
