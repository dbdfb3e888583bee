#include <gtest/gtest.h>
#include <kedge/mesh/grid_layout.h>

using namespace kedge;

TEST(RoundDownToLevel, GoesDownToAPowerOfTwo)
{
  EXPECT_DOUBLE_EQ(round_down_to_level(4., 0.1), 3.2);
  EXPECT_DOUBLE_EQ(round_down_to_level(0.15, 0.1), 0.1);
}

TEST(RoundDownToLevel, KeepsWhatFitsDespiteDecimalRoundOff)
{
  EXPECT_DOUBLE_EQ(round_down_to_level(0.8, 0.1), 0.8);
  EXPECT_DOUBLE_EQ(round_down_to_level(0.3 * 8., 0.3), 2.4);
}

TEST(GridLayout, OneSizeIsExact)
{
  const GridLayout<3> grid = make_grid_layout<3>(0.7, {}, {{7., 2.1}}, 1.4, 2);
  EXPECT_EQ(grid.base_size, 0.7);
  EXPECT_EQ(grid.finest_size, 0.7);
  EXPECT_EQ(grid.base_cells, (std::array<unsigned int, 3>{{10, 3, 4}}));
}

TEST(GridLayout, TreesAreAsLargeAsTheNumbersOfBaseCellsAllow)
{
  GridLayout<2> grid;
  const auto base_level = [&](const unsigned int n, const unsigned int m)
  {
    grid.base_cells = {{n, m}};
    return grid.base_level();
  };
  EXPECT_EQ(base_level(7, 4), 0u);
  EXPECT_EQ(base_level(12, 4), 2u);
  EXPECT_EQ(base_level(2, 2), 1u);
  EXPECT_EQ(base_level(64, 128), 3u); // no more: find_leaf goes down from the tree
}

TEST(GridLayout, FootprintIsRoundedUpToWholeBaseCells)
{
  const GridLayout<3> grid = make_grid_layout<3>(4., {0.1, 0.4}, {{100., 10.}}, 18.123, 1);
  EXPECT_DOUBLE_EQ(grid.base_size, 3.2);
  EXPECT_DOUBLE_EQ(grid.finest_size, 0.1);
  EXPECT_NEAR(grid.soil_extent[0], 102.4, 1e-12);
  EXPECT_NEAR(grid.soil_extent[1], 12.8, 1e-12);
}

TEST(GridLayout, BlockIsRoundedUpToAWholeRowOfParticles)
{
  EXPECT_NEAR((make_grid_layout<3>(4., {0.1}, {{100., 10.}}, 18.123, 1).soil_extent[2]), 19.2, 1e-12);
  EXPECT_NEAR((make_grid_layout<3>(4., {0.1}, {{100., 10.}}, 18.123, 2).soil_extent[2]), 19.2, 1e-12);
  EXPECT_NEAR((make_grid_layout<3>(4., {0.1}, {{100., 10.}}, 17.123, 2).soil_extent[2]), 17.6, 1e-12);
}

TEST(GridLayout, IsTwiceAsHighAsTheSoil)
{
  const GridLayout<3> grid = make_grid_layout<3>(4., {0.1}, {{100., 10.}}, 18.123, 1);
  EXPECT_EQ(grid.base_cells[2], 12u);
  EXPECT_NEAR(grid.extent(2), 38.4, 1e-12);
}

TEST(GridLayout, MayReachBeyondTheSoil)
{
  const GridLayout<2> grid = make_grid_layout<2>(0.25, {}, {{1.}}, 1., 2, {{2.6, 1.1}});
  EXPECT_EQ(grid.base_cells, (std::array<unsigned int, 2>{{11, 5}}));
  EXPECT_DOUBLE_EQ(grid.soil_extent[0], 1.);
  EXPECT_DOUBLE_EQ(grid.soil_extent[1], 1.);
}

TEST(GridLayout, PlaneHasOneFootprintLength)
{
  const GridLayout<2> grid = make_grid_layout<2>(0.5, {0.25}, {{3.2}}, 1., 2);
  EXPECT_EQ(grid.base_cells, (std::array<unsigned int, 2>{{7, 4}}));
  EXPECT_DOUBLE_EQ(grid.soil_extent[1], 1.);
}
