// How stiff the contact springs are: what explicit stages need for their stable step.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <kedge/contact/contact.h>

namespace kedge
{
template <int dim> View<double*> Contact<dim>::point_stiffness() const
{
  return kedge::point_stiffness(arrays_of_last_evaluation());
}

namespace
{
/// About any axis that the point may turn about, kg m2; 0 where it may not turn.
double least_inertia(const RigidPoint& point)
{
  std::vector<unsigned int> axes;
  for (unsigned int axis = 0; axis < 3; ++axis)
    if (point.is_free(3 + axis))
      axes.push_back(axis);
  if (axes.empty())
    return 0.;
  const Eigen::Matrix3d inertia = point.world_inertia();
  Eigen::MatrixXd block(axes.size(), axes.size());
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t j = 0; j < axes.size(); ++j)
      block(i, j) = inertia(axes[i], axes[j]);
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(block, Eigen::EigenvaluesOnly).eigenvalues()[0];
}
} // namespace

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
    if (const double least = least_inertia(point); least > 0.)
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
