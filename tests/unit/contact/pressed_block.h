// A flat box pressed into the surface of a block of soil.
#pragma once

#include "../bodies/shapes.h"
#include "../soil_fixture.h"
#include <kedge/basis/active_nodes.h>

namespace kedge::test
{
/// What an evaluation of contact has returned, on the host.
struct HostPointForces
{
  explicit HostPointForces(const PointForces& points)
      : begin(download(points.begin)),
        nodes(download(points.nodes)),
        weights(download(points.weights)),
        force(download(points.force)),
        tangent(download(points.tangent))
  {
  }
  std::size_t n_points() const { return begin.size() - 1; }

  std::vector<unsigned int> begin, nodes;
  std::vector<double> weights, force, tangent;
};

/// Soil of 4 (by 4) by 2 cells of 0.5 m with 2 particles per axis, its surface at 1 m. The box covers the middle of the
/// surface, from 0.4 to 1.6 m along each horizontal axis unless told; corners of particles lie at multiples of 0.25 m.
template <int dim> struct PressedBlock : SoilFixture<dim>
{
  static constexpr double young = 1e7, spacing = 0.25;
  using Position = std::array<double, dim>;
  using SoilFixture<dim>::contact;
  using SoilFixture<dim>::mesh;
  using SoilFixture<dim>::particles;

  /// `depth`: how far the lower face of the box lies below the surface, m. `half_length`: of the box, m.
  PressedBlock(const double friction, const double depth, const double half_length = 0.6)
      : SoilFixture<dim>(layout(), layers_of({elastic_layer(1., 2000., young)}), 10., contact_parameters(friction))
  {
    // y = 0 is far from the ends of the plane's box
    const double back = dim == 3 ? -half_length : -50., front = dim == 3 ? half_length : 50.;
    bodies.points.emplace_back();
    bodies.points[0].pose.position = {1., dim == 3 ? 1. : 0., 1. - depth};
    bodies.surfaces.push_back({Surface(box({-half_length, back, 0.}, {half_length, front, 1.})), 0});
  }

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(4);
    return make_brick<dim>(cells, 0.5, 0.5);
  }

  static ContactParameters contact_parameters(const double friction)
  {
    ContactParameters parameters;
    parameters.interface.friction_coefficient = friction;
    return parameters;
  }

  /// N/m of one corner under the default penalty factors.
  static double normal_stiffness()
  {
    return ContactParameters().normal_penalty_factor * young * std::pow(spacing, dim - 2) * (dim == 3 ? 0.25 : 0.5);
  }
  static double tangential_stiffness() { return 0.5 * normal_stiffness(); }

  /// Corners under the box: five places along each horizontal axis, each shared by two particles.
  static unsigned int n_corners() { return dim == 3 ? 100 : 10; }

  void find_pairs(const double reach = 0.)
  {
    const LeafTable<dim>& table = mesh.leaves();
    HostStencils host =
        build_stencils<dim>(table, find_box_parts<dim>(table, particles.positions(), particles.half_widths()));
    std::vector<unsigned char> used(table.node_ids.size(), 0);
    for (const unsigned int node : host.pattern_nodes)
      used[node] = 1;
    nodes = number_active_nodes<dim>(table, used, MPI_COMM_WORLD);
    const auto volume = copy_to_host(particles.arrays().initial_volume),
               stiffness = copy_to_host(particles.arrays().young);
    const std::vector<double> volumes(volume.data(), volume.data() + volume.extent(0));
    const std::vector<double> moduli(stiffness.data(), stiffness.data() + stiffness.extent(0));
    const std::vector<double> travel(particles.ids().size(), 0.);
    contact.find_pairs(bodies, table,
                       {particles.positions(), particles.half_widths(), particles.ids(), volumes, moduli, travel},
                       nodes.number, std::vector<double>(bodies.surfaces.size(), reach));
  }

  const Position& node_position(const unsigned int v) const { return mesh.leaves().node_position[nodes.mesh_node[v]]; }

  /// Evaluates for a displacement field of the soil and an increment of the box.
  template <typename Field> HostPointForces evaluate(const Field& field, const Vector6& box_increment = Vector6::Zero())
  {
    increment.assign(dim * nodes.n_local(), 0.);
    for (unsigned int v = 0; v < nodes.n_local(); ++v)
      for (unsigned int d = 0; d < dim; ++d)
        increment[dim * v + d] = field(node_position(v), d);
    box_increments = {box_increment};
    return HostPointForces(contact.evaluate(bodies, box_increments, upload(increment, "increment")));
  }
  HostPointForces evaluate_at_rest()
  {
    return evaluate([](const Position&, unsigned int) { return 0.; });
  }

  /// Force and moment of the soil on the box in the last evaluation.
  Vector6 load() const { return contact.loads()[0]; }

  /// Moves soil and box by the same displacement.
  void move_everything(const Position& displacement, const Vector6& box_increment)
  {
    this->move([&](long long, const unsigned int d) { return displacement[d]; });
    bodies.points[0].pose = bodies.points[0].pose.moved(box_increment);
  }

  RigidSystems bodies;
  ActiveNodes nodes;
  std::vector<double> increment;
  std::vector<Vector6> box_increments;
};

inline Vector6 translation(const double x, const double y, const double z)
{
  Vector6 increment = Vector6::Zero();
  increment.head<3>() << x, y, z;
  return increment;
}

/// Rotation about y, rad.
inline Vector6 tilt(const double angle)
{
  Vector6 increment = Vector6::Zero();
  increment[4] = angle;
  return increment;
}
} // namespace kedge::test
