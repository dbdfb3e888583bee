#include <cmath>
#include <kedge/base/failure.h>
#include <kedge/soil/adaptation.h>
#include <kedge/steps/step_basis.h>

namespace kedge
{
namespace
{
/// Share of a cell that soil as dense as at the start must take for its particles to share their change of volume.
constexpr double full_share = 0.49;
/// Share of a loose leaf that soil takes at most.
constexpr double loose_share = 0.24;

/// What the leaves (owned and ghost) hold. Collective.
template <int dim> std::vector<LeafContent> find_contents(const StepContext<dim>& context, const BoxParts<dim>& parts)
{
  const ParticleSet<dim>& particles = context.soil.particles();
  const ParticleArrays& arrays = particles.arrays();
  const std::vector<double> young = download(arrays.young), mass = download(arrays.mass),
                            initial_volume = download(arrays.initial_volume);
  return find_leaf_contents<dim>(context.soil.mesh().leaves(),
                                 {parts, particles.half_widths(), young, mass, initial_volume},
                                 context.solver.poor_factor, context.soil.communicator());
}

/// Marks the leaves that are full. Only full leaves average their volume change (F-bar): beside a void, dilating soil
/// would inherit its neighbours' pressure and keep pushing outwards.
template <int dim>
std::vector<unsigned char> find_full_leaves(const LeafTable<dim>& table, const std::vector<LeafContent>& contents)
{
  std::vector<unsigned char> is_full(contents.size());
  for (std::size_t leaf = 0; leaf < contents.size(); ++leaf)
    is_full[leaf] = contents[leaf].initial_volume >= full_share * std::pow(table.leaves[leaf].size, dim);
  return is_full;
}

/// Leaves that nothing holds: there is little soil in them and no body.
template <int dim>
std::vector<unsigned char> find_loose_leaves(const StepContext<dim>& context, const std::vector<LeafContent>& contents)
{
  const LeafTable<dim>& table = context.soil.mesh().leaves();
  std::vector<unsigned char> is_loose(contents.size(), 0);
  for (std::size_t leaf = 0; leaf < contents.size(); ++leaf)
  {
    const auto& cell = table.leaves[leaf];
    if (!is_populated(contents[leaf]) || contents[leaf].volume > loose_share * std::pow(cell.size, dim))
      continue;
    is_loose[leaf] = !context.stage.rigid_bodies || !surface_touches_cell<dim>(context.bodies, cell.lower, cell.size);
  }
  return is_loose;
}

/// Marks the leaves that are full as not full where a particle of theirs reaches into a loose leaf. The pressure that
/// a cell shares is not that of its surface: it would drive out the nodes of a loose leaf, which have next to no mass,
/// the particle there would seem to dilate, and the cell would give way for it. Ghost stabilisation holds such nodes.
template <int dim>
void leave_out_loose_ends(const StepContext<dim>& context, const std::vector<LeafContent>& contents,
                          const BoxParts<dim>& parts, std::vector<unsigned char>& is_full)
{
  const std::vector<unsigned char> is_loose = find_loose_leaves(context, contents);
  const std::vector<unsigned int>& home = context.soil.particles().leaves();
  for (std::size_t p = 0; p < home.size(); ++p)
    for (std::size_t i = parts.begin[p]; i < parts.begin[p + 1]; ++i)
      if (is_loose[parts.leaf[i]] && parts.leaf[i] != home[p])
        is_full[home[p]] = 0;
}

/// How far each particle may move in a requested step, m: at its velocity, in static stages as its cell did in the last
/// step.
template <int dim> std::vector<double> find_travel(const StepContext<dim>& context)
{
  const ParticleSet<dim>& particles = context.soil.particles();
  std::vector<double> travel(particles.ids().size(), 0.);
  if (context.stage.stepping.type != StageType::static_)
  {
    const auto velocity = copy_to_host(particles.arrays().velocity);
    for (std::size_t p = 0; p < travel.size(); ++p)
      travel[p] = std::hypot(velocity(p, 0), velocity(p, 1), velocity(p, 2)) * step_length(context.stage.stepping);
    return travel;
  }
  const Prediction& prediction = context.soil.prediction();
  if (!prediction)
    return travel;
  const LeafTable<dim>& table = context.soil.mesh().leaves();
  for (std::size_t p = 0; p < travel.size(); ++p)
  {
    const auto& leaf = table.leaves[particles.leaves()[p]];
    for (unsigned int i = leaf.node_begin; i < leaf.node_begin + leaf.n_nodes; ++i)
    {
      double square = 0.;
      for (unsigned int d = 0; d < dim; ++d)
        square += std::pow((*prediction)[dim * table.nodes[i] + d], 2);
      travel[p] = std::max(travel[p], std::sqrt(square));
    }
  }
  return travel;
}
} // namespace

double StepBasis::bytes() const
{
  return double(stencils.value.span() + stencils.gradient.span()) * sizeof(double) +
         double(stencils.pattern_nodes.span() + stencils.pattern_particles.span() + cells.nodes.span()) *
             sizeof(unsigned int) +
         stencils.n_particles * (sizeof(unsigned int) + sizeof(std::size_t));
}

GhostFactors ghost_factors(const SolverParameters& solver)
{
  return {solver.ghost_factor.value_or(0.), solver.ghost_factor_mass,
          solver.ghost_factor ? 0. : automatic_ghost_strength};
}

template <int dim>
StepBasis make_step_basis(const StepContext<dim>& context, const GhostFactors& ghost_factors, const bool with_elements)
{
  const auto scope = context.timings.measure("basis");
  const ParticleSet<dim>& particles = context.soil.particles();
  const LeafTable<dim>& table = context.soil.mesh().leaves();
  const MPI_Comm communicator = context.soil.communicator();
  const bool has_ghosts =
      ghost_factors.stiffness > 0. || ghost_factors.relative_stiffness > 0. || ghost_factors.mass > 0.;
  const bool f_bar = context.soil.parameters().f_bar;
  const bool at_points = context.basis == Basis::mpm;
  BoxParts<dim> whole, points; // what leaves hold follows from the whole boxes on every basis
  agree(communicator,
        [&]
        {
          context.timings.reach("stencils");
          whole = find_box_parts<dim>(table, particles.positions(), particles.half_widths(), particles.leaves());
          if (at_points)
            points = find_box_parts<dim>(table, particles.positions(), point_boxes<dim>(particles.half_widths()),
                                         particles.leaves());
          refuse_boxes_outside<dim>(at_points ? points : whole, particles.positions());
        });
  const BoxParts<dim>& parts = at_points ? points : whole;
  const std::vector<LeafContent> contents =
      has_ghosts || f_bar ? find_contents(context, whole) : std::vector<LeafContent>();
  const auto corrections =
      f_bar && !at_points ? find_cell_corrections<dim>(table, contents) : std::vector<CellCorrection<dim>>();
  HostStencils host = build_stencils<dim>(table, parts, corrections);
  std::vector<unsigned char> used(table.node_ids.size(), 0);
  for (const unsigned int node : host.pattern_nodes)
    used[node] = 1;
  HostGhostFaces faces;
  if (has_ghosts)
  {
    faces = find_ghost_faces<dim>(table, contents, ghost_factors);
    for (const unsigned int node : faces.nodes)
      used[node] = 1; // active already, but perhaps only through other ranks' particles
  }
  StepBasis basis;
  basis.nodes = number_active_nodes<dim>(table, used, communicator);
  basis.stencils = upload_stencils<dim>(std::move(host), basis.nodes.number);
  if (f_bar)
  {
    std::vector<unsigned char> is_full = find_full_leaves<dim>(table, contents);
    if (!has_ghosts)
      leave_out_loose_ends(context, contents, parts, is_full);
    basis.cells = group_by_cell(basis.stencils, particles.leaves(), is_full);
  }
  if (with_elements)
    basis.elements =
        make_elements<dim>(table, parts, corrections, download(particles.arrays().initial_volume), basis.nodes.number,
                           groups_of_leaves(basis.cells, particles.leaves(), table.leaves.size()));
  basis.ghost_faces = upload_ghost_faces(std::move(faces), basis.nodes.number);
  return basis;
}

NodeNumbering numbering_of(const ActiveNodes& nodes)
{
  return {nodes.communicator, nodes.n_owned, nodes.global, nodes.ghost_begin};
}

template <int dim>
std::vector<unsigned char> find_constrained_dofs(const StepContext<dim>& context, const ActiveNodes& nodes)
{
  const LeafTable<dim>& table = context.soil.mesh().leaves();
  const Stage& stage = context.stage;
  std::vector<unsigned char> constrained(static_cast<std::size_t>(dim) * nodes.n_local(), 0);
  for (unsigned int v = 0; v < nodes.n_local(); ++v)
    for (unsigned int axis = 0; axis < dim; ++axis)
      for (const bool upper : {false, true})
      {
        const double face = upper ? table.upper_end(axis) : table.lower_end(axis);
        if (std::abs(table.node_position[nodes.mesh_node[v]][axis] - face) > 1e-9 * table.base_size)
          continue;
        const FaceCondition condition = upper
                                            ? stage.track.max[axis].type.value_or(stage.boundary_conditions.max[axis])
                                            : stage.track.min[axis].type.value_or(stage.boundary_conditions.min[axis]);
        for (unsigned int d = 0; d < dim; ++d)
          if (condition == FaceCondition::fixed || (condition == FaceCondition::roller && d == axis))
            constrained[dim * v + d] = 1;
      }
  return constrained;
}

template <int dim>
void find_contact_pairs(const StepContext<dim>& context, const ActiveNodes& nodes, const RigidStep& whole)
{
  const auto scope = context.timings.measure("contact search");
  const RigidSystems& bodies = context.bodies;
  const std::vector<SystemSize> sizes = sizes_of_systems(bodies, dim);
  const double pushed = whole.dt == 0. ? largest_prescribed_motion(bodies) : 0.;
  std::vector<double> reach(sizes.size(), 0.); // joints move one body of a system by another
  for (std::size_t i = 0; i < bodies.points.size(); ++i)
  {
    const RigidPoint& point = bodies.points[i];
    const unsigned int system = system_of(bodies, i);
    const double lever = std::max(sizes[system].extent, sizes[system].farthest);
    const bool moves_freely = point.n_free_dofs() > 0;
    const Vector6 expected = point.prescribed_increment(1.) + (moves_freely ? whole.dt : 0.) * point.velocity;
    double distance = expected.head<3>().norm() + expected.tail<3>().norm() * lever;
    if (moves_freely) // it may speed up
      distance = 2. * distance + whole.gravity.norm() * whole.dt * whole.dt;
    if (moves_freely) // at rest others may push it through the soil
      distance = std::max(distance, pushed);
    reach[system] = std::max(reach[system], distance);
  }
  std::vector<double> reach_of_surfaces;
  for (const WeldedSurface& welded : bodies.surfaces)
    reach_of_surfaces.push_back(reach[system_of(bodies, welded.point)]);
  const ParticleSet<dim>& particles = context.soil.particles();
  const std::vector<double> volume = download(particles.arrays().initial_volume);
  const std::vector<double> young = download(particles.arrays().young);
  const std::vector<double> travel = find_travel(context);
  context.soil.contact().find_pairs(
      bodies, context.soil.mesh().leaves(),
      {particles.positions(), particles.half_widths(), particles.ids(), volume, young, travel}, nodes.number,
      reach_of_surfaces);
}

template <int dim>
std::vector<Vector6> find_reactions(const StepContext<dim>& context, const RigidStep& step,
                                    const std::vector<Vector6>& increments, const BodyLoads& loads)
{
  const RigidSystems& bodies = context.bodies;
  if (context.stage.rigid_bodies)
    return rigid_reactions(bodies, rigid_balance(bodies, step, increments, loads), increments);
  std::vector<Vector6> result(bodies.points.size(), Vector6::Zero());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i].head<3>() = -bodies.points[i].mass * step.gravity;
  return result;
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template StepBasis make_step_basis<dim>(const StepContext<dim>&, const GhostFactors&, bool);                         \
  template std::vector<unsigned char> find_constrained_dofs<dim>(const StepContext<dim>&, const ActiveNodes&);         \
  template void find_contact_pairs<dim>(const StepContext<dim>&, const ActiveNodes&, const RigidStep&);                \
  template std::vector<Vector6> find_reactions<dim>(const StepContext<dim>&, const RigidStep&,                         \
                                                    const std::vector<Vector6>&, const BodyLoads&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
