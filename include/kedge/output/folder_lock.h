// Keeps two runs out of one folder.
#pragma once

#include <string>

namespace kedge
{
/// Makes a folder and holds it until this object, or the process, ends. Does nothing where the file system knows no
/// locks. For one rank.
class FolderLock
{
public:
  FolderLock() = default;
  /// Throws FileError where the folder cannot be made or another process holds it.
  void hold(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

private:
  int descriptor = -1;
};
} // namespace kedge
