#include <algorithm>
#include <fcntl.h>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/seal.h>
#include <kedge/output/text_file.h>
#include <unistd.h>
#include <vector>
#include <zlib.h>

namespace kedge
{
namespace
{
std::string line_of(const long long bytes, const unsigned long crc)
{
  return fmt::format("\nsealed by Kedge: {:020} bytes, CRC-32 {:08x}\n", bytes, crc);
}

/// An open file; closed when it goes out of scope.
class Descriptor
{
public:
  Descriptor(const std::string& path, const int flags) : path(path), number(::open(path.c_str(), flags))
  {
    require(number >= 0, "cannot be opened");
  }
  ~Descriptor()
  {
    if (number >= 0)
      ::close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return number; }

  void require(const bool sound, const std::string& problem) const
  {
    if (!sound)
      throw FileError(path, problem + ": " + last_system_message());
  }

private:
  std::string path;
  int number;
};

/// Of the first bytes of a file. Reads from where the file stands, its beginning.
unsigned long crc_of(const Descriptor& file, long long bytes)
{
  std::vector<unsigned char> part(std::size_t(1) << 20);
  unsigned long crc = ::crc32(0, nullptr, 0);
  while (bytes > 0)
  {
    const ssize_t got = ::read(file, part.data(), std::min<long long>(bytes, part.size()));
    file.require(got > 0, "cannot be read");
    crc = ::crc32(crc, part.data(), static_cast<unsigned int>(got));
    bytes -= got;
  }
  return crc;
}
} // namespace

void seal(const std::string& path)
{
  const Descriptor file(path, O_RDWR);
  const long long bytes = ::lseek(file, 0, SEEK_END);
  ::lseek(file, 0, SEEK_SET);
  const std::string line = line_of(bytes, crc_of(file, bytes));
  file.require(::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size()) && ::fsync(file) == 0,
               "could not be written in full");
}

void require_sealed(const std::string& path)
{
  const Descriptor file(path, O_RDONLY);
  const long long length = line_of(0, 0).size(), bytes = ::lseek(file, 0, SEEK_END) - length;
  std::string line(length, ' ');
  ::lseek(file, 0, SEEK_SET);
  if (bytes < 0 || ::pread(file, line.data(), length, bytes) != length || line.rfind("\nsealed by Kedge: ", 0) != 0)
    throw FileError(path, "has no seal at its end: it is incomplete or damaged, or another version wrote it");
  if (line != line_of(bytes, crc_of(file, bytes)))
    throw FileError(path, "is damaged: its seal is not that of its contents");
}

void sync_folder(const std::string& folder)
{
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0)
    return;
  ::fsync(descriptor);
  ::close(descriptor);
}
} // namespace kedge
