#include <cerrno>
#include <fcntl.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/folder_lock.h>
#include <kedge/output/text_file.h>
#include <sys/file.h>
#include <unistd.h>

namespace kedge
{
void FolderLock::hold(const std::string& folder)
{
  create_folder(folder);
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
