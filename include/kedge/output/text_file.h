// Reads and writes whole files at once. Errors name the file; what the disk does not take is a DiskError.
#pragma once

#include <string>

namespace kedge
{
/// What the system says of its last error (errno).
std::string last_system_message();

/// Writes `text` (any bytes) to `path`; replaces an existing file. Throws FileError.
void write_text_file(const std::string& path, const std::string& text);

/// Adds `text` to the end of the file, all of it or nothing. Throws FileError.
void append_text(const std::string& path, const std::string& text);

/// As write_text_file, but writes under a second name and renames the file, so a reader sees the old file or the new
/// one, never a part. What could not be written is removed.
void replace_text_file(const std::string& path, const std::string& text);

/// Writes over the file that is there and needs no room for it on the disk; blanks fill what is left of the old text.
/// Returns false and does nothing where `text` is longer than the file or there is none. Throws FileError.
bool write_in_place(const std::string& path, std::string text);

/// With those above it, where it is not there yet. Throws FileError.
void create_folder(const std::string& folder);

/// The second name, and how it becomes the name of the file. Throws FileError.
std::string draft_of(const std::string& path);
void give_name(const std::string& path);

/// Everything in the file. Throws FileError.
std::string read_text_file(const std::string& path);
} // namespace kedge
