#include "block.h"
#include <gtest/gtest.h>
#include <kedge/assembly/ghost.h>
#include <kedge/basis/ghost_faces.h>

using namespace kedge;

namespace
{
/// The stabilised faces of a block, its numbering widened by their nodes.
template <int dim> struct StabilisedBlock
{
  explicit StabilisedBlock(const MPI_Comm communicator = MPI_COMM_WORLD) : block(MaterialType::elastic, communicator)
  {
    const LeafTable<dim>& table = block.mesh.leaves();
    const std::vector<LeafContent> contents = find_leaf_contents<dim>(
        table, block.particles.positions(), block.particles.half_widths(), download(block.particles.arrays().young),
        download(block.particles.arrays().mass), 0.9, communicator);
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

  TpetraVector nodal(const Field& field) const
  {
    TpetraVector vector(system->graph().row_map);
    auto view = vector.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (unsigned int v = 0; v < nodes.n_owned; ++v)
      for (unsigned int d = 0; d < dim; ++d)
        view(dim * v + d, 0) = field(block.mesh.leaves().node_position[nodes.mesh_node[v]], d);
    return vector;
  }

  TpetraVector force(const kedge::View<double*>& weight, const TpetraVector& x) const
  {
    const NodalVector local = system->make_nodal_vector();
    add_ghost_force<dim>(faces, weight, system->spread(x), local);
    TpetraVector owned(system->graph().row_map);
    system->collect(local, owned);
    return owned;
  }

  TpetraVector matrix_times(const kedge::View<double*>& weight, const TpetraVector& x) const
  {
    system->clear_matrix();
    add_ghost_matrix<dim>(faces, weight, system->graph(), system->values());
    system->finish_matrix();
    TpetraVector y(system->graph().row_map);
    system->matrix()->apply(x, y);
    return y;
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
    const TpetraVector x = parts.nodal(test::Block<dim>::random_field(1., 3));
    const TpetraVector force = parts.force(weight, x);
    TpetraVector difference = parts.matrix_times(weight, x);
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
  const auto slope = [](const auto& x, const unsigned int d) { return x[0] - 2. * x[1] + 3. * d; };
  const auto& stiffness = this->parts.faces.stiffness;
  const double scale =
      this->parts.force(stiffness, this->parts.nodal(test::Block<TypeParam::value>::random_field(1., 3))).normInf();
  EXPECT_LT(this->parts.force(stiffness, this->parts.nodal(slope)).normInf(), 1e-12 * scale);
}

TYPED_TEST(GhostStabilisation, IsThatOfOneRank)
{
  constexpr int dim = TypeParam::value;
  const auto field = test::Block<dim>::random_field(1., 3);
  const auto energy = [&field](const StabilisedBlock<dim>& parts)
  {
    const TpetraVector x = parts.nodal(field);
    return x.dot(parts.force(parts.faces.stiffness, x));
  };
  const StabilisedBlock<dim> serial(MPI_COMM_SELF);
  const double expected = energy(serial);
  EXPECT_NEAR(energy(this->parts), expected, 1e-12 * expected);
}
