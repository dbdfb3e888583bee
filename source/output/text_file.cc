#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <kedge/base/exceptions.h>
#include <kedge/output/text_file.h>
#include <sstream>
#include <system_error>

namespace kedge
{
std::string last_system_message() { return std::generic_category().message(errno); }

namespace
{
/// What the system says of a file that it does not take now and may take later. EIO is what network file systems say of
/// a write that failed behind the program's back.
bool is_of_disk(const int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG || error == EIO; }

[[noreturn]] void fail(const std::string& path, const std::string& problem, const int error)
{
  const std::string text = problem + ": " + std::generic_category().message(error);
  if (is_of_disk(error))
    throw DiskError(path, text);
  throw FileError(path, text);
}

/// Returns the error of the system, 0 if there is none. C streams set errno on failure; C++ streams need not.
int write_to(std::FILE* file, const std::string& text)
{
  const int problem = std::fwrite(text.data(), 1, text.size(), file) == text.size() ? 0 : errno;
  // A full disk may be noticed only when the buffer is flushed.
  const int problem_of_end = std::fclose(file) == 0 ? 0 : errno;
  return problem != 0 ? problem : problem_of_end;
}

std::FILE* open_to_write(const std::string& path, const char* const mode, const std::string& name)
{
  std::FILE* const file = std::fopen(path.c_str(), mode);
  if (!file)
    fail(name, "cannot be opened for writing", errno);
  return file;
}
} // namespace

void create_folder(const std::string& folder)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw FileError(folder, "cannot be created: " + error.message());
}

void write_text_file(const std::string& path, const std::string& text)
{
  if (const int problem = write_to(open_to_write(path, "wb", path), text))
    fail(path, "could not be written in full", problem);
}

void append_text(const std::string& path, const std::string& text)
{
  std::FILE* const file = open_to_write(path, "ab", path);
  std::error_code unknown, kept;
  const std::uintmax_t size = std::filesystem::file_size(path, unknown);
  const int problem = write_to(file, text);
  if (problem == 0)
    return;
  if (!unknown)
    std::filesystem::resize_file(path, size, kept);
  if (kept)
    throw FileError(path, "ends in a part of what could not be written in full: " + kept.message());
  fail(path, "could not be written in full", problem);
}

std::string draft_of(const std::string& path) { return path + ".new"; }

void give_name(const std::string& path)
{
  if (std::rename(draft_of(path).c_str(), path.c_str()) == 0)
    return;
  const int problem = errno;
  std::remove(draft_of(path).c_str());
  fail(path, "cannot be replaced", problem);
}

void replace_text_file(const std::string& path, const std::string& text)
{
  const std::string draft = draft_of(path);
  if (const int problem = write_to(open_to_write(draft, "wb", path), text))
  {
    std::remove(draft.c_str());
    fail(path, "could not be written in full", problem);
  }
  give_name(path);
}

bool write_in_place(const std::string& path, std::string text)
{
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(path, unknown);
  if (unknown || text.size() > size)
    return false;
  text.append(size - text.size(), ' ');
  if (const int problem = write_to(open_to_write(path, "r+b", path), text))
    fail(path, "could not be written in full", problem);
  return true;
}

std::string read_text_file(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file.peek() != std::ifstream::traits_type::eof())
    text << file.rdbuf();
  if (!file.is_open() || file.bad())
    throw FileError(path, "cannot be read: " + last_system_message());
  return text.str();
}
} // namespace kedge
