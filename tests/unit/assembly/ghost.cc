#include "block.h"
#include <gtest/gtest.h>
#include <kedge/assembly/ghost.h>
#include <kedge/basis/ghost_faces.h>

using namespace kedge;
using test::on_host;

namespace
{
/// The stabilised faces of a block, and a numbering that includes their nodes.
template <int dim> struct StabilisedBlock
{
  explicit StabilisedBlock(const MPI_Comm communicator = MPI_COMM_WORLD)
      : block(test::soil_material<Elastic>(), communicator)
  {
    const LeafTable<dim>& table = block.mesh.leaves();
    const ParticleArrays& particles = block.particles.arrays();
    const std::vector<double> young = download(particles.young), mass = download(particles.mass),
                              initial_volume = download(particles.initial_volume);
    const std::vector<LeafContent> contents = find_leaf_contents<dim>(
        table, {block.particles.positions(), block.particles.half_widths(), young, mass, initial_volume}, 0.9,
        communicator);
    HostGhostFaces host = find_ghost_faces<dim>(table, contents, {0.1, 0.25});
    std::vector<unsigned char> used(table.node_ids.size(), 0);
    for (const unsigned int node : host.nodes)
      used[node] = 1;
    nodes = number_active_nodes<dim>(table, used, communicator);
    faces = upload_ghost_faces(std::move(host), nodes.number);
    system = std::make_unique<System>(dim, NodeNumbering{communicator, nodes.n_owned, nodes.global, nodes.ghost_begin},
                                      std::vector<NodeLists>{{faces.node_begin, faces.nodes}},
                                      std::vector<unsigned char>(dim * nodes.n_local(), 0));
  }

  using Field = typename test::Discretisation<dim>::Field;

  /// A field at the nodes of this rank, ghosts included.
  NodalVector nodal(const Field& field) const
  {
    std::vector<double> values;
    for (const unsigned int node : nodes.mesh_node)
      for (unsigned int d = 0; d < dim; ++d)
        values.push_back(field(block.mesh.leaves().node_position[node], d));
    return upload(values, "nodal vector");
  }

  /// Contribution of this rank's faces.
  NodalVector force(const kedge::View<double*>& weight, const NodalVector& x) const
  {
    const NodalVector result = system->make_nodal_vector();
    add_ghost_force<dim>(faces, weight, x, result);
    return result;
  }

  TpetraVector matrix_times(const kedge::View<double*>& weight, const NodalVector& x) const
  {
    system->clear_matrix();
    add_ghost_matrix<dim>(faces, weight, system->graph(), system->values());
    system->finish_matrix();
    TpetraVector owned(system->graph().row_map), product(system->graph().row_map);
    const auto from = on_host(x);
    auto to = owned.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (unsigned int i = 0; i < dim * nodes.n_owned; ++i)
      to(i, 0) = from(i);
    system->matrix()->apply(owned, product);
    return product;
  }

  test::Block<dim> block;
  ActiveNodes nodes;
  GhostFaces faces;
  std::unique_ptr<System> system;
};

template <typename Dimension> class GhostStabilisation : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  /// Largest difference of matrix times vector and force, relative to the force.
  double error_of_matrix(const kedge::View<double*>& weight) const
  {
    const NodalVector x = parts.nodal(test::Block<dim>::random_field(1., 3));
    TpetraVector difference = parts.matrix_times(weight, x), force(difference.getMap());
    parts.system->collect(parts.force(weight, x), force);
    difference.update(-1., force, 1.);
    return difference.normInf() / force.normInf();
  }

  StabilisedBlock<dim> parts;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(GhostStabilisation, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(GhostStabilisation, OfTheStiffnessIsTheDerivativeOfItsForce)
{
  EXPECT_LT(this->error_of_matrix(this->parts.faces.stiffness), 1e-13);
}

TYPED_TEST(GhostStabilisation, OfTheMassIsTheDerivativeOfItsForce)
{
  EXPECT_LT(this->error_of_matrix(this->parts.faces.mass), 1e-13);
}

TYPED_TEST(GhostStabilisation, LeavesLinearFieldsAlone)
{
  const auto largest = [this](const auto& field)
  {
    double result = 0.;
    const auto force = on_host(this->parts.force(this->parts.faces.stiffness, this->parts.nodal(field)));
    for (std::size_t i = 0; i < force.extent(0); ++i)
      result = std::max(result, std::abs(force(i)));
    return max_over_ranks(result, MPI_COMM_WORLD);
  };
  EXPECT_LT(largest([](const auto& x, const unsigned int d) { return x[0] - 2. * x[1] + 3. * d; }),
            1e-12 * largest(test::Block<TypeParam::value>::random_field(1., 3)));
}

TYPED_TEST(GhostStabilisation, IsThatOfOneRank)
{
  constexpr int dim = TypeParam::value;
  const auto field = test::Block<dim>::random_field(1., 3);
  const auto energy = [&field](const StabilisedBlock<dim>& parts)
  {
    const NodalVector x = parts.nodal(field);
    const auto displacement = on_host(x), force = on_host(parts.force(parts.faces.stiffness, x));
    double sum = 0.;
    // The system's vector may be longer: nodes that only other ranks' faces couple come last in it.
    for (std::size_t i = 0; i < displacement.extent(0); ++i)
      sum += displacement(i) * force(i);
    return sum_over_ranks(sum, parts.nodes.communicator);
  };
  const StabilisedBlock<dim> serial(MPI_COMM_SELF);
  const double expected = energy(serial);
  EXPECT_NEAR(energy(this->parts), expected, 1e-12 * expected);
}
