#include <cmath>
#include <kedge/base/world_axes.h>
#include <kedge/basis/ghost_faces.h>
#include <kedge/mesh/adaptation.h>
#include <kedge/soil/adaptation.h>
#include <kedge/soil/soil.h>
#include <limits>

namespace kedge
{
namespace
{
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

/// Whether a surface comes so near to a cell, m.
template <int dim>
bool comes_within(const RigidSystems& bodies, const std::array<double, dim>& corner, const double size,
                  const double distance)
{
  std::array<double, dim> far_corner = corner;
  for (double& x : far_corner)
    x += size;
  return surface_comes_within(bodies, to_world<dim>(corner), to_world<dim>(far_corner), distance);
}
} // namespace

template <int dim>
bool surface_touches_cell(const RigidSystems& bodies, const std::array<double, dim>& corner, const double size)
{
  return comes_within<dim>(bodies, corner, size, touching * size);
}

template <int dim>
double wanted_size(const RigidSystems& bodies, const Adaptivity& adaptivity, const double base_size,
                   const std::array<double, dim>& corner, const double size)
{
  if (adaptivity.type != AdaptivityType::rigid_body_surface)
    return base_size;
  double wanted = base_size;
  for (const RefinedBox& box : adaptivity.boxes)
    if (box.element_size < wanted && reaches_into<dim>(box, corner, size))
      wanted = box.element_size;
  if (surface_touches_cell<dim>(bodies, corner, size))
    return std::min(wanted, adaptivity.element_size);
  if (adaptivity.region > 0. && adaptivity.element_size_in_region < wanted &&
      comes_within<dim>(bodies, corner, size, adaptivity.region))
    return adaptivity.element_size_in_region;
  return wanted;
}

template <int dim>
CellAdaptation<dim>::CellAdaptation(BackgroundMesh<dim>& mesh_, ParticleSet<dim>& particles_,
                                    const RigidSystems& bodies_, const Adaptivity& adaptivity_,
                                    const unsigned int points_per_axis_)
    : mesh(mesh_),
      particles(particles_),
      bodies(bodies_),
      adaptivity(adaptivity_),
      points_per_axis(points_per_axis_),
      finest(mesh.layout().base_size),
      refines(adaptivity.type == AdaptivityType::rigid_body_surface)
{
  for (const double size : finer_sizes(adaptivity))
    finest = std::min(finest, size);
}

template <int dim> typename CellAdaptation<dim>::Pass CellAdaptation<dim>::next()
{
  const WantedSize<dim> wanted = [this](const std::array<double, dim>& lower, const double size)
  { return wanted_size<dim>(bodies, adaptivity, mesh.layout().base_size, lower, size); };
  const auto find = [this](const std::vector<unsigned char>& asked) { return find_soil(asked); };
  refines = refines && flag_refinement<dim>(mesh, wanted, finest, find) && change_cells();
  if (refines)
    return Pass::cells;
  switch (flag_coarsening<dim>(mesh, wanted, find_largest_sizes()))
  {
    case Coarsening::flagged:
      gathered = false;
      return change_cells() ? Pass::cells : Pass::none;
    case Coarsening::split_families:
      if (gathered) // a repartition did not bring them together
        return Pass::none;
      particles.balance_load(particle_cost);
      gathered = true;
      return Pass::partition;
    case Coarsening::none:
      break;
  }
  return Pass::none;
}

/// False where the forest has refused all that was flagged: to ask again would never end.
template <int dim> bool CellAdaptation<dim>::change_cells()
{
  before = mesh.leaves();
  const auto n_before = mesh.triangulation().n_global_active_cells();
  particles.carry_through([this] { mesh.triangulation().execute_coarsening_and_refinement(); });
  return mesh.triangulation().n_global_active_cells() != n_before;
}

/// By leaf: whether any rank's particles reach into it. They reach no farther than through the neighbours of their own.
template <int dim>
std::vector<unsigned char> CellAdaptation<dim>::find_soil(const std::vector<unsigned char>& asked) const
{
  const LeafTable<dim>& table = mesh.leaves();
  std::vector<unsigned int> around;
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (asked[i])
      find_touching<dim>(table, table.leaves[i].lower, table.leaves[i].size, around);
  std::vector<unsigned char> may_reach(asked.size(), false);
  for (const unsigned int leaf : around)
    may_reach[leaf] = true;
  std::vector<std::array<double, dim>> centres, half_widths;
  for (std::size_t p = 0; p < particles.positions().size(); ++p)
    if (may_reach[particles.leaves()[p]])
    {
      centres.push_back(particles.positions()[p]);
      half_widths.push_back(particles.half_widths()[p]);
    }
  const std::vector<double> nothing(centres.size(), 0.); // the volume is all that counts here
  const std::vector<LeafContent> contents = find_leaf_contents<dim>(
      table, {find_box_parts<dim>(table, centres, half_widths), half_widths, nothing, nothing, nothing}, 0.,
      mesh.communicator());
  std::vector<unsigned char> holds_soil(contents.size());
  for (std::size_t leaf = 0; leaf < contents.size(); ++leaf)
    holds_soil[leaf] = is_populated(contents[leaf]);
  return holds_soil;
}

/// By leaf: the largest edge that its particles allow. The mean width of a particle may grow by half a level, for
/// domains follow the deformation.
template <int dim> std::vector<double> CellAdaptation<dim>::find_largest_sizes() const
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

template double wanted_size<2>(const RigidSystems&, const Adaptivity&, double, const std::array<double, 2>&, double);
template double wanted_size<3>(const RigidSystems&, const Adaptivity&, double, const std::array<double, 3>&, double);
template class CellAdaptation<2>;
template class CellAdaptation<3>;
template bool surface_touches_cell<2>(const RigidSystems&, const std::array<double, 2>&, double);
template bool surface_touches_cell<3>(const RigidSystems&, const std::array<double, 3>&, double);
} // namespace kedge
