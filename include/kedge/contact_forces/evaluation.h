// Contact forces of given motions of soil and bodies, their loads and derivatives, as kernels: what they read and write
// stays on the device.
#pragma once

#include <kedge/base/world_axes.h>
#include <kedge/contact_forces/pair.h>
#include <kedge/contact_forces/point_forces.h>

namespace kedge
{
/// Pairs of this rank. Those of point i are pair_begin[i] .. pair_begin[i + 1]; `pairs` and `rests` may have room for
/// more than there are.
struct ContactArrays
{
  View<ContactPair*> pairs;
  View<ContactRest*> rests;
  View<unsigned int*> pair_begin;
  View<unsigned char*> acts; ///< by point: whether any pair of it did in the last evaluation
  PointForces points;
};

/// Room for the forces of all points and for what evaluations note of them: none acts.
void make_room(ContactArrays& contact);

/// By surface.
using SurfaceMotions = View<SurfaceMotion*>;

/// Forces and trial history of all pairs for given nodal increments (dim per node, m). `keeps_multipliers`: whether
/// pairs propose multipliers of their normal forces.
void evaluate_contact(unsigned int dim, ContactArrays& contact, const SurfaceMotions& surfaces,
                      const View<double*>& increment, bool keeps_multipliers);

/// Displacement of point i in the world's axes, from nodal ones (dim per node, m): of PointForces, or of their arrays
/// on the host. Evaluations call this for many points, so sums stay in registers.
template <int dim, typename Points, typename Nodal>
KEDGE_FUNCTION Eigen::Vector3d point_displacement(const Points& points, const Nodal& nodal, const unsigned int i)
{
  double sum[dim] = {};
  for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
    for (int d = 0; d < dim; ++d)
      sum[d] += points.weights(v) * nodal(static_cast<std::size_t>(dim) * points.nodes(v) + d);
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (int d = 0; d < dim; ++d)
    u[world_axis(dim, d)] = sum[d];
  return u;
}

/// What the pairs that act exert on n_points rigid points, on this rank.
BodyLoads contact_loads(const ContactArrays& contact, const SurfaceMotions& surfaces, std::size_t n_points);

/// Derivatives of these loads by velocity and spin of the rigid point itself, on this rank.
BodyTangents contact_load_tangents(const ContactArrays& contact, const SurfaceMotions& surfaces, std::size_t n_points);

/// Adds the sizes of the contact forces on this rank (N) to entry dim * v of `sizes`.
void add_contact_sizes(unsigned int dim, const ContactArrays& contact, const SurfaceMotions& surfaces,
                       const View<double*>& sizes);

/// Of every rigid point, on this rank: the sum of the sizes of its contact forces and of their unbalanced parts, N.
/// Entry dim * v of `share` is the unbalanced force at a node over the sizes of the contact forces there.
std::vector<std::array<double, 2>> contact_balance(unsigned int dim, const ContactArrays& contact,
                                                   const SurfaceMotions& surfaces, const View<double*>& share,
                                                   std::size_t n_points);

/// Adds to nodal vectors, for a rate `direction` (velocity and spin, world axes) of a rigid point: `factor` times the
/// rate of the forces on the soil to `by_body`, and `factor` times the derivative, by the nodal displacements, of the
/// load's power to `by_soil`.
void add_contact_coupling(unsigned int dim, const ContactArrays& contact, const SurfaceMotions& surfaces,
                          unsigned int rigid_point, const Vector6& direction, double factor,
                          const View<double*>& by_body, const View<double*>& by_soil);

/// Goes back to the multipliers, tangential forces and patches that the step started with.
void reset_multipliers(const ContactArrays& contact, std::size_t n_pairs);
/// Takes the forces of the last evaluation as multipliers; `factor` times what that changes in the normal ones.
void augment(const ContactArrays& contact, std::size_t n_pairs, double factor);
/// Takes the tangential forces of the last evaluation for those from which the next one starts.
void follow_path(const ContactArrays& contact, std::size_t n_pairs);

/// Of the pairs that act on this rank: the largest distance of one that is not bonded from touching, in sizes of its
/// particle; how far its spring is pressed in, likewise; the deepest penetration, m; how many there are.
double largest_excess(const ContactArrays& contact);
double largest_compression(const ContactArrays& contact);
double deepest_penetration(const ContactArrays& contact);
long long count_active(const ContactArrays& contact);

/// Stiffest spring of every point, summed over its pairs, N/m.
View<double*> point_stiffness(const ContactArrays& contact);
} // namespace kedge
