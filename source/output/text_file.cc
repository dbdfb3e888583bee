#include <cerrno>
#include <cstdio>
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
void write_in_mode(const std::string& path, const std::string& text, const char* const mode)
{
  // C streams set errno on failure; C++ streams need not.
  std::FILE* file = std::fopen(path.c_str(), mode);
  if (!file)
    throw FileError(path, "cannot be opened for writing: " + last_system_message());
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const std::string problem = written ? "" : last_system_message();
  // A full disk may be noticed only when the buffer is flushed.
  if (std::fclose(file) != 0 || !written)
    throw FileError(path, "could not be written in full: " + (written ? last_system_message() : problem));
}
} // namespace

void write_text_file(const std::string& path, const std::string& text) { write_in_mode(path, text, "wb"); }

void append_text(const std::string& path, const std::string& text) { write_in_mode(path, text, "ab"); }

void replace_text_file(const std::string& path, const std::string& text)
{
  const std::string draft = path + ".new";
  write_text_file(draft, text);
  if (std::rename(draft.c_str(), path.c_str()) != 0)
  {
    const std::string problem = last_system_message();
    std::remove(draft.c_str());
    throw FileError(path, "cannot be replaced: " + problem);
  }
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
