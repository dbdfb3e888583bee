#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/base/world_axes.h>
#include <kedge/particles/expressions.h>
#include <kedge/particles/generation.h>
#include <kedge/particles/merging.h>
#include <kedge/particles/splitting.h>
#include <kedge/soil/adaptation.h>
#include <kedge/soil/soil.h>

namespace kedge
{
namespace
{
/// Work of the busiest rank over the mean above which a repartition pays.
constexpr double worst_imbalance = 1.05;

/// Samples per axis of a box.
constexpr unsigned int samples = 4;

/// Cosine between the normals of surfaces that face each other, at most.
constexpr double facing = -0.5;
/// Boxes that a slit between bodies must hold side by side. A single row in the cells of both walls cannot yield.
constexpr double boxes_across_slit = 2.;

/// Where the surfaces are that reach nearer to a point than the radius.
template <int dim>
std::vector<ClosestPoint> surfaces_around(const RigidSystems& bodies, const dealii::Point<dim>& centre,
                                          const double radius)
{
  std::vector<ClosestPoint> found;
  for (const WeldedSurface& welded : bodies.surfaces)
  {
    const Pose& pose = bodies.points[welded.point].pose;
    const Eigen::Vector3d x = pose.to_body(to_world<dim>(centre));
    if (auto closest = welded.surface.closest_point_within(x, radius); closest && closest->gap < radius)
    {
      closest->normal = pose.direction_to_world(closest->normal);
      found.push_back(*closest);
    }
  }
  return found;
}

/// Whether a box lies in a slit between two bodies that is too narrow for soil.
template <int dim> bool is_squeezed(const std::vector<ClosestPoint>& around, const double* half_width)
{
  for (std::size_t i = 0; i < around.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
    {
      if (around[i].normal.dot(around[j].normal) > facing)
        continue;
      const Eigen::Vector3d across = (around[i].normal - around[j].normal).normalized();
      double width = 0.; // of the box
      for (unsigned int d = 0; d < dim; ++d)
        width += 2. * half_width[d] * std::abs(across[world_axis(dim, d)]);
      if (around[i].gap + around[j].gap < boxes_across_slit * width)
        return true;
    }
  return false;
}

/// Whether the bodies leave no room for a box: more than half of it lies inside them, or it is squeezed in a slit.
/// Beside one face that is where its centre lies inside; between two bodies, or in a corner, it may not.
template <int dim>
bool has_no_room(const RigidSystems& bodies, const dealii::Point<dim>& centre, const double* half_width)
{
  double radius = 0., to_corner = 0.;
  for (unsigned int d = 0; d < dim; ++d)
  {
    radius += half_width[d];
    to_corner = std::hypot(to_corner, half_width[d]);
  }
  const std::vector<ClosestPoint> around = surfaces_around<dim>(bodies, centre, 2. * radius);
  if (is_squeezed<dim>(around, half_width))
    return true;
  if (std::none_of(around.begin(), around.end(), [&](const ClosestPoint& at) { return at.gap < to_corner; }))
    return false; // no part of the box is inside
  const unsigned int n = dim == 3 ? samples * samples * samples : samples * samples;
  unsigned int inside = 0;
  for (unsigned int sample = 0; sample < n; ++sample)
  {
    dealii::Point<dim> x = centre;
    for (unsigned int d = 0, rest = sample; d < dim; ++d, rest /= samples)
      x[d] += ((2. * (rest % samples) + 1.) / samples - 1.) * half_width[d];
    inside += is_inside(bodies, to_world<dim>(x));
  }
  return 2 * inside > n;
}

Materials upload_layers(const std::vector<Layer>& layers)
{
  std::vector<MaterialParameters> parameters;
  for (const Layer& layer : layers)
    parameters.push_back(layer.material);
  return upload_materials(parameters);
}
} // namespace

template <int dim>
Soil<dim>::Soil(const GridLayout<dim>& layout, const MaterialPointParameters& parameters,
                const ContactParameters& contact, const MPI_Comm communicator)
    : given(parameters),
      grid(communicator, layout),
      points(grid),
      laws(upload_layers(parameters.layers)),
      contacts(contact, communicator)
{
}

template <int dim> long long Soil<dim>::count_cells() const
{
  long long cells = 0;
  for (const auto& cell : grid.triangulation().active_cell_iterators())
    cells += cell->is_locally_owned() && grid.in_window(cell) && points.handler().n_particles_in_cell(cell) > 0;
  return sum_over_ranks(cells, communicator());
}

template <int dim> void Soil<dim>::generate(const double gravity)
{
  generate_particles(points, grid, given, gravity);
  gravity_at_rest = gravity;
  set_initial_state();
  points.balance_load(particle_cost);
}

/// Again after each split before the first step.
template <int dim> void Soil<dim>::set_initial_state()
{
  if (!gravity_at_rest)
    return;
  set_state_at_rest(points, grid.layout(), given, *gravity_at_rest);
  if (!given.initial_velocity.empty())
    set_initial_velocity(points, given.initial_velocity, communicator());
}

template <int dim> void Soil<dim>::place_window(const RigidSystems& bodies, const BoundaryTrack& track)
{
  set_window(kedge::place_window<dim>(track, extent_of<dim>(bodies), grid.layout()), track);
}

template <int dim> void Soil<dim>::move_window(const RigidSystems& bodies, const BoundaryTrack& track)
{
  set_window(advance_window<dim>(grid.leaves().window, track, extent_of<dim>(bodies), grid.layout()), track);
}

template <int dim> void Soil<dim>::set_window(const Window<dim>& window, const BoundaryTrack& track)
{
  if (window == grid.leaves().window)
    return;
  grid.set_window(window);
  const long long removed = points.remove_if(
      [&](const auto& particle)
      {
        // by its cell, as activity is
        const dealii::Point<dim> centre = particle.get_surrounding_cell()->center();
        std::array<double, dim> x;
        for (unsigned int d = 0; d < dim; ++d)
          x[d] = centre[d];
        return is_left_behind<dim>(x, window, track, grid.layout());
      });
  deleted += removed;
  const LeafTable<dim> before = grid.leaves();
  const bool balanced = balance_where_it_pays();
  if (balanced || removed > 0)
    follow_particles(); // before a split gives the number of one that is gone to another
  if (balanced)
    guess = transfer_prediction<dim>(guess, before, grid.leaves(), communicator());
}

template <int dim> HopelessParticles Soil<dim>::clean(const bool has_inertia)
{
  const HopelessParticles removed = remove_hopeless_particles(points, grid, has_inertia);
  const long long n = removed.distorted + removed.isolated;
  deleted += n;
  if (n > 0)
    follow_particles();
  return removed;
}

template <int dim> bool Soil<dim>::adapt(const RigidSystems& bodies, const Adaptivity& adaptivity)
{
  using Pass = typename CellAdaptation<dim>::Pass;
  const LeafTable<dim> before = grid.leaves();
  CellAdaptation<dim> cells(grid, points, bodies, adaptivity, given.points_per_axis);
  bool changed = false;
  for (Pass pass = cells.next(); pass != Pass::none; pass = cells.next())
  {
    if (pass == Pass::cells)
    {
      const FormerCells<dim> former{cells.former(), laws};
      contacts.inherit(split_particles<dim>(points, grid, given.points_per_axis, former), bodies);
      balance_where_it_pays();
    }
    follow_particles();
    changed = true;
  }
  if (!changed)
    return split(bodies);
  guess = transfer_prediction<dim>(guess, before, grid.leaves(), communicator());
  if (adaptivity.merge)
    merge();
  set_initial_state();
  return true;
}

template <int dim> bool Soil<dim>::split(const RigidSystems& bodies)
{
  if (!any_too_wide<dim>(points, grid, given.points_per_axis))
    return false;
  const LeafTable<dim> before = grid.leaves();
  contacts.inherit(split_particles(points, grid, given.points_per_axis), bodies);
  if (balance_where_it_pays())
    guess = transfer_prediction<dim>(guess, before, grid.leaves(), communicator());
  follow_particles();
  set_initial_state();
  return true;
}

template <int dim> void Soil<dim>::merge()
{
  const auto keep_none = [](const dealii::Point<dim>&) { return false; };
  if (merge_particles<dim>(points, grid, given.points_per_axis, keep_none).removed > 0)
    follow_particles();
}

/// Spreads cells and particles anew over the ranks if the busiest one has much more than the mean work.
template <int dim> bool Soil<dim>::balance_where_it_pays()
{
  if (points.imbalance(particle_cost) <= worst_imbalance)
    return false;
  points.balance_load(particle_cost);
  return true;
}

template <int dim> long long Soil<dim>::remove_buried(const RigidSystems& bodies)
{
  const long long removed = points.remove_if(
      [&](const auto& particle)
      {
        const dealii::Point<dim> x = particle.get_location();
        return is_inside(bodies, to_world<dim>(x)) ||
               has_no_room<dim>(bodies, x, &particle.get_properties()[field::half_width]);
      });
  deleted += removed;
  if (removed > 0)
    follow_particles();
  return removed;
}

template <int dim> void Soil<dim>::commit(const SoilIncrements& increments, const RigidSystems* bodies)
{
  points.set_contact_gaps(bodies != nullptr ? contacts.smallest_gaps(*bodies) : decltype(contacts.smallest_gaps({}))());
  if (bodies != nullptr)
    contacts.commit();
  guess = increments.prediction;
  gravity_at_rest.reset();
  const DomainUpdate automatic = given.f_bar ? DomainUpdate::flow : DomainUpdate::none;
  points.commit(increments.particles, given.domain_update == DomainUpdate::automatic ? automatic : given.domain_update);
  follow_particles();
}

template <int dim> void Soil<dim>::follow_particles() { contacts.follow_particles(all_ids(points)); }

template <int dim> std::vector<long long> all_ids(const ParticleSet<dim>& particles)
{
  std::vector<long long> ids;
  ids.reserve(particles.handler().n_locally_owned_particles());
  for (const auto& particle : particles.handler())
    ids.push_back(particle.get_id());
  return ids;
}

template <int dim> Extent<dim> extent_of(const RigidSystems& bodies)
{
  const auto box = world_bounds(bodies);
  Extent<dim> extent;
  for (unsigned int d = 0; d < dim; ++d)
  {
    extent.lower[d] = box[0][world_axis(dim, d)];
    extent.upper[d] = box[1][world_axis(dim, d)];
  }
  return extent;
}

template class Soil<2>;
template class Soil<3>;
template std::vector<long long> all_ids<2>(const ParticleSet<2>&);
template std::vector<long long> all_ids<3>(const ParticleSet<3>&);
template Extent<2> extent_of<2>(const RigidSystems&);
template Extent<3> extent_of<3>(const RigidSystems&);
} // namespace kedge
