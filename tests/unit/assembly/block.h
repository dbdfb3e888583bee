// A block of soil with hanging nodes and particles that straddle cells, ready for the kernels.
#pragma once

#include "../soil_fixture.h"
#include <functional>
#include <kedge/assembly/system.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/basis/elements.h>
#include <memory>

namespace kedge::test
{
template <typename Law> MaterialParameters soil_material()
{
  MaterialParameters parameters;
  parameters.law = law_index<Law>;
  parameters.young = 1e7;
  parameters.poisson = 0.3;
  parameters.density = 2000.;
  parameters.constants.values = {{"friction angle", 20.}, {"dilation angle", 5.}, {"cohesion", 2e3}};
  return parameters;
}

/// A law with memory.
inline MaterialParameters softening_soil()
{
  MaterialParameters parameters = soil_material<MohrCoulomb>();
  parameters.constants.values["critical friction angle"] = 15.;
  parameters.constants.values["critical dilation angle"] = 0.;
  parameters.constants.values["softening strain"] = 0.1;
  parameters.constants.values["shear band width"] = 0.2;
  return parameters;
}

/// The data of correctly placed particles that the kernels and the system need.
template <int dim> struct Discretisation
{
  Discretisation(const BackgroundMesh<dim>& mesh, const ParticleSet<dim>& particles)
  {
    const LeafTable<dim>& table = mesh.leaves();
    box_parts = find_box_parts<dim>(table, particles.positions(), particles.half_widths(), particles.leaves());
    HostStencils host = build_stencils<dim>(table, box_parts);
    std::vector<unsigned char> used(table.node_ids.size(), 0);
    for (const unsigned int node : host.pattern_nodes)
      used[node] = 1;
    nodes = number_active_nodes<dim>(table, used, mesh.communicator());
    stencils = upload_stencils<dim>(std::move(host), nodes.number);
    cells = group_by_cell(stencils, particles.leaves(), std::vector<unsigned char>(mesh.leaves().leaves.size(), 1));
    for (const unsigned int node : nodes.mesh_node)
      position.push_back(table.node_position[node]);
  }

  std::unique_ptr<System> make_system(const std::vector<unsigned char>& constrained, const bool f_bar = false) const
  {
    const std::vector<NodeLists> couplings{f_bar ? NodeLists{cells.node_begin, cells.nodes}
                                                 : NodeLists{stencils.pattern_node_begin, stencils.pattern_nodes}};
    return std::make_unique<System>(dim, numbering(), couplings, constrained);
  }
  std::unique_ptr<System> make_system(const bool f_bar = false) const
  {
    return make_system(std::vector<unsigned char>(dim * nodes.n_local(), 0), f_bar);
  }

  NodeNumbering numbering() const { return {nodes.communicator, nodes.n_owned, nodes.global, nodes.ghost_begin}; }

  Elements make_elements(const BackgroundMesh<dim>& mesh, const ParticleSet<dim>& particles,
                         const CellGroups& groups) const
  {
    const LeafTable<dim>& table = mesh.leaves();
    return kedge::make_elements<dim>(table, box_parts, {}, download(particles.arrays().initial_volume), nodes.number,
                                     groups_of_leaves(groups, particles.leaves(), table.leaves.size()));
  }

  using Field = std::function<double(const std::array<double, dim>& position, unsigned int component)>;

  /// A field at the nodes of this rank, ghosts included.
  NodalVector nodal(const Field& field) const
  {
    NodalVector vector("nodal vector", dim * nodes.n_local());
    const auto host = make_mirror(vector);
    for (unsigned int v = 0; v < nodes.n_local(); ++v)
      for (unsigned int d = 0; d < dim; ++d)
        host(dim * v + d) = field(position[v], d);
    Kokkos::deep_copy(vector, host);
    return vector;
  }

  /// A field at the nodes that this rank owns.
  TpetraVector owned(const System& system, const Field& field) const
  {
    TpetraVector vector(system.graph().row_map);
    auto view = vector.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (unsigned int v = 0; v < nodes.n_owned; ++v)
      for (unsigned int d = 0; d < dim; ++d)
        view(dim * v + d, 0) = field(position[v], d);
    return vector;
  }

  ActiveNodes nodes;
  StencilSet stencils;
  BoxParts<dim> box_parts;
  CellGroups cells;                              ///< what F-bar averages over
  std::vector<std::array<double, dim>> position; ///< of the nodes of this rank
};

/// Soil under isotropic pressure with some shear, random but the same on any number of ranks; in 2-D in plane strain.
template <int dim> struct Block : SoilFixture<dim>
{
  static constexpr double cell = 0.3;
  using SoilFixture<dim>::particles;

  explicit Block(const MaterialParameters& material, const MPI_Comm communicator = MPI_COMM_WORLD,
                 const bool stressed = true)
      : SoilFixture<dim>(layout(), layers_of({{1., material}}), 9.81, {}, communicator),
        materials(this->soil.materials())
  {
    if (stressed)
      stress();
    this->refine(false, 11);
    shake();
    parts = std::make_unique<Discretisation<dim>>(this->mesh, particles);
  }

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(3);
    cells[0] = 4;
    return make_brick<dim>(cells, cell, 2. / 3.);
  }

  void stress()
  {
    for (auto& particle : particles.edit())
      for (unsigned int i = 0; i < (dim == 2 ? 4 : 6); ++i)
        particle.get_properties()[field::elastic_strain + i] =
            (i < 3 ? -1e-2 : 0.) + (i < 3 ? 1.2e-2 : 3e-2) * (noise(particle.get_id(), i) - 0.5);
  }

  /// Moves the particles off their lattice, far enough for boxes to straddle faces, edges and corners.
  void shake()
  {
    this->move([](const long long id, const unsigned int d) { return 0.4 * cell * (noise(id, 10 + d) - 0.5); });
  }

  /// Increments at random with strains of about the given size.
  static typename Discretisation<dim>::Field random_field(const double strain, const unsigned int salt)
  {
    return [strain, salt](const std::array<double, dim>& x, const unsigned int d)
    { return strain * cell * (noise_at(x, dim, salt + d) - 0.5); };
  }

  Materials materials;
  std::unique_ptr<Discretisation<dim>> parts;
};

/// Internal force of all ranks' particles on the owned dofs for an increment given on the owned dofs.
template <int dim>
TpetraVector internal_force(const Block<dim>& block, const System& system, const TpetraVector& increment,
                            const CellGroups& cells = {})
{
  const NodalVector force = system.make_nodal_vector();
  update_stress_and_force<dim>(block.particles.arrays(), block.parts->stencils, block.materials,
                               system.spread(increment), force, cells);
  TpetraVector owned(system.graph().row_map);
  system.collect(force, owned);
  return owned;
}
} // namespace kedge::test
