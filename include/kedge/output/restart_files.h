// Which restart files a run has, and which of them it goes on from.
#pragma once

#include <mpi.h>
#include <string>
#include <vector>

namespace kedge
{
/// Names of the restart files below a folder.
struct RestartFiles
{
  explicit RestartFiles(const std::string& folder);

  std::string folder;
  std::string latest; ///< restart.h5
  std::string before; ///< restart-before.h5: the one that `latest` has replaced
  std::string failed; ///< restart-failed.h5: of a run that failed; it replaces neither
};

/// Whether there is any. Of this process alone.
bool any_restart_file(const RestartFiles& files);

/// The undamaged one with most steps.
struct FoundRestartFile
{
  std::string path;
  std::vector<std::string> problems; ///< of the others
};

/// Throws FileError where there is none. Collective: rank 0 reads the files.
FoundRestartFile find_restart_file(const RestartFiles& files, MPI_Comm communicator);
} // namespace kedge
