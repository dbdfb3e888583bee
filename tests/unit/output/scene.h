// A small scene to write: a grid of 2 cells per axis with one particle each, and one body.
#pragma once

#include <kedge/mesh/background_mesh.h>
#include <kedge/output/snapshots.h>

namespace kedge::test
{
template <int dim> struct Scene
{
  Scene() : mesh(MPI_COMM_WORLD, layout()), particles(mesh)
  {
    std::vector<double> data(field::count, 0.);
    for (const auto& cell : mesh.triangulation().active_cell_iterators())
    {
      // the upper cells stay empty except for one
      const dealii::Point<dim> x = cell->center();
      if (!cell->is_locally_owned() || (x[dim - 1] > 1. && x[0] > 1.))
        continue;
      std::fill(data.begin(), data.end(), 0.);
      long long id = 0;
      for (unsigned int d = 0; d < dim; ++d)
      {
        data[field::initial_position + d] = x[d];
        data[field::half_width + d] = 0.5 - 0.1 * d;
        id = 2 * id + (x[d] > 1.);
      }
      for (unsigned int d = 0; d < 3; ++d)
        data[field::deformation_gradient + 4 * d] = 1.;
      data[field::initial_volume] = 10. + id;
      data[field::layer] = x[dim - 1] > 1. ? 0. : 1.;
      particles.edit().insert_particle(x, mesh.mapping().transform_real_to_unit_cell(cell, x), id, cell,
                                       dealii::ArrayView<const double>(data.data(), data.size()));
    }
    particles.edit().update_cached_numbers();
  }

  static GridLayout<dim> layout()
  {
    GridLayout<dim> grid;
    grid.base_size = grid.finest_size = 1.;
    grid.base_cells.fill(2);
    grid.soil_extent.fill(2.);
    return grid;
  }

  Snapshot<dim> state(unsigned int step) const
  {
    return {particles, mesh, bodies, reactions, touches, 1, step, 0.5, 10.5};
  }

  BackgroundMesh<dim> mesh;
  ParticleSet<dim> particles;
  RigidSystems bodies;
  std::vector<Vector6> reactions;
  std::vector<typename Contact<dim>::Touch> touches;
};

/// The cube [-1, 1]^3, outwards.
inline TriangleMesh cube()
{
  TriangleMesh mesh;
  for (unsigned int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

inline OutputParameters everything()
{
  OutputParameters parameters;
  parameters.vtk = {true, "vtk", 0., particle_field_names(), body_field_names()};
  parameters.csv = {true, "csv/deep", 0., particle_field_names(), body_field_names()};
  return parameters;
}
} // namespace kedge::test
