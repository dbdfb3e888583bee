// Files that the input tests read, and a folder with surfaces for them to name.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace input_files
{
inline std::filesystem::path root() { return KEDGE_ROOT; }

inline std::string contents(const std::filesystem::path& file)
{
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// A folder with empty STL files, removed at the end; reading the input only asks that they exist.
struct Folder
{
  Folder()
  {
    std::string name = (std::filesystem::temp_directory_path() / "kedge-input-XXXXXX").string();
    path = mkdtemp(name.data()); // one of its own, as tests may run side by side
    for (const char* name : {"body.stl", "fluke_round_nose.stl", "shank_scv2.stl"})
      std::ofstream(path / name) << "solid\nendsolid\n";
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};
} // namespace input_files
