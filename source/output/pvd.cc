#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/text_file.h>
#include <kedge/output/vtu.h>
#include <sstream>

namespace kedge
{
namespace
{
/// The value of an attribute in one line of XML; empty where it is missing.
std::string attribute(const std::string& line, const std::string& name)
{
  const std::string key = " " + name + "=\"";
  const std::size_t found = line.find(key);
  if (found == std::string::npos)
    return "";
  const std::size_t begin = found + key.size();
  return line.substr(begin, line.find('"', begin) - begin);
}
} // namespace

PvdSeries::PvdSeries(std::string path_) : path(std::move(path_)) {}

void PvdSeries::resume_after(unsigned int step)
{
  entries.clear();
  if (!std::filesystem::exists(path))
    return;
  std::istringstream lines(read_text_file(path));
  for (std::string line; std::getline(lines, line);)
  {
    if (line.find("<DataSet ") == std::string::npos)
      continue;
    const std::string file = attribute(line, "file"), time = attribute(line, "timestep");
    try
    {
      if (std::stoul(file.substr(file.rfind('_') + 1)) <= step)
        entries.emplace_back(std::stod(time), file);
    }
    catch (const std::logic_error&) // what stoul and stod throw
    {
      throw FileError(path, "cannot be continued: \"" + line + "\" has no time or no step number");
    }
  }
}

void PvdSeries::add(double time, const std::string& file)
{
  entries.emplace_back(time, file);
  write();
}

void PvdSeries::write()
{
  written = false;
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const auto& [at, name] : entries)
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", at, name);
  replace_text_file(path, text + "</Collection>\n</VTKFile>\n");
  written = true;
}
} // namespace kedge
