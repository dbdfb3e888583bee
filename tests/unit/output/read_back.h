// Reads the files of this room back. It follows the definition of VTK's file format, not the code that writes.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <kedge/base/communication.h>
#include <kedge/output/text_file.h>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>
#include <zlib.h>

namespace kedge::test
{
/// A folder that all ranks know. It is removed with the object.
class TemporaryFolder
{
public:
  TemporaryFolder()
  {
    static int count = 0;
    int process = getpid();
    MPI_Bcast(&process, 1, MPI_INT, 0, MPI_COMM_WORLD);
    path = std::filesystem::temp_directory_path() /
           ("kedge-output-" + std::to_string(process) + "-" + std::to_string(count++));
    std::filesystem::create_directories(path);
    MPI_Barrier(MPI_COMM_WORLD);
  }
  ~TemporaryFolder()
  {
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank_of(MPI_COMM_WORLD) == 0)
      std::filesystem::remove_all(path);
  }
  std::string operator/(const std::string& name) const { return (path / name).string(); }
  std::string name() const { return path.string(); }

private:
  std::filesystem::path path;
};

/// Every rank writes its own file, so that the tests mean the same on any number of them.
inline std::string own(const std::string& name) { return std::to_string(rank_of(MPI_COMM_WORLD)) + name; }

/// Names of the files in a folder, once all ranks have come so far.
inline std::set<std::string> files_in(const std::string& folder)
{
  MPI_Barrier(MPI_COMM_WORLD);
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}

struct Tag
{
  std::string name;
  std::map<std::string, std::string> attributes;
};

struct ReadArray
{
  std::string type;
  unsigned int n_components = 0;
  std::vector<std::string> component_names;
  std::vector<double> values;
};

struct ReadGrid
{
  std::size_t n_points = 0, n_cells = 0;
  double time = 0.;
  std::map<std::string, ReadArray> arrays; ///< "Points/Points", "Cells/types", "CellData/stress", ...
};

/// Splits XML into its opening tags; throws where tags do not match.
inline std::vector<Tag> read_tags(const std::string& xml)
{
  std::vector<Tag> tags;
  std::vector<std::string> open;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1))
  {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos)
      throw std::runtime_error("a tag without an end");
    std::string body = xml.substr(at + 1, end - at - 1);
    if (body[0] == '?')
      continue;
    if (body[0] == '/')
    {
      if (open.empty() || open.back() != body.substr(1))
        throw std::runtime_error("unexpected </" + body.substr(1) + ">");
      open.pop_back();
      tags.push_back({body, {}});
      continue;
    }
    const bool is_closed = body.back() == '/';
    if (is_closed)
      body.pop_back();
    Tag tag;
    tag.name = body.substr(0, body.find(' '));
    for (std::size_t equal = body.find("=\""); equal != std::string::npos; equal = body.find("=\"", equal + 1))
    {
      const std::size_t begin = body.rfind(' ', equal) + 1, quote = body.find('"', equal + 2);
      tag.attributes[body.substr(begin, equal - begin)] = body.substr(equal + 2, quote - equal - 2);
    }
    if (!is_closed)
      open.push_back(tag.name);
    tags.push_back(tag);
  }
  if (!open.empty())
    throw std::runtime_error("<" + open.back() + "> is not closed");
  return tags;
}

inline std::string decompress(const std::string& data, std::size_t at)
{
  const auto number = [&](std::size_t i)
  {
    std::uint64_t value;
    std::memcpy(&value, data.data() + at + 8 * i, 8);
    return value;
  };
  const std::uint64_t n_blocks = number(0), block_size = number(1), last_size = number(2);
  std::size_t source = at + 8 * (3 + n_blocks);
  std::string bytes;
  for (std::uint64_t block = 0; block < n_blocks; ++block)
  {
    const std::size_t size = block + 1 == n_blocks && last_size > 0 ? last_size : block_size;
    std::string part(size, '\0');
    uLongf n_out = size;
    if (uncompress(reinterpret_cast<Bytef*>(part.data()), &n_out, reinterpret_cast<const Bytef*>(data.data() + source),
                   number(3 + block)) != Z_OK ||
        n_out != size)
      throw std::runtime_error("a block does not decompress");
    source += number(3 + block);
    bytes += part;
  }
  return bytes;
}

template <typename T> std::vector<double> as_numbers(const std::string& bytes)
{
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!bytes.empty())
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return std::vector<double>(values.begin(), values.end());
}

inline ReadGrid read_vtu(const std::string& path)
{
  const std::string text = read_text_file(path), marker = "<AppendedData encoding=\"raw\">";
  const std::size_t split = text.find(marker);
  const std::string data = text.substr(text.find('_', split) + 1);
  const std::string tail = "\n</AppendedData>\n</VTKFile>\n";
  if (text.substr(text.size() - tail.size()) != tail)
    throw std::runtime_error(path + " has no proper end");

  ReadGrid grid;
  std::string section;
  const std::string time_tag = "format=\"ascii\">";
  grid.time = std::stod(text.substr(text.find(time_tag) + time_tag.size()));
  for (const Tag& tag : read_tags(text.substr(0, split) + marker + tail))
  {
    if (tag.name == "Points" || tag.name == "Cells" || tag.name == "PointData" || tag.name == "CellData")
      section = tag.name;
    if (tag.name == "Piece")
    {
      grid.n_points = std::stoul(tag.attributes.at("NumberOfPoints"));
      grid.n_cells = std::stoul(tag.attributes.at("NumberOfCells"));
    }
    if (tag.name != "DataArray" || section.empty())
      continue;
    ReadArray array;
    array.type = tag.attributes.at("type");
    array.n_components = std::stoul(tag.attributes.at("NumberOfComponents"));
    for (unsigned int c = 0; tag.attributes.count("ComponentName" + std::to_string(c)); ++c)
      array.component_names.push_back(tag.attributes.at("ComponentName" + std::to_string(c)));
    const std::string bytes = decompress(data, std::stoul(tag.attributes.at("offset")));
    array.values = array.type == "Float64"   ? as_numbers<double>(bytes)
                   : array.type == "Float32" ? as_numbers<float>(bytes)
                   : array.type == "Int32"   ? as_numbers<std::int32_t>(bytes)
                                             : as_numbers<std::uint8_t>(bytes);
    grid.arrays[section + "/" + tag.attributes.at("Name")] = array;
  }
  return grid;
}
} // namespace kedge::test
