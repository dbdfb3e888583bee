// A last line that tells whether any byte of a file has changed.
#pragma once

#include <string>

namespace kedge
{
/// Appends the line: the number of bytes before it and their CRC-32 (zlib). Waits until the file is on the disk. Throws
/// FileError.
void seal(const std::string& path);

/// Throws FileError where the file cannot be read, or where its last line is not that of its bytes.
void require_sealed(const std::string& path);

/// Waits until the names in a folder are on the disk, where the file system can do that.
void sync_folder(const std::string& folder);
} // namespace kedge
