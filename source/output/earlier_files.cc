#include <filesystem>
#include <kedge/base/exceptions.h>
#include <kedge/output/earlier_files.h>
#include <kedge/output/vtu.h>
#include <regex>
#include <vector>

namespace kedge
{
namespace
{
namespace fs = std::filesystem;

/// Name, step and perhaps rank, as OutputWriter joins them.
const std::string series = "(mps_[0-9]+|mesh|body|surface|tracked)";
const std::regex vtk_moment(series + "_([0-9]{5,10})(_[0-9]+)?\\.p?vtu"), vtk_list(series + "\\.pvd"),
    csv_moment("(mps_[0-9]+)_([0-9]{5,10})\\.csv"), csv_list("rigid_body(-[0-9]+)?\\.csv"),
    draft(".*\\.(csv|p?vtu|pvd)\\.new"); // of a run that was killed

/// Taken before any of them is removed.
std::vector<fs::path> files_in(const std::string& folder)
{
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (std::error_code ignored; entry->is_regular_file(ignored))
      files.push_back(entry->path());
  return files;
}

void remove_in(const std::string& folder, const unsigned int step, const std::regex& moment, const std::regex& list)
{
  for (const fs::path& file : files_in(folder))
  {
    const std::string name = file.filename().string();
    std::smatch found;
    if (std::regex_match(name, found, moment)
            ? std::stoull(found[2]) > step
            : std::regex_match(name, draft) || (step == 0 && std::regex_match(name, list)))
      remove_earlier_file(file.string());
  }
}
} // namespace

void remove_earlier_file(const std::string& path)
{
  std::error_code error;
  fs::remove(path, error);
  if (error)
    throw FileError(path, "of an earlier run cannot be removed: " + error.message());
}

void remove_moments_after(const unsigned int step, const std::string& vtk_folder, const std::string& csv_folder)
{
  remove_in(csv_folder, step, csv_moment, csv_list);
  remove_in(vtk_folder, step, vtk_moment, vtk_list);
  for (const fs::path& file : files_in(vtk_folder))
    if (std::regex_match(file.filename().string(), vtk_list))
    {
      PvdSeries list(file.string());
      list.resume_after(step);
      list.write();
    }
}
} // namespace kedge
