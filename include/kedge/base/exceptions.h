// Errors by cause, with the data that belongs to them. main() turns each into an exit code and a message.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace kedge
{
/// An error from its finished text, as another rank gives it.
struct Whole
{
  std::string path, message;
};

/// Wrong input: the JSON path (or file, or command-line option) at fault, what is wrong and the remedy. Exit code 2.
struct InputError : std::runtime_error
{
  InputError(std::string path_, const std::string& problem, const std::string& remedy = "")
      : std::runtime_error(path_ + ": " + problem + (remedy.empty() ? "" : "; " + remedy)), path(std::move(path_))
  {
  }
  explicit InputError(const Whole& text) : std::runtime_error(text.message), path(text.path) {}
  std::string path;
};

/// The equations could not be solved. Exit code 3.
struct SolverError : std::runtime_error
{
  SolverError(const std::string& message, std::vector<double> residual_history_ = {})
      : std::runtime_error(message), residual_history(std::move(residual_history_))
  {
  }
  std::vector<double> residual_history;
};

/// A file could not be read or written. Exit code 4.
struct FileError : std::runtime_error
{
  FileError(std::string path_, const std::string& problem)
      : std::runtime_error(path_ + ": " + problem), path(std::move(path_))
  {
  }
  explicit FileError(const Whole& text) : std::runtime_error(text.message), path(text.path) {}
  std::string path;
};

/// A file that the disk does not take: it is full, at a quota or a limit, or fails. There may be room again later, so a
/// run goes on without the file.
struct DiskError : FileError
{
  using FileError::FileError;
};

/// Anything else, as another rank reports it: too little memory, or a mistake in the program. Exit code 1.
struct ProgramError : std::runtime_error
{
  using std::runtime_error::runtime_error;
};
} // namespace kedge
