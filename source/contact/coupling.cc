// What the contact forces of the last evaluation exert on the bodies, and its derivatives.
#include <kedge/base/communication.h>
#include <kedge/contact/contact.h>

namespace kedge
{
template <int dim>
BodyLoads Contact<dim>::loads(const RigidSystems& committed, const std::vector<Vector6>& increments) const
{
  BodyLoads result(committed.points.size(), Vector6::Zero());
  for (const Touch& touch : touching)
  {
    const unsigned int point = committed.surfaces[touch.surface].point;
    const Eigen::Vector3d arm = touch.position - committed.points[point].pose.moved(increments[point]).position;
    result[point].template head<3>() -= touch.force;
    result[point].template tail<3>() -= arm.cross(touch.force);
  }
  if (!result.empty())
    MPI_Allreduce(MPI_IN_PLACE, result.data(), 6 * result.size(), MPI_DOUBLE, MPI_SUM, communicator);
  return result;
}

/// The contact law lives in the body's frame: the force turns with the body and depends on where the soil point is in
/// that frame alone, and on the way of the body, with which its reference gap fades. With K = d f / d x, r the arm and
/// w the spin, a rate of the body changes f by -K v + (K [r] - [f]) w.
template <int dim>
ContactCoupling Contact<dim>::coupling(const RigidSystems& committed, const std::vector<Vector6>& increments) const
{
  ContactCoupling result;
  result.load_by_body.assign(committed.points.size(), Eigen::Matrix<double, 6, 6>::Zero());
  for (const Pair& pair : pairs)
  {
    if (!pair.active)
      continue;
    const unsigned int body = committed.surfaces[pair.key.surface].point;
    const Eigen::Vector3d origin = committed.points[body].pose.moved(increments[body]).position;
    const Eigen::Matrix3d arm = skew(pair.position - origin);
    const Eigen::Matrix3d force = skew(pair.force);
    ContactCoupling::Entry entry;
    entry.contact_point = pair.point;
    entry.rigid_point = body;
    entry.force_by_body << -pair.tangent, pair.tangent * arm - force;
    // the tangent by the normal is the derivative by the gap, and less that the one by the reference gap
    Eigen::Matrix<double, 1, 6> reference_by_body;
    reference_by_body << pair.fading.transpose(), -pair.fading.transpose() * skew(pair.carried - origin);
    entry.force_by_body -= pair.tangent * pair.normal * reference_by_body;
    entry.load_by_soil << -pair.tangent, force - arm * pair.tangent;
    // the load is -(f, r x f), and r changes with the body, too
    Eigen::Matrix<double, 6, 6>& load = result.load_by_body[body];
    load.template topRows<3>() -= entry.force_by_body;
    load.template bottomRows<3>() -= arm * entry.force_by_body;
    load.template bottomLeftCorner<3, 3>() -= force;
    result.entries.push_back(entry);
  }
  if (!result.load_by_body.empty())
    MPI_Allreduce(MPI_IN_PLACE, result.load_by_body.data(), 36 * result.load_by_body.size(), MPI_DOUBLE, MPI_SUM,
                  communicator);
  return result;
}

template BodyLoads Contact<2>::loads(const RigidSystems&, const std::vector<Vector6>&) const;
template BodyLoads Contact<3>::loads(const RigidSystems&, const std::vector<Vector6>&) const;
template ContactCoupling Contact<2>::coupling(const RigidSystems&, const std::vector<Vector6>&) const;
template ContactCoupling Contact<3>::coupling(const RigidSystems&, const std::vector<Vector6>&) const;
} // namespace kedge
