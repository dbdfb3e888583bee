// What the contact forces of the last evaluation exert on the bodies, and its derivatives.
#include <Eigen/Geometry>
#include <cmath>
#include <kedge/contact_forces/evaluation.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;

/// Calls work(pair, surface) for every pair that acts.
template <typename Work> struct ForActingPairs
{
  ContactArrays contact;
  SurfaceMotions surfaces;
  Work work;

  KEDGE_FUNCTION void operator()(const std::size_t k) const
  {
    const unsigned int i = contact.points.acting(k);
    for (unsigned int pair = contact.pair_begin(i); pair < contact.pair_begin(i + 1); ++pair)
      if (contact.pairs(pair).active)
        work(contact.pairs(pair), surfaces(contact.pairs(pair).key.surface));
  }
};

template <typename Work>
void for_acting_pairs(const char* name, const ContactArrays& contact, const SurfaceMotions& surfaces, const Work& work)
{
  Kokkos::parallel_for(name, Policy(0, contact.points.n_acting), ForActingPairs<Work>{contact, surfaces, work});
}

/// Minus force and moment about the body's place.
struct AddLoad
{
  View<double*> loads;

  KEDGE_FUNCTION void operator()(const ContactPair& pair, const SurfaceMotion& surface) const
  {
    const Eigen::Vector3d moment = (pair.position - surface.now.position).cross(pair.force);
    for (int d = 0; d < 3; ++d)
    {
      add_to(loads(6 * surface.rigid_point + d), -pair.force[d]);
      add_to(loads(6 * surface.rigid_point + 3 + d), -moment[d]);
    }
  }
};

/// Velocity and spin of a body, world axes.
struct BodyRate
{
  Eigen::Vector3d v, w;

  KEDGE_FUNCTION Eigen::Vector3d of(const Eigen::Vector3d& x, const SurfaceMotion& surface) const
  {
    return v + w.cross(x - surface.now.position);
  }
};

/// How the force on the soil changes while the body moves.
///
/// The contact law lives in the body's frame: the force turns with the body and depends on where the soil point is in
/// that frame alone, and on the path of the body, with which its reference gap fades. With K = d f / d x, r the arm, v
/// the velocity and w the spin, f changes by w x f - K (v + w x r), and with the reference gap by less what it does
/// with the gap.
KEDGE_FUNCTION Eigen::Vector3d force_rate(const ContactPair& pair, const SurfaceMotion& surface, const BodyRate& rate)
{
  const double reference_rate = pair.fading.dot(rate.of(pair.carried, surface));
  return rate.w.cross(pair.force) - pair.tangent * rate.of(pair.position, surface) - reference_rate * pair.by_gap;
}

/// Column j of the derivative of -(f, r x f) by velocity and spin, r changing with the body, too: 36 numbers for each
/// rigid point, column by column.
struct AddLoadTangent
{
  View<double*> tangents;

  KEDGE_FUNCTION void operator()(const ContactPair& pair, const SurfaceMotion& surface) const
  {
    for (int j = 0; j < 6; ++j)
    {
      BodyRate rate{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
      (j < 3 ? rate.v[j] : rate.w[j - 3]) = 1.;
      const Eigen::Vector3d force = force_rate(pair, surface, rate);
      const Eigen::Vector3d moment = (pair.position - surface.now.position).cross(force) - rate.v.cross(pair.force);
      for (int d = 0; d < 3; ++d)
      {
        add_to(tangents(36 * surface.rigid_point + 6 * j + d), -force[d]);
        add_to(tangents(36 * surface.rigid_point + 6 * j + 3 + d), -moment[d]);
      }
    }
  }
};

/// The sizes of the forces, at the nodes.
struct AddSizes
{
  PointForces points;
  unsigned int dim;
  View<double*> sizes;

  KEDGE_FUNCTION void operator()(const ContactPair& pair, const SurfaceMotion&) const
  {
    const double size = std::sqrt(pair.force.squaredNorm());
    for (unsigned int v = points.begin(pair.point); v < points.begin(pair.point + 1); ++v)
      add_to(sizes(static_cast<std::size_t>(dim) * points.nodes(v)), points.weights(v) * size);
  }
};

/// The size of the force, and the part of it that its nodes leave unbalanced.
struct AddUnbalanced
{
  PointForces points;
  unsigned int dim;
  View<double*> share, sums;

  KEDGE_FUNCTION void operator()(const ContactPair& pair, const SurfaceMotion& surface) const
  {
    double mean = 0.;
    for (unsigned int v = points.begin(pair.point); v < points.begin(pair.point + 1); ++v)
      mean += points.weights(v) * share(static_cast<std::size_t>(dim) * points.nodes(v));
    const double size = std::sqrt(pair.force.squaredNorm());
    add_to(sums(2 * surface.rigid_point), size);
    add_to(sums(2 * surface.rigid_point + 1), size * mean);
  }
};

template <int dim> struct AddCoupling
{
  PointForces points;
  unsigned int rigid_point;
  BodyRate rate;
  double factor;
  View<double*> by_body, by_soil;

  KEDGE_FUNCTION void operator()(const ContactPair& pair, const SurfaceMotion& surface) const
  {
    if (surface.rigid_point != rigid_point)
      return;
    const Eigen::Vector3d force = force_rate(pair, surface, rate);
    const Eigen::Vector3d power = rate.w.cross(pair.force) - pair.tangent.transpose() * rate.of(pair.position, surface);
    for (unsigned int v = points.begin(pair.point); v < points.begin(pair.point + 1); ++v)
      for (int d = 0; d < dim; ++d)
      {
        const std::size_t dof = static_cast<std::size_t>(dim) * points.nodes(v) + d;
        add_to(by_body(dof), factor * points.weights(v) * force[world_axis(dim, d)]);
        add_to(by_soil(dof), factor * points.weights(v) * power[world_axis(dim, d)]);
      }
  }
};
} // namespace

BodyLoads contact_loads(const ContactArrays& contact, const SurfaceMotions& surfaces, const std::size_t n_points)
{
  const View<double*> sums("contact loads", 6 * n_points);
  for_acting_pairs("contact loads", contact, surfaces, AddLoad{sums});
  const auto host = copy_to_host(sums);
  BodyLoads loads;
  for (std::size_t i = 0; i < n_points; ++i)
    loads.push_back(Eigen::Map<const Vector6>(host.data() + 6 * i));
  return loads;
}

BodyTangents contact_load_tangents(const ContactArrays& contact, const SurfaceMotions& surfaces,
                                   const std::size_t n_points)
{
  const View<double*> sums("contact load tangents", 36 * n_points);
  for_acting_pairs("contact load tangents", contact, surfaces, AddLoadTangent{sums});
  const auto host = copy_to_host(sums);
  BodyTangents tangents;
  for (std::size_t i = 0; i < n_points; ++i)
    tangents.push_back(Eigen::Map<const Eigen::Matrix<double, 6, 6>>(host.data() + 36 * i));
  return tangents;
}

void add_contact_sizes(const unsigned int dim, const ContactArrays& contact, const SurfaceMotions& surfaces,
                       const View<double*>& sizes)
{
  for_acting_pairs("sizes of contact forces", contact, surfaces, AddSizes{contact.points, dim, sizes});
}

std::vector<std::array<double, 2>> contact_balance(const unsigned int dim, const ContactArrays& contact,
                                                   const SurfaceMotions& surfaces, const View<double*>& share,
                                                   const std::size_t n_points)
{
  const View<double*> sums("contact balance", 2 * n_points);
  for_acting_pairs("contact balance", contact, surfaces, AddUnbalanced{contact.points, dim, share, sums});
  const auto host = copy_to_host(sums);
  std::vector<std::array<double, 2>> result;
  for (std::size_t i = 0; i < n_points; ++i)
    result.push_back({host(2 * i), host(2 * i + 1)});
  return result;
}

void add_contact_coupling(const unsigned int dim, const ContactArrays& contact, const SurfaceMotions& surfaces,
                          const unsigned int rigid_point, const Vector6& direction, const double factor,
                          const View<double*>& by_body, const View<double*>& by_soil)
{
  const BodyRate rate{direction.head<3>(), direction.tail<3>()};
  if (dim == 2)
    for_acting_pairs("contact coupling", contact, surfaces,
                     AddCoupling<2>{contact.points, rigid_point, rate, factor, by_body, by_soil});
  else
    for_acting_pairs("contact coupling", contact, surfaces,
                     AddCoupling<3>{contact.points, rigid_point, rate, factor, by_body, by_soil});
}
} // namespace kedge
