// The one rule for failures in parallel: either all ranks know of a failure, or it ends the run.
//
// Work of one rank that may throw, and that does not communicate, goes into agree(): all ranks throw the same error.
// Whatever else throws may do so on one rank alone, while the others wait for it in a collective. Nobody may go on
// after such an error, so a catch block that goes on begins with rethrow_if_alone(). The error then ends up where a run
// or the program ends, which prints it and ends all ranks.
#pragma once

#include <cstdio>
#include <functional>
#include <mpi.h>
#include <string>

namespace kedge
{
/// Exit codes of the program.
enum ExitCode
{
  success = 0,
  mistake = 1, ///< in the program, or too little memory
  bad_input = 2,
  solver_failure = 3,
  file_failure = 4,
  interrupted = 130, ///< by SIGINT, with the shell's code for it
  told_to_end = 143  ///< by another signal; the shell's code for SIGTERM
};

/// An error as it can be sent to other ranks.
struct Failure
{
  ExitCode code = success;
  std::string path; ///< of InputError and FileError
  std::string message;
  bool is_named = true;    ///< one of base/exceptions.h
  bool is_of_disk = false; ///< a DiskError
};

/// Of the exception that is being handled.
Failure current_failure();

/// Does work of this rank. If it throws on any rank, all ranks throw the error of the first that failed, with its
/// number unless all say the same; a DiskError only if there is no other. Waits for all ranks, so the work must not
/// communicate. Collective.
void agree(MPI_Comm communicator, const std::function<void()>& work);

/// In a catch block: whether every rank handles an error at this place, a named one with the same words, as it does
/// after agree() and after a decision from reduced values. Waits a second for the others. False once this rank was
/// alone.
bool fails_everywhere(const std::string& place);

/// Throws the error that is being handled again unless fails_everywhere().
void rethrow_if_alone(const std::string& place);

/// Does collective work that writes files the run can do without. Returns what a DiskError says, or nothing.
std::string try_to_write(const std::string& place, const std::function<void()>& work);

/// Prints what can be printed: a log on a full disk is no reason to end.
void print(std::FILE* stream, const std::string& text);

/// For main(): what `program` returns. An error becomes a message with the program's name and its exit code; where one
/// rank fails alone, it ends all.
int exit_code_of(const std::string& name, const std::function<int()>& program);

/// Prints the failure with the number of this rank and ends all ranks with its exit code.
[[noreturn]] void abort_all_ranks(const Failure& failure);

/// Lets ranks meet in fails_everywhere(). For Environment alone, which also ends a run of which an error escapes.
void open_failure_channel();
void close_failure_channel();
} // namespace kedge
