#include <filesystem>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/checkpoint.h>
#include <kedge/output/restart_files.h>

namespace kedge
{
namespace
{
bool exists(const std::string& path)
{
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

void require_any(const RestartFiles& files)
{
  if (!any_restart_file(files))
    throw FileError(files.latest,
                    "is not there, so nothing can go on; run without --restart, with \"checkpoint every\" for a "
                    "restart file, or name the folder of the first run with --output");
}

FoundRestartFile find_here(const RestartFiles& files)
{
  FoundRestartFile found;
  unsigned int most = 0;
  for (const std::string& path : {files.latest, files.failed, files.before})
    if (exists(path))
      try
      {
        if (const unsigned int step = step_of_checkpoint(path); found.path.empty() || step > most)
        {
          found.path = path;
          most = step;
        }
      }
      catch (const FileError& error)
      {
        found.problems.push_back(error.what());
      }
  if (!found.path.empty())
    return found;
  std::string all;
  for (const std::string& problem : found.problems)
    all += "\n  " + problem;
  throw FileError(files.folder, "has no restart file that can be read; start again without --restart:" + all);
}
} // namespace

RestartFiles::RestartFiles(const std::string& folder_) : folder(folder_)
{
  const auto path = [&](const char* name) { return (std::filesystem::path(folder) / name).string(); };
  latest = path("restart.h5");
  before = path("restart-before.h5");
  failed = path("restart-failed.h5");
}

bool any_restart_file(const RestartFiles& files)
{
  return exists(files.latest) || exists(files.before) || exists(files.failed);
}

FoundRestartFile find_restart_file(const RestartFiles& files, const MPI_Comm communicator)
{
  FoundRestartFile found;
  agree(communicator,
        [&]
        {
          require_any(files);
          if (rank_of(communicator) == 0)
            found = find_here(files);
        });
  broadcast(found.path, 0, communicator);
  return found;
}
} // namespace kedge
