// The background mesh: a p4est brick of base cells, refined 2:1.
#pragma once

#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/mapping_cartesian.h>
#include <kedge/mesh/grid_layout.h>
#include <kedge/mesh/leaf_table.h>

namespace kedge
{
template <int dim> std::array<double, dim> to_array(const dealii::Point<dim>& point)
{
  std::array<double, dim> x;
  for (unsigned int d = 0; d < dim; ++d)
    x[d] = point[d];
  return x;
}

/// Of a cell of a distributed triangulation.
ForestPlace place_in_forest(const dealii::CellId& id);

template <int dim> class BackgroundMesh
{
public:
  using Cell = typename dealii::Triangulation<dim>::active_cell_iterator;

  BackgroundMesh(MPI_Comm communicator, const GridLayout<dim>& layout);

  MPI_Comm communicator() const { return ranks; }
  const GridLayout<dim>& layout() const { return grid; }
  dealii::parallel::distributed::Triangulation<dim>& triangulation() { return forest; }
  const dealii::parallel::distributed::Triangulation<dim>& triangulation() const { return forest; }
  const dealii::Mapping<dim>& mapping() const { return cartesian; }

  /// Distributes the cells over the ranks again. All ranks get the same share of `work` (by active cell index; an empty
  /// cell has 1), or of the cells if it is empty. The children of a cell come to one rank. Pack the particles first
  /// (ParticleSet does so).
  void repartition(const std::vector<double>& work = {});

  /// Sets the part of the grid in which soil is active; at first it is the whole grid. The leaves keep their numbers.
  void set_window(const Window<dim>& window);
  /// Whether an owned or ghost cell lies in the window.
  bool in_window(const Cell& cell) const { return table.in_window(table.leaves[leaf_number(cell)]); }

  /// Numbers the nodes and rebuilds the leaf table. Call it after every change of the forest. Collective.
  void update();

  /// The table of the last update().
  const LeafTable<dim>& leaves() const { return table; }
  /// Grows with every change of cells or window, so that owners of data by cell notice the change.
  unsigned long version() const { return n_changes; }
  /// Number of the leaf of an owned or ghost cell in leaves().
  unsigned int leaf_number(const Cell& cell) const { return leaf_of_cell[cell->active_cell_index()]; }

private:
  MPI_Comm ranks;
  GridLayout<dim> grid;
  dealii::parallel::distributed::Triangulation<dim> forest;
  dealii::DoFHandler<dim> nodes;
  dealii::MappingCartesian<dim> cartesian;
  LeafTable<dim> table;
  std::vector<unsigned int> leaf_of_cell;
  unsigned long n_changes = 0;
};
} // namespace kedge
