#include "matrices.h"
#include <algorithm>
#include <kedge/assembly/deformation.h>
#include <kedge/assembly/ghost.h>
#include <kedge/assembly/system.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/basis/gimp.h>

namespace kedge::translation
{
namespace
{
constexpr double poor_factor = 0.25;
constexpr unsigned int block_cells = 2;

template <int dim> struct Particles
{
  std::vector<std::array<double, dim>> centre, half_width;
  std::vector<unsigned int> leaf;
  double volume;
};

/// Leaf by leaf, as the stencils want them.
template <int dim> Particles<dim> make_particles(const LeafTable<dim>& table, const bool octree, const double offset)
{
  const unsigned int per_axis = block_cells * (octree ? 4 : 2);
  const double spacing = double(block_cells) / per_axis;
  std::vector<std::pair<unsigned int, std::array<double, dim>>> points;
  for (unsigned int n = 0; n < std::pow(per_axis, dim); ++n)
  {
    std::array<double, dim> x;
    for (unsigned int d = 0, digit = n; d < dim; ++d, digit /= per_axis)
      x[d] = 1. + offset + spacing * (digit % per_axis + 0.5);
    points.emplace_back(table.find_leaf(x), x);
  }
  std::sort(points.begin(), points.end());
  Particles<dim> particles;
  particles.volume = std::pow(spacing, dim);
  for (const auto& [leaf, x] : points)
  {
    particles.leaf.push_back(leaf);
    particles.centre.push_back(x);
    particles.half_width.emplace_back().fill(0.5 * spacing);
  }
  return particles;
}

/// Unstressed, undeformed.
ParticleArrays make_arrays(const std::size_t n, const double volume)
{
  ParticleArrays arrays;
  arrays.n = n;
  arrays.elastic_left_cauchy_green = View<double* [6]>("b", n);
  const auto b = make_mirror(arrays.elastic_left_cauchy_green);
  for (std::size_t p = 0; p < n; ++p)
    for (unsigned int i = 0; i < 3; ++i)
      b(p, i) = 1.;
  Kokkos::deep_copy(arrays.elastic_left_cauchy_green, b);
  arrays.young = upload(std::vector<double>(n, 1.), "young");
  arrays.initial_volume = arrays.mass = upload(std::vector<double>(n, volume), "volume and mass");
  arrays.layer = View<unsigned int*>("layer", n);
  arrays.trial_strain = View<double* [6]>("strain", n);
  arrays.trial_stress = View<double* [6]>("stress", n);
  arrays.trial_plastic = View<double*>("plastic", n);
  arrays.cell_size = View<double*>("cell size", n);
  arrays.trial_deformation = View<double* [9]>("dF", n);
  arrays.trial_frame = View<double* [12]>("frame", n);
  arrays.state = arrays.trial_state = StateView("state", n);
  return arrays;
}

Materials make_materials()
{
  MaterialParameters parameters;
  parameters.young = parameters.density = 1.;
  parameters.poisson = 0.;
  return upload_materials({parameters});
}

/// What `add` puts into the system's values.
template <typename Add> Eigen::MatrixXd assemble(System& system, const Add& add)
{
  system.clear_matrix();
  add(system.graph(), system.values());
  const NodeGraph& graph = system.graph();
  const unsigned int dim = graph.dim;
  const std::vector<std::size_t> begin = download(graph.row_begin);
  const std::vector<unsigned int> column = download(graph.column);
  const std::vector<double> values = download(system.values());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(dim * graph.n_rows, dim * graph.n_rows);
  for (unsigned int row = 0; row < graph.n_rows; ++row)
    for (std::size_t entry = begin[row]; entry < begin[row + 1]; ++entry)
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          dense(dim * row + i, dim * column[entry] + j) =
              values[dim * (dim * begin[row] + i * (begin[row + 1] - begin[row]) + entry - begin[row]) + j];
  return dense;
}

/// Sum over particles of m S_a S_b.
Eigen::MatrixXd consistent_mass(const StencilSet& stencils, const double mass, const unsigned int n_nodes)
{
  const std::vector<unsigned int> begin = download(stencils.pattern_node_begin),
                                  nodes = download(stencils.pattern_nodes),
                                  pattern = download(stencils.pattern_of_particle);
  const std::vector<std::size_t> value_begin = download(stencils.value_begin);
  const std::vector<double> value = download(stencils.value);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n_nodes, n_nodes);
  for (std::size_t p = 0; p < stencils.n_particles; ++p)
    for (unsigned int a = begin[pattern[p]], i = 0; a < begin[pattern[p] + 1]; ++a, ++i)
      for (unsigned int b = begin[pattern[p]], j = 0; b < begin[pattern[p] + 1]; ++b, ++j)
        matrix(nodes[a], nodes[b]) += mass * value[value_begin[p] + i] * value[value_begin[p] + j];
  return matrix;
}

/// The block of the first component.
Eigen::MatrixXd first_component(const Eigen::MatrixXd& matrix, const unsigned int dim)
{
  const auto every = Eigen::seqN(0, matrix.rows() / dim, dim);
  return matrix(every, every);
}
} // namespace

template <int dim> std::unique_ptr<BackgroundMesh<dim>> make_mesh(const bool octree)
{
  GridLayout<dim> layout;
  layout.base_size = 1.;
  layout.finest_size = octree ? 0.5 : 1.;
  layout.base_cells.fill(block_cells + 3);
  layout.soil_extent.fill(block_cells + 3.);
  auto mesh = std::make_unique<BackgroundMesh<dim>>(MPI_COMM_SELF, layout);
  for (const auto& cell : mesh->triangulation().active_cell_iterators())
    if (octree && cell->center()[0] > 2.)
      cell->set_refine_flag();
  mesh->triangulation().execute_coarsening_and_refinement();
  mesh->update();
  return mesh;
}

template <int dim>
Matrices make_matrices(const BackgroundMesh<dim>& mesh, const bool octree, const bool gimp, const Kind kind,
                       const double offset)
{
  const LeafTable<dim>& table = mesh.leaves();
  const Particles<dim> particles = make_particles(table, octree, offset);
  const ParticleArrays arrays = make_arrays(particles.centre.size(), particles.volume);

  const BoxParts<dim> parts = find_box_parts<dim>(table, particles.centre, particles.half_width, particles.leaf);
  HostStencils host =
      build_stencils<dim>(table, gimp ? parts
                                      : find_box_parts<dim>(table, particles.centre,
                                                            point_boxes<dim>(particles.half_width), particles.leaf));
  const std::vector<double> young = download(arrays.young), mass = download(arrays.mass),
                            volume = download(arrays.initial_volume);
  const std::vector<LeafContent> contents =
      find_leaf_contents<dim>(table, {parts, particles.half_width, young, mass, volume}, poor_factor, MPI_COMM_SELF);
  HostGhostFaces host_faces = find_ghost_faces<dim>(table, contents, {1., 1.});
  std::vector<unsigned char> used(table.node_ids.size(), 0);
  for (const auto& list : {host.pattern_nodes, host_faces.nodes})
    for (const unsigned int node : list)
      used[node] = 1;
  const ActiveNodes nodes = number_active_nodes<dim>(table, used, MPI_COMM_SELF);
  const StencilSet stencils = upload_stencils<dim>(std::move(host), nodes.number);
  GhostFaces faces = upload_ghost_faces(std::move(host_faces), nodes.number);
  System system(dim, {MPI_COMM_SELF, nodes.n_owned, nodes.global, nodes.ghost_begin},
                {{stencils.pattern_node_begin, stencils.pattern_nodes}, {faces.node_begin, faces.nodes}},
                std::vector<unsigned char>(dim * nodes.n_local(), 0));

  const auto at_rest = system.make_nodal_vector();
  const auto ghost = [&]
  {
    return assemble(system, [&](const NodeGraph& graph, const View<double*>& values)
                    { add_ghost_matrix<dim>(faces, linearise_ghost<dim>(faces, at_rest), graph, values); });
  };
  if (kind == Kind::mass)
  {
    faces.stiffness = faces.mass;
    return {consistent_mass(stencils, particles.volume, nodes.n_local()), first_component(ghost(), dim)};
  }
  const Materials materials = make_materials();
  deform<dim>(arrays, stencils, at_rest);
  return {assemble(system, [&](const NodeGraph& graph, const View<double*>& values)
                   { add_tangent<dim>(arrays, stencils, materials, graph, values); }),
          ghost()};
}

double condition_number(const Eigen::MatrixXd& matrix, const unsigned int n_rigid)
{
  std::vector<Eigen::Index> reached;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    if (matrix(i, i) > 0.)
      reached.push_back(i);
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix(reached, reached), Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = values[values.size() - 1];
  return largest / std::max(values[n_rigid], 1e-16 * largest);
}

template std::unique_ptr<BackgroundMesh<2>> make_mesh<2>(bool);
template std::unique_ptr<BackgroundMesh<3>> make_mesh<3>(bool);
template Matrices make_matrices<2>(const BackgroundMesh<2>&, bool, bool, Kind, double);
template Matrices make_matrices<3>(const BackgroundMesh<3>&, bool, bool, Kind, double);
} // namespace kedge::translation
