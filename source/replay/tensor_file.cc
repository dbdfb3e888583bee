#include <array>
#include <cstdint>
#include <filesystem>
#include <kedge/base/exceptions.h>
#include <kedge/replay/tensor_file.h>

namespace kedge
{
namespace
{
/// Headers are padded to a multiple of this, so that numbers are aligned where the file is mapped to memory.
constexpr std::size_t alignment = 8;
constexpr std::size_t largest_header = 100000000; // as the format allows
} // namespace

void TensorWriter::array(const char* name, const char* type, const std::vector<std::size_t>& shape,
                         const std::size_t bytes, const void* data)
{
  if (!header_is_written)
    header[name] = {{"dtype", type}, {"shape", shape}, {"data_offsets", {length, length + bytes}}};
  else if (bytes > 0)
    file.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  length += bytes;
}

void TensorWriter::begin_numbers()
{
  std::string text = header.dump();
  text.resize((text.size() + alignment - 1) / alignment * alignment, ' ');
  const std::uint64_t size = text.size();
  std::error_code unknown;
  const bool is_device = std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown);
  if (!is_device)
    path =
        std::filesystem::weakly_canonical(path, unknown).string(); // a draft replaces what a link names, not the link
  draft = path + (is_device ? "" : ".new");                        // and no device
  file.open(draft, std::ios::binary);
  file.write(reinterpret_cast<const char*>(&size), sizeof(size));
  file.write(text.data(), static_cast<std::streamsize>(size));
  header_is_written = true;
}

void TensorWriter::close()
{
  file.close();
  std::error_code problem, ignored;
  if (file && draft != path)
    std::filesystem::rename(draft, path, problem);
  if (file && !problem)
    return;
  if (draft != path)
    std::filesystem::remove(draft, ignored);
  throw FileError(path, "cannot be written; see whether the folder exists and the disk is full");
}

TensorReader::TensorReader(const std::string& path_) : path(path_), file(path_, std::ios::binary)
{
  std::uint64_t size = 0;
  file.read(reinterpret_cast<char*>(&size), sizeof(size));
  if (!file)
    throw FileError(path, "cannot be read");
  if (size <= largest_header)
  {
    std::string text(size, ' ');
    file.read(text.data(), static_cast<std::streamsize>(size));
    header = nlohmann::json::parse(text, nullptr, false);
  }
  begin = sizeof(size) + size;
  if (!file || !header.is_object())
    throw FileError(path, "is not a file of arrays (safetensors)");
}

std::size_t TensorReader::bytes_of(const char* name, const char* type, const std::size_t row) const
{
  const auto entry = header.find(name);
  if (entry == header.end())
    throw FileError(path, std::string("has no array \"") + name + "\"");
  std::array<std::size_t, 2> offsets{{1, 0}};
  try
  {
    if (entry->at("dtype") == type)
      offsets = entry->at("data_offsets").get<std::array<std::size_t, 2>>();
  }
  catch (const nlohmann::json::exception&) // stays as it is
  {
  }
  const bool is_sound = offsets[0] <= offsets[1] && (offsets[1] - offsets[0]) % row == 0 &&
                        begin + offsets[1] <= std::filesystem::file_size(path);
  if (!is_sound)
    throw FileError(path, std::string("the array \"") + name + "\" is damaged or of another version");
  return offsets[1] - offsets[0];
}

void TensorReader::read(const char* name, void* data)
{
  const auto offsets = header.at(name).at("data_offsets").get<std::array<std::size_t, 2>>();
  file.seekg(static_cast<std::streamoff>(begin + offsets[0]));
  file.read(static_cast<char*>(data), static_cast<std::streamsize>(offsets[1] - offsets[0]));
  if (!file)
    throw FileError(path, std::string("the array \"") + name + "\" cannot be read");
}
} // namespace kedge
