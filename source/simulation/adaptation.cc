#include <algorithm>
#include <cmath>
#include <kedge/basis/ghost_faces.h>
#include <kedge/mesh/adaptation.h>
#include <kedge/simulation/adaptation.h>
#include <limits>

namespace kedge
{
namespace
{
/// Work of the busiest rank over the mean above which a repartition pays.
constexpr double worst_imbalance = 1.1;

/// A surface in a cell's face counts as crossing the cells on both sides: a body that rests on the soil is such a one,
/// and an STL file places it in single precision.
constexpr double touching = 1e-4; // of the cell's edge

/// Touching does not count. The margin belongs to the box, so that what reaches into a cell reaches into its parent.
template <int dim> bool reaches_into(const RefinedBox& box, const std::array<double, dim>& corner, const double size)
{
  const double margin = 1e-6 * box.element_size;
  for (unsigned int d = 0; d < dim; ++d)
    if (corner[d] + size < box.min[d] + margin || corner[d] > box.max[d] - margin)
      return false;
  return true;
}

template <int dim>
double wanted_size(const AdaptationTarget& target, const double base_size, const std::array<double, dim>& corner,
                   const double size)
{
  const Adaptivity& adaptivity = target.adaptivity;
  if (adaptivity.type != AdaptivityType::rigid_body_surface)
    return base_size;
  double wanted = base_size;
  for (const RefinedBox& box : adaptivity.boxes)
    if (box.element_size < wanted && reaches_into<dim>(box, corner, size))
      wanted = box.element_size;
  // plane strain is in the plane y = 0
  const Eigen::Vector3d lower(corner[0], dim == 3 ? corner[1] : 0., corner[dim - 1]);
  const Eigen::Vector3d upper = lower + size * Eigen::Vector3d(1., dim == 3 ? 1. : 0., 1.);
  if (surface_comes_within(target.bodies, lower, upper, touching * size))
    return std::min(wanted, adaptivity.element_size);
  if (adaptivity.region > 0. && adaptivity.element_size_in_region < wanted &&
      surface_comes_within(target.bodies, lower, upper, adaptivity.region))
    return adaptivity.element_size_in_region;
  return wanted;
}

/// By leaf: whether any rank's particles reach into it.
template <int dim>
std::vector<unsigned char> find_soil(const BackgroundMesh<dim>& mesh, const ParticleSet<dim>& particles)
{
  const std::vector<double> nothing(particles.positions().size(), 0.); // the volume is all that counts here
  const std::vector<LeafContent> contents = find_leaf_contents<dim>(
      mesh.leaves(), {particles.positions(), particles.half_widths(), nothing, nothing, nothing}, 0.,
      mesh.triangulation().get_communicator());
  std::vector<unsigned char> holds_soil(contents.size());
  for (std::size_t leaf = 0; leaf < contents.size(); ++leaf)
    holds_soil[leaf] = is_populated(contents[leaf]);
  return holds_soil;
}

/// By leaf: the largest edge that its particles allow. The mean width of a particle may grow by half a level, for
/// domains follow the deformation.
template <int dim>
std::vector<double> find_largest_sizes(const BackgroundMesh<dim>& mesh, const ParticleSet<dim>& particles,
                                       const Adaptivity& adaptivity, const unsigned int points_per_axis)
{
  std::vector<double> largest(mesh.leaves().leaves.size(), std::numeric_limits<double>::infinity());
  if (adaptivity.merge) // particles follow the cells
    return largest;
  for (const auto& particle : particles.handler()) // those outside the window too, for they may come back
  {
    double volume = 1.;
    for (unsigned int d = 0; d < dim; ++d)
      volume *= 2. * particle.get_properties()[field::half_width + d];
    double& allowed = largest[mesh.leaf_number(particle.get_surrounding_cell())];
    allowed = std::min(allowed, std::sqrt(2.) * points_per_axis * std::pow(volume, 1. / dim));
  }
  return largest;
}
} // namespace

template <int dim> bool balance_where_it_pays(BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles, const double cost)
{
  if (particles.imbalance(cost) <= worst_imbalance)
    return false;
  particles.balance_load(mesh, cost);
  return true;
}

template <int dim>
bool adapt_mesh(BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles, const AdaptationTarget& target,
                const AdaptationHooks& hooks)
{
  const WantedSize<dim> wanted = [&](const std::array<double, dim>& lower, const double size)
  { return wanted_size<dim>(target, mesh.layout().base_size, lower, size); };
  const auto change = [&]
  {
    particles.carry_through([&] { mesh.triangulation().execute_coarsening_and_refinement(); });
    hooks.split_particles();
    balance_where_it_pays(mesh, particles, target.particle_cost);
    particles.load();
    hooks.follow_particles();
  };

  bool changed = false;
  const bool refines = target.adaptivity.type == AdaptivityType::rigid_body_surface;
  while (refines && flag_refinement<dim>(mesh, wanted, find_soil(mesh, particles)))
  {
    change();
    changed = true;
  }
  for (bool gathered = false;; changed = true)
    switch (flag_coarsening<dim>(mesh, wanted,
                                 find_largest_sizes(mesh, particles, target.adaptivity, target.points_per_axis)))
    {
      case Coarsening::none:
        return changed;
      case Coarsening::flagged:
        change();
        gathered = false;
        break;
      case Coarsening::split_families:
        if (gathered)
          return changed;
        particles.balance_load(mesh, target.particle_cost);
        particles.load();
        hooks.follow_particles();
        gathered = true;
        break;
    }
}

template bool balance_where_it_pays<2>(BackgroundMesh<2>&, ParticleSet<2>&, double);
template bool balance_where_it_pays<3>(BackgroundMesh<3>&, ParticleSet<3>&, double);
template bool adapt_mesh<2>(BackgroundMesh<2>&, ParticleSet<2>&, const AdaptationTarget&, const AdaptationHooks&);
template bool adapt_mesh<3>(BackgroundMesh<3>&, ParticleSet<3>&, const AdaptationTarget&, const AdaptationHooks&);
} // namespace kedge
