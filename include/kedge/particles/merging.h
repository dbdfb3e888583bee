// Merging of particles that are finer than their cells need.
#pragma once

#include <kedge/particles/particle_set.h>

namespace kedge
{
/// What a merge did, over all ranks.
struct MergeResult
{
  long long removed = 0;             ///< particles fewer
  double elastic_energy_lost = 0.;   ///< J (2-D: per metre)
  double elastic_energy_merged = 0.; ///< of the merged particles before, J
};

/// Where a cell holds more than points_per_axis^dim particles, joins those of one layer that lie in the same of its
/// points_per_axis^dim boxes, smallest first, as long as the sum is no wider than such a box, give or take 5 %; a
/// particle that is due for splitting is 41 % wider, so that nothing flickers. Particles stay alone where
/// `keep(position)` holds, where a corner is nearer to a body than their width, where the group would fill less than
/// 55 % of the box that has its second moments, and where their stresses differ so much that more than
/// `energy_tolerance` of the group's elastic energy would be lost. Of a group that stays alone, the parts on either
/// side of its middle may be joined.
///
/// Mass, momentum, initial volume, the domains' volume, sum V0 tau, sum m x and sum V0 det F are kept to round-off. The
/// merged particle lies in the centre of mass; its domain has the proportions of the group's second moments and the
/// domains' volume. F is the mean, scaled to the right determinant; stiffness and stress are means over the initial
/// volume; the elastic strain is the mean over V0 E, with which Hencky's law holds for the merged stress, since
/// Poisson's ratio is the layer's. A mean of stresses inside a convex yield surface lies inside it, and no surface here
/// depends on E. The group's smallest number is kept. No communication but the sums of the result.
template <int dim>
MergeResult merge_particles(ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh, unsigned int points_per_axis,
                            const std::function<bool(const dealii::Point<dim>&)>& keep, double energy_tolerance = 0.05);
} // namespace kedge
