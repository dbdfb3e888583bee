#include "gather.h"

#include <kedge/output/grids.h>

namespace kedge
{
namespace
{
/// Adds a box and its corners in VTK's order: around the lower face, then around the upper one.
template <int dim>
void add_box(const std::array<double, dim>& lower, const std::array<double, dim>& upper, UnstructuredGrid& grid)
{
  constexpr unsigned int n_corners = 1u << dim;
  constexpr bool at_upper_x[4] = {false, true, true, false}, at_upper_y[4] = {false, false, true, true};
  const auto first = static_cast<std::int32_t>(grid.n_points());
  for (unsigned int corner = 0; corner < n_corners; ++corner)
  {
    grid.points.push_back(at_upper_x[corner % 4] ? upper[0] : lower[0]);
    if (dim == 3)
    {
      grid.points.push_back(at_upper_y[corner % 4] ? upper[1] : lower[1]);
      grid.points.push_back(corner >= 4 ? upper[dim - 1] : lower[dim - 1]);
    }
    else
    {
      grid.points.push_back(0.);
      grid.points.push_back(at_upper_y[corner] ? upper[1] : lower[1]);
    }
    grid.connectivity.push_back(first + corner);
  }
}

template <int dim> constexpr CellShape box_shape = dim == 3 ? CellShape::hexahedron : CellShape::quad;

/// The array of one field. `evaluate(i, value)` writes the components of entry i.
template <typename Field, typename Evaluate>
DataArray evaluate_field(const Field& field, std::size_t n, const Evaluate& evaluate)
{
  std::vector<float> values(n * field.n_components);
  double value[9];
  for (std::size_t i = 0; i < n; ++i)
  {
    evaluate(i, value);
    for (unsigned int c = 0; c < field.n_components; ++c)
      values[i * field.n_components + c] = static_cast<float>(value[c]);
  }
  return {field.name, field.n_components, std::move(values), component_names(field.n_components)};
}

void add_vertex(const Eigen::Vector3d& x, UnstructuredGrid& grid)
{
  grid.connectivity.push_back(static_cast<std::int32_t>(grid.n_points()));
  grid.points.insert(grid.points.end(), x.data(), x.data() + 3);
}
} // namespace

template <int dim>
UnstructuredGrid particle_boxes(const std::vector<ParticleView>& particles, const std::vector<ParticleField>& fields)
{
  UnstructuredGrid grid;
  grid.shape = box_shape<dim>;
  grid.points.reserve(3 * (1u << dim) * particles.size());
  grid.connectivity.reserve((1u << dim) * particles.size());
  for (const ParticleView& particle : particles)
  {
    std::array<double, dim> lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
    {
      const double half_width = particle.data[field::half_width + d];
      lower[d] = particle.position[d] - half_width;
      upper[d] = particle.position[d] + half_width;
    }
    add_box<dim>(lower, upper, grid);
  }
  for (const ParticleField& field : fields)
    grid.cell_data.push_back(evaluate_field(
        field, particles.size(), [&](std::size_t i, double* value) { field.evaluate(particles[i], value); }));
  return grid;
}

template <int dim> UnstructuredGrid soil_cells(const BackgroundMesh<dim>& mesh, const ParticleSet<dim>& particles)
{
  UnstructuredGrid grid;
  grid.shape = box_shape<dim>;
  std::vector<std::int32_t> levels, active;
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
    if (cell->is_locally_owned() && particles.handler().n_particles_in_cell(cell) > 0)
    {
      std::array<double, dim> lower, upper;
      for (unsigned int d = 0; d < dim; ++d)
      {
        lower[d] = cell->vertex(0)[d];
        upper[d] = cell->vertex((1u << dim) - 1)[d];
      }
      add_box<dim>(lower, upper, grid);
      levels.push_back(cell->level() - static_cast<int>(mesh.layout().base_level()));
      active.push_back(mesh.in_window(cell));
    }
  grid.cell_data.push_back({"level", 1, std::move(levels)});
  grid.cell_data.push_back({"active", 1, std::move(active)});
  return grid;
}

UnstructuredGrid rigid_points(const RigidSystems& bodies, const std::vector<Vector6>& reactions,
                              const std::vector<BodyField>& fields)
{
  UnstructuredGrid grid;
  for (const RigidPoint& point : bodies.points)
    add_vertex(point.pose.position, grid);
  for (const BodyField& field : fields)
    grid.point_data.push_back(evaluate_field(field, bodies.points.size(),
                                             [&](std::size_t i, double* value)
                                             { field.evaluate(bodies.points[i], reaction_on(reactions, i), value); }));
  return grid;
}

UnstructuredGrid tracked_nodes(const RigidSystems& bodies)
{
  UnstructuredGrid grid;
  std::vector<std::int32_t> number, body;
  std::vector<float> velocity;
  for (const TrackedNode& node : bodies.tracked)
  {
    const RigidPoint& point = bodies.points[node.point];
    add_vertex(point.pose.to_world(node.position), grid);
    number.push_back(static_cast<std::int32_t>(number.size() + 1));
    body.push_back(static_cast<std::int32_t>(node.point + 1));
    for (const double component : velocity_at(point, node.position))
      velocity.push_back(static_cast<float>(component));
  }
  grid.point_data.push_back({"track", 1, std::move(number)});
  grid.point_data.push_back({"body", 1, std::move(body)});
  grid.point_data.push_back({"velocity", 3, std::move(velocity), component_names(3)});
  return grid;
}

UnstructuredGrid gather_grid(UnstructuredGrid mine, const MPI_Comm communicator)
{
  const long long first = sum_over_lower_ranks(static_cast<long long>(mine.n_points()), communicator);
  for (std::int32_t& point : mine.connectivity)
    point += static_cast<std::int32_t>(first);
  const auto gather_data = [communicator](std::vector<DataArray>& arrays)
  {
    for (DataArray& array : arrays)
      std::visit([&](auto& values) { values = gather_rows_on_root(values, array.n_components, communicator); },
                 array.values);
  };
  mine.points = gather_rows_on_root(mine.points, 3, communicator);
  mine.connectivity = gather_rows_on_root(mine.connectivity, 1, communicator);
  gather_data(mine.point_data);
  gather_data(mine.cell_data);
  return mine;
}

template UnstructuredGrid particle_boxes<2>(const std::vector<ParticleView>&, const std::vector<ParticleField>&);
template UnstructuredGrid particle_boxes<3>(const std::vector<ParticleView>&, const std::vector<ParticleField>&);
template UnstructuredGrid soil_cells<2>(const BackgroundMesh<2>&, const ParticleSet<2>&);
template UnstructuredGrid soil_cells<3>(const BackgroundMesh<3>&, const ParticleSet<3>&);
} // namespace kedge
