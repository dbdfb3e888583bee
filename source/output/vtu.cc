#include <algorithm>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/text_file.h>
#include <kedge/output/vtu.h>
#include <type_traits>
#include <zlib.h>

namespace kedge
{
namespace
{
constexpr std::size_t block_size = std::size_t(1) << 18; // bytes compressed at a time

constexpr const char* byte_order = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? "LittleEndian" : "BigEndian";

unsigned int points_per_cell(CellShape shape)
{
  switch (shape)
  {
    case CellShape::line:
      return 2;
    case CellShape::triangle:
      return 3;
    case CellShape::quad:
      return 4;
    case CellShape::hexahedron:
      return 8;
    case CellShape::vertex:
      break;
  }
  return 1;
}

template <typename T> constexpr const char* type_name()
{
  if (std::is_same<T, double>::value)
    return "Float64";
  if (std::is_same<T, float>::value)
    return "Float32";
  return std::is_same<T, std::uint8_t>::value ? "UInt8" : "Int32";
}

/// The binary part at the end of a file. Each array is cut into blocks. A header precedes them: number of blocks, size
/// of a block, size of an incomplete last block (or 0), compressed sizes.
class AppendedData
{
public:
  /// Compresses an array; returns where it begins.
  template <typename T> std::size_t add(const std::vector<T>& values)
  {
    const std::size_t begin = text.size(), n_bytes = values.size() * sizeof(T);
    const std::size_t n_blocks = (n_bytes + block_size - 1) / block_size;
    std::vector<std::uint64_t> header(3 + n_blocks);
    header[0] = n_blocks;
    header[1] = block_size;
    header[2] = n_bytes % block_size;
    text.resize(begin + header.size() * sizeof(std::uint64_t));
    for (std::size_t block = 0; block < n_blocks; ++block)
    {
      const std::size_t first = block * block_size;
      header[3 + block] =
          compress(reinterpret_cast<const Bytef*>(values.data()) + first, std::min(block_size, n_bytes - first));
    }
    const char* bytes = reinterpret_cast<const char*>(header.data());
    std::copy(bytes, bytes + header.size() * sizeof(std::uint64_t), text.begin() + begin);
    return begin;
  }

  const std::string& bytes() const { return text; }

private:
  std::size_t compress(const Bytef* source, std::size_t n_bytes)
  {
    const std::size_t begin = text.size();
    uLongf n_compressed = compressBound(n_bytes);
    text.resize(begin + n_compressed);
    // Higher levels of compression take longer and save less than a tenth on such numbers.
    if (compress2(reinterpret_cast<Bytef*>(&text[begin]), &n_compressed, source, n_bytes, Z_BEST_SPEED) != Z_OK)
      throw std::bad_alloc();
    text.resize(begin + n_compressed);
    return n_compressed;
  }

  std::string text;
};

/// Attributes that the tag of an array has both in a grid and in a list of pieces.
std::string array_attributes(const DataArray& array)
{
  const char* type = std::holds_alternative<std::vector<float>>(array.values) ? "Float32" : "Int32";
  std::string text =
      fmt::format("type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"", type, array.name, array.n_components);
  for (std::size_t i = 0; i < array.component_names.size(); ++i)
    text += fmt::format(" ComponentName{}=\"{}\"", i, array.component_names[i]);
  return text;
}

template <typename T>
std::string appended_array(const char* name, unsigned int n_components, const std::vector<T>& values,
                           AppendedData& appended)
{
  return fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
                     "offset=\"{}\"/>\n",
                     type_name<T>(), name, n_components, appended.add(values));
}

std::string appended_data(const char* tag, const std::vector<DataArray>& arrays, AppendedData& appended)
{
  std::string text = fmt::format("<{}>\n", tag);
  for (const DataArray& array : arrays)
  {
    const std::size_t offset = std::visit([&](const auto& values) { return appended.add(values); }, array.values);
    text += fmt::format("<DataArray {} format=\"appended\" offset=\"{}\"/>\n", array_attributes(array), offset);
  }
  return text + fmt::format("</{}>\n", tag);
}

std::string piecewise_data(const char* tag, const std::vector<DataArray>& arrays)
{
  std::string text = fmt::format("<{}>\n", tag);
  for (const DataArray& array : arrays)
    text += fmt::format("<PDataArray {}/>\n", array_attributes(array));
  return text + fmt::format("</{}>\n", tag);
}

std::string opening(const char* type)
{
  return fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"{}\" "
                     "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n",
                     type, byte_order);
}
} // namespace

std::size_t UnstructuredGrid::n_cells() const { return connectivity.size() / points_per_cell(shape); }

void write_vtu(const UnstructuredGrid& grid, const std::string& path, double time)
{
  std::vector<std::int32_t> offsets(grid.n_cells());
  for (std::size_t cell = 0; cell < offsets.size(); ++cell)
    offsets[cell] = static_cast<std::int32_t>((cell + 1) * points_per_cell(grid.shape));
  const std::vector<std::uint8_t> types(grid.n_cells(), static_cast<std::uint8_t>(grid.shape));

  AppendedData appended;
  std::string text = opening("UnstructuredGrid") + "<UnstructuredGrid>\n";
  text += fmt::format("<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
                      "format=\"ascii\">{}</DataArray></FieldData>\n",
                      time);
  text += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", grid.n_points(), grid.n_cells());
  text += "<Points>\n" + appended_array("Points", 3, grid.points, appended) + "</Points>\n<Cells>\n";
  text += appended_array("connectivity", 1, grid.connectivity, appended);
  text += appended_array("offsets", 1, offsets, appended);
  text += appended_array("types", 1, types, appended) + "</Cells>\n";
  text += appended_data("PointData", grid.point_data, appended) + appended_data("CellData", grid.cell_data, appended);
  text += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  text += appended.bytes();
  text += "\n</AppendedData>\n</VTKFile>\n";
  replace_text_file(path, text);
}

void write_pvtu(const UnstructuredGrid& piece, const std::vector<std::string>& pieces, const std::string& path)
{
  std::string text = opening("PUnstructuredGrid") + "<PUnstructuredGrid GhostLevel=\"0\">\n";
  text += "<PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n</PPoints>\n";
  text += piecewise_data("PPointData", piece.point_data) + piecewise_data("PCellData", piece.cell_data);
  for (const std::string& file : pieces)
    text += fmt::format("<Piece Source=\"{}\"/>\n", file);
  replace_text_file(path, text + "</PUnstructuredGrid>\n</VTKFile>\n");
}
} // namespace kedge
