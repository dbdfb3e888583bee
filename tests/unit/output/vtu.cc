#include "read_back.h"

#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/vtu.h>

namespace kedge
{
namespace
{
using test::own;
using test::ReadGrid;
using test::TemporaryFolder;
using Numbers = std::vector<double>;

UnstructuredGrid two_triangles()
{
  UnstructuredGrid grid;
  grid.shape = CellShape::triangle;
  grid.points = {0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.1};
  grid.connectivity = {0, 1, 2, 1, 3, 2};
  grid.point_data.push_back(
      {"velocity", 3, std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, {"x", "y", "z"}});
  grid.cell_data.push_back({"body", 1, std::vector<std::int32_t>{7, -8}});
  return grid;
}

TEST(Vtu, GridReadsBack)
{
  const TemporaryFolder folder;
  write_vtu(two_triangles(), folder / own("a.vtu"), 0.1);
  const ReadGrid grid = test::read_vtu(folder / own("a.vtu"));

  EXPECT_EQ(grid.time, 0.1);
  EXPECT_EQ(grid.n_points, 4u);
  EXPECT_EQ(grid.n_cells, 2u);
  EXPECT_EQ(grid.arrays.at("Points/Points").type, "Float64");
  EXPECT_EQ(grid.arrays.at("Points/Points").values, two_triangles().points);
  EXPECT_EQ(grid.arrays.at("Cells/connectivity").values, Numbers({0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(grid.arrays.at("Cells/offsets").values, Numbers({3, 6}));
  EXPECT_EQ(grid.arrays.at("Cells/types").type, "UInt8");
  EXPECT_EQ(grid.arrays.at("Cells/types").values, Numbers({5, 5}));
}

TEST(Vtu, DataKeepTypeComponentsAndNames)
{
  const TemporaryFolder folder;
  write_vtu(two_triangles(), folder / own("a.vtu"), 0.);
  const ReadGrid grid = test::read_vtu(folder / own("a.vtu"));

  const test::ReadArray& velocity = grid.arrays.at("PointData/velocity");
  EXPECT_EQ(velocity.type, "Float32");
  EXPECT_EQ(velocity.n_components, 3u);
  EXPECT_EQ(velocity.component_names, std::vector<std::string>({"x", "y", "z"}));
  EXPECT_EQ(velocity.values, Numbers({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(grid.arrays.at("CellData/body").type, "Int32");
  EXPECT_EQ(grid.arrays.at("CellData/body").values, Numbers({7, -8}));
}

TEST(Vtu, ArraysOfSeveralBlocksReadBack)
{
  const TemporaryFolder folder;
  // with a full last block and with an incomplete one
  for (const std::size_t n : {3u << 15, 100001u * 3})
  {
    UnstructuredGrid grid;
    for (std::size_t i = 0; i < n; ++i)
      grid.points.push_back(1. / (1. + double(i)));
    write_vtu(grid, folder / own("a.vtu"), 0.);
    EXPECT_EQ(test::read_vtu(folder / own("a.vtu")).arrays.at("Points/Points").values, grid.points);
  }
}

TEST(Vtu, EmptyGridReadsBack)
{
  const TemporaryFolder folder;
  UnstructuredGrid empty;
  empty.cell_data.push_back({"stress", 6, std::vector<float>()});
  write_vtu(empty, folder / own("a.vtu"), 0.);
  const ReadGrid grid = test::read_vtu(folder / own("a.vtu"));
  EXPECT_EQ(grid.n_points, 0u);
  EXPECT_EQ(grid.n_cells, 0u);
  EXPECT_TRUE(grid.arrays.at("CellData/stress").values.empty());
}

TEST(Vtu, UnwritableFileIsNamed)
{
  try
  {
    write_vtu(two_triangles(), "/no such folder/a.vtu", 0.);
    FAIL() << "no error";
  }
  catch (const FileError& error)
  {
    EXPECT_EQ(error.path, "/no such folder/a.vtu");
    EXPECT_NE(std::string(error.what()).find("No such file or directory"), std::string::npos) << error.what();
  }
}

TEST(Vtu, FullDiskIsAnError)
{
  if (!std::filesystem::exists("/dev/full"))
    GTEST_SKIP() << "needs /dev/full";
  EXPECT_THROW(write_text_file("/dev/full", "text"), FileError);
}

TEST(Pvtu, NamesPiecesAndArrays)
{
  const TemporaryFolder folder;
  write_pvtu(two_triangles(), {"a_0.vtu", "a_1.vtu"}, folder / own("a.pvtu"));
  std::vector<std::string> pieces, arrays;
  for (const test::Tag& tag : test::read_tags(read_text_file(folder / own("a.pvtu"))))
  {
    if (tag.name == "Piece")
      pieces.push_back(tag.attributes.at("Source"));
    if (tag.name == "PDataArray")
      arrays.push_back(tag.attributes.at("Name") + " " + tag.attributes.at("type"));
  }
  EXPECT_EQ(pieces, std::vector<std::string>({"a_0.vtu", "a_1.vtu"}));
  EXPECT_EQ(arrays, std::vector<std::string>({"Points Float64", "velocity Float32", "body Int32"}));
}

std::vector<std::string> listed(const std::string& path)
{
  std::vector<std::string> entries;
  for (const test::Tag& tag : test::read_tags(read_text_file(path)))
    if (tag.name == "DataSet")
      entries.push_back(tag.attributes.at("timestep") + " " + tag.attributes.at("file"));
  return entries;
}

TEST(Pvd, ListsFilesWithTimes)
{
  const TemporaryFolder folder;
  PvdSeries series(folder / own("mesh.pvd"));
  series.add(0.1, "mesh_00002.vtu");
  EXPECT_EQ(listed(folder / own("mesh.pvd")), std::vector<std::string>({"0.1 mesh_00002.vtu"}));
  series.add(0.3, "mesh_00003.vtu");
  EXPECT_EQ(listed(folder / own("mesh.pvd")), std::vector<std::string>({"0.1 mesh_00002.vtu", "0.3 mesh_00003.vtu"}));
}

TEST(Pvd, LeavesNoDraftBehind)
{
  const TemporaryFolder folder;
  PvdSeries(folder / own("mesh.pvd")).add(0.1, "mesh_00002.vtu");
  EXPECT_TRUE(std::filesystem::exists(folder / own("mesh.pvd")));
  EXPECT_FALSE(std::filesystem::exists(folder / own("mesh.pvd.new")));
}

TEST(Pvd, RestartDropsWhatCameLater)
{
  const TemporaryFolder folder;
  PvdSeries first(folder / own("mps_1.pvd"));
  first.add(0.1, "mps_1_00002.vtu");
  first.add(0.2, "mps_1_00003.vtu");
  first.add(0.3, "mps_1_00004.vtu");

  PvdSeries second(folder / own("mps_1.pvd"));
  second.resume_after(3);
  second.add(0.25, "mps_1_00004.pvtu");
  EXPECT_EQ(listed(folder / own("mps_1.pvd")),
            std::vector<std::string>({"0.1 mps_1_00002.vtu", "0.2 mps_1_00003.vtu", "0.25 mps_1_00004.pvtu"}));
}

TEST(Pvd, RestartWithoutListStartsOne)
{
  const TemporaryFolder folder;
  PvdSeries series(folder / own("mesh.pvd"));
  series.resume_after(10);
  series.add(1., "mesh_00011.vtu");
  EXPECT_EQ(listed(folder / own("mesh.pvd")).size(), 1u);
}

TEST(Pvd, RestartOnForeignListIsRefused)
{
  const TemporaryFolder folder;
  write_text_file(folder / own("mesh.pvd"), "<DataSet timestep=\"0\" file=\"other.vtu\"/>\n");
  EXPECT_THROW(PvdSeries(folder / own("mesh.pvd")).resume_after(10), FileError);
}
} // namespace
} // namespace kedge
