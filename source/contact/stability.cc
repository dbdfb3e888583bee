// How stiff the contact springs are: what explicit stages need for their stable step.
#include <algorithm>
#include <cmath>
#include <kedge/contact/contact.h>
#include <limits>

namespace kedge
{
template <int dim> View<double*> Contact<dim>::point_stiffness() const
{
  return kedge::point_stiffness(arrays_of_last_evaluation());
}

template <int dim> double Contact<dim>::largest_body_frequency(const RigidSystems& bodies) const
{
  // stiffness, N/m, and stiffness times the square of the arm, N m, of all springs to a point
  std::vector<Eigen::Vector2d> springs(bodies.points.size(), Eigen::Vector2d::Zero());
  const auto host = pairs.read_on_host();
  for (std::size_t k = 0; k < n_pairs; ++k)
  {
    const ContactPair& pair = host(k);
    const unsigned int point = bodies.surfaces[pair.key.surface].point;
    const double stiffness = stiffest(pair.stiffness);
    springs[point] += stiffness * Eigen::Vector2d(1., (pair.start - bodies.points[point].pose.position).squaredNorm());
  }
  if (!springs.empty())
    MPI_Allreduce(MPI_IN_PLACE, springs.data(), 2 * springs.size(), MPI_DOUBLE, MPI_SUM, communicator);
  double largest = 0.;
  for (std::size_t i = 0; i < springs.size(); ++i)
  {
    const RigidPoint& point = bodies.points[i];
    double sum = point.is_free(0) || point.is_free(1) || point.is_free(2) ? springs[i][0] / point.mass : 0.;
    const Eigen::Vector3d about_axes = point.world_inertia().diagonal();
    double least = std::numeric_limits<double>::infinity();
    for (unsigned int axis = 0; axis < 3; ++axis)
      if (point.is_free(3 + axis)) // about two axes it may turn as about one between them
        least = std::isinf(least) ? about_axes[axis] : point.inertia.minCoeff();
    sum += springs[i][1] / least;
    largest = std::max(largest, sum);
  }
  return largest;
}

template View<double*> Contact<2>::point_stiffness() const;
template View<double*> Contact<3>::point_stiffness() const;
template double Contact<2>::largest_body_frequency(const RigidSystems&) const;
template double Contact<3>::largest_body_frequency(const RigidSystems&) const;
} // namespace kedge
