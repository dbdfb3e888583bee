#include "block.h"
#include <gtest/gtest.h>
#include <kedge/assembly/ghost.h>
#include <kedge/basis/ghost_faces.h>

using namespace kedge;

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
    const std::vector<LeafContent> contents =
        find_leaf_contents<dim>(table,
                                {find_box_parts<dim>(table, block.particles.positions(), block.particles.half_widths()),
                                 block.particles.half_widths(), young, mass, initial_volume},
                                0.9, communicator);
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
  NodalVector force(const NodalVector& x) const
  {
    const NodalVector result = system->make_nodal_vector();
    add_ghost_force<dim>(faces, x, result);
    return result;
  }

  /// Force of all ranks' faces on the owned dofs.
  TpetraVector owned_force(const NodalVector& x) const
  {
    TpetraVector result(system->graph().row_map);
    system->collect(force(x), result);
    return result;
  }

  /// The tangent at x times y.
  TpetraVector tangent_times(const NodalVector& x, const NodalVector& y) const
  {
    system->clear_matrix();
    add_ghost_matrix<dim>(faces, linearise_ghost<dim>(faces, x), system->graph(), system->values());
    system->finish_matrix();
    TpetraVector owned(system->graph().row_map), product(system->graph().row_map);
    const auto from = copy_to_host(y);
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

  NodalVector random(const double strain, const unsigned int salt = 3) const
  {
    return parts.nodal(test::Block<dim>::random_field(strain, salt));
  }

  /// Error of the tangent at increments of the given strain against differences of forces, relative to their largest.
  double error_of_tangent(const double strain) const
  {
    const NodalVector x = random(strain), y = random(strain, 7), forward = random(0.), backward = random(0.);
    constexpr double step = 1e-4;
    Kokkos::parallel_for(
        x.extent(0), KOKKOS_LAMBDA(const std::size_t i) {
          forward(i) = x(i) + step * y(i);
          backward(i) = x(i) - step * y(i);
        });
    TpetraVector difference = parts.owned_force(forward);
    difference.update(-0.5 / step, parts.owned_force(backward), 0.5 / step);
    const double largest = difference.normInf();
    difference.update(-1., parts.tangent_times(x, y), 1.);
    return difference.normInf() / largest;
  }

  StabilisedBlock<dim> parts;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(GhostStabilisation, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(GhostStabilisation, HasTheTangentOfItsForce)
{
  for (const double strain : {0.01, 1., 100.}) // jumps far below, at and far beyond those that yield
    EXPECT_LT(this->error_of_tangent(strain * ghost_yield_jump), 1e-6) << strain;
}

TYPED_TEST(GhostStabilisation, IsElasticAtSmallAndYieldsAtLargeJumps)
{
  constexpr double small = 1e-3 * ghost_yield_jump, large = 1e3 * ghost_yield_jump;
  const double elastic = this->parts.owned_force(this->random(small)).norm2() / small;
  EXPECT_NEAR(this->parts.owned_force(this->random(0.1 * small)).norm2() / small, 0.1 * elastic, 1e-6 * elastic);
  EXPECT_NEAR(this->parts.owned_force(this->random(large)).norm2() / large, ghost_floor * elastic, 0.01 * elastic);
}

TYPED_TEST(GhostStabilisation, OfTheMassWeighsTheJumps)
{
  constexpr int dim = TypeParam::value;
  const StabilisedBlock<dim> serial(MPI_COMM_SELF);
  const GhostFaces& faces = serial.faces;
  const NodeGraph& graph = serial.system->graph();
  const NodalMass mass("mass", graph.column.extent(0));
  add_ghost_mass(faces, graph, mass);
  const auto x = [](const unsigned int node) { return test::noise(node, 5) - 0.5; };
  double energy = 0., expected = 0.;
  for (unsigned int a = 0; a < serial.nodes.n_local(); ++a)
    for (std::size_t entry = copy_to_host(graph.row_begin)(a); entry < copy_to_host(graph.row_begin)(a + 1); ++entry)
      energy += x(a) * copy_to_host(mass)(entry) * x(copy_to_host(graph.column)(entry));
  const std::vector<unsigned int> begin = download(faces.node_begin), nodes = download(faces.nodes);
  const std::vector<std::size_t> value_begin = download(faces.value_begin);
  const std::vector<double> J = download(faces.value), weight = download(faces.mass);
  for (std::size_t f = 0; f < faces.n_faces(); ++f)
    for (unsigned int a = begin[f], i = 0; a < begin[f + 1]; ++a)
      for (unsigned int b = begin[f]; b < begin[f + 1]; ++b)
        expected += weight[f] * x(nodes[a]) * J[value_begin[f] + i++] * x(nodes[b]);
  EXPECT_NEAR(energy, expected, 1e-12 * expected);
}

TYPED_TEST(GhostStabilisation, LeavesLinearFieldsAlone)
{
  const auto largest = [this](const auto& field)
  {
    double result = 0.;
    const auto force = copy_to_host(this->parts.force(this->parts.nodal(field)));
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
    const auto displacement = copy_to_host(x), force = copy_to_host(parts.force(x));
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
