// The grid of a block of 4 (by 3) by 2.75 m in cells of 0.5 m.
#pragma once

#include "../soil_fixture.h"

namespace kedge::test
{
template <int dim> GridLayout<dim> tall_block()
{
  std::array<unsigned int, dim> cells;
  cells.fill(6);
  cells[0] = 8;
  cells[dim - 1] = 8;
  GridLayout<dim> grid = make_brick<dim>(cells, 0.5);
  grid.soil_extent[dim - 1] = 2.75;
  return grid;
}
} // namespace kedge::test
