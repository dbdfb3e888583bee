// VTK's XML files: one grid (.vtu), a grid in pieces (.pvtu), a series in time (.pvd).
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace kedge
{
/// Cell shapes by VTK's numbers.
enum class CellShape : std::uint8_t
{
  vertex = 1,
  line = 3,
  triangle = 5,
  quad = 9,
  hexahedron = 12
};

/// Named values on the points or the cells of a grid. The components of an entry are adjacent.
struct DataArray
{
  std::string name;
  unsigned int n_components = 1;
  std::variant<std::vector<float>, std::vector<std::int32_t>> values;
  std::vector<std::string> component_names = {}; ///< may be empty
};

/// A grid whose cells all have the same shape.
struct UnstructuredGrid
{
  CellShape shape = CellShape::vertex;
  std::vector<double> points;             ///< x, y, z of each, m
  std::vector<std::int32_t> connectivity; ///< points of each cell in VTK's order
  std::vector<DataArray> point_data, cell_data;

  std::size_t n_points() const { return points.size() / 3; }
  std::size_t n_cells() const;
};

/// Writes a compressed grid with `time` (s) as its "TimeValue". Throws FileError.
void write_vtu(const UnstructuredGrid& grid, const std::string& path, double time);

/// Writes the file that joins `pieces` (file names relative to it). `piece` is one of them; all have its arrays.
void write_pvtu(const UnstructuredGrid& piece, const std::vector<std::string>& pieces, const std::string& path);

/// The growing list of files and times of one series. The files' names end in _<step> before the extension.
class PvdSeries
{
public:
  explicit PvdSeries(std::string path);

  /// Keeps the entries of an earlier run up to and including `step`. A missing file counts as an empty list.
  void resume_after(unsigned int step);
  /// Appends a file (named relative to the list) and rewrites the list. Throws FileError; the next call writes what
  /// this one could not.
  void add(double time, const std::string& file);
  /// Writes the list as it is.
  void write();
  /// Whether all of the list is in its file.
  bool is_written() const { return written; }

private:
  std::string path;
  bool written = true;
  std::vector<std::pair<double, std::string>> entries;
};
} // namespace kedge
