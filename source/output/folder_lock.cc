#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <kedge/base/exceptions.h>
#include <kedge/output/folder_lock.h>
#include <sys/file.h>
#include <unistd.h>

namespace kedge
{
void FolderLock::hold(const std::string& folder)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw FileError(folder, "cannot be created: " + error.message());
  descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw FileError(folder,
                    "is where another run writes now; wait for its end, or choose another folder with --output");
}

FolderLock::~FolderLock()
{
  if (descriptor >= 0)
    ::close(descriptor);
}
} // namespace kedge
