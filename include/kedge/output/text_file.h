// Whole files at once, with an error that names the file.
#pragma once

#include <functional>
#include <mpi.h>
#include <string>

namespace kedge
{
/// Writes `text` (any bytes) to `path`, replacing what stood there. Throws FileError.
void write_text_file(const std::string& path, const std::string& text);

/// The same through a second name and a renaming, so that a reader sees the old file or the new one, never a part.
void replace_text_file(const std::string& path, const std::string& text);

/// Everything in the file. Throws FileError.
std::string read_text_file(const std::string& path);

/// Runs what may fail on one rank alone; where it does, all ranks throw a FileError. Collective.
void fail_together(const std::string& path, MPI_Comm communicator, const std::function<void()>& action);
} // namespace kedge
