#include <Teuchos_CommHelpers.hpp>
#include <algorithm>
#include <kedge/steps/rigid_unknowns.h>
#include <utility>

namespace kedge
{
namespace
{
/// Of a vector on the device, so that only these cross to the host and back.
template <typename Array> auto last_entries(const Array& vector, const std::size_t n)
{
  const std::size_t end = vector.extent(0);
  return Kokkos::subview(vector, std::make_pair(end - n, end), 0);
}
} // namespace

RigidUnknowns::RigidUnknowns(const RigidSystems& bodies, const bool active,
                             const Teuchos::RCP<const TpetraMap>& nodal_map_)
    : nodal_map(nodal_map_), all_map(nodal_map_)
{
  if (active)
    dofs = free_dofs(bodies);
  if (dofs.empty())
    return;
  const auto mine = nodal_map->getMyGlobalIndices();
  std::vector<GlobalOrdinal> numbers;
  for (std::size_t i = 0; i < mine.extent(0); ++i)
    numbers.push_back(mine(i));
  if (nodal_map->getComm()->getRank() == 0)
    for (std::size_t i = 0; i < dofs.size(); ++i)
      numbers.push_back(static_cast<GlobalOrdinal>(nodal_map->getGlobalNumElements() + i)); // soil may have none
  all_map = Teuchos::rcp(new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(),
                                       Teuchos::arrayViewFromVector(numbers), 0, nodal_map->getComm()));
}

Eigen::VectorXd RigidUnknowns::rigid(const TpetraVector& x) const
{
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dofs.size());
  if (dofs.empty())
    return y;
  const auto communicator = nodal_map->getComm();
  if (communicator->getRank() == 0)
  {
    const auto last = copy_to_host(last_entries(x.getLocalViewDevice(Tpetra::Access::ReadOnly), dofs.size()));
    std::copy_n(last.data(), dofs.size(), y.data());
  }
  Teuchos::broadcast(*communicator, 0, static_cast<int>(dofs.size()), y.data());
  return y;
}

void RigidUnknowns::set_rigid(TpetraVector& x, const Eigen::VectorXd& y) const
{
  if (dofs.empty() || nodal_map->getComm()->getRank() != 0)
    return;
  const auto last = last_entries(x.getLocalViewDevice(Tpetra::Access::ReadWrite), dofs.size());
  Kokkos::deep_copy(last, Kokkos::View<const double*, Kokkos::HostSpace>(y.data(), dofs.size()));
}

Eigen::VectorXd RigidUnknowns::pick(const std::vector<Vector6>& increments) const
{
  Eigen::VectorXd y(dofs.size());
  for (std::size_t i = 0; i < dofs.size(); ++i)
    y[i] = increments[dofs[i].point][dofs[i].dof];
  return y;
}

std::vector<Vector6> RigidUnknowns::fill(std::vector<Vector6> increments, const Eigen::VectorXd& y) const
{
  for (std::size_t i = 0; i < dofs.size(); ++i)
    increments[dofs[i].point][dofs[i].dof] = y[i];
  return increments;
}

std::vector<RigidRate> RigidUnknowns::rates(const std::vector<Vector6>& increments) const
{
  std::vector<RigidRate> result;
  for (const FreeDof& dof : dofs)
    result.push_back({dof.point, generalised_map(increments[dof.point]).col(dof.dof)});
  return result;
}

template <int dim>
Border RigidUnknowns::border(const RigidBalance& balance, const Contact<dim>& contact,
                             const std::vector<Vector6>& increments, const System& system) const
{
  const std::vector<RigidRate> motion = rates(increments);
  Border border =
      contact_border(contact.arrays_of_last_evaluation(), contact.motions_of_last_evaluation(), motion, system);
  border.corner = balance.tangent;
  const BodyTangents load_tangents = contact.load_tangents();
  for (std::size_t i = 0; i < dofs.size(); ++i)
    for (std::size_t j = 0; j < dofs.size(); ++j)
      if (const unsigned int point = dofs[i].point; point == dofs[j].point)
        border.corner(i, j) -= motion[i].direction.dot(load_tangents[point] * motion[j].direction);
  return border;
}
template Border RigidUnknowns::border(const RigidBalance&, const Contact<2>&, const std::vector<Vector6>&,
                                      const System&) const;
template Border RigidUnknowns::border(const RigidBalance&, const Contact<3>&, const std::vector<Vector6>&,
                                      const System&) const;

void RigidUnknowns::hold(Border& border, const double per_weight, const std::vector<double>& weights,
                         const std::vector<double>& levers) const
{
  for (std::size_t i = 0; i < dofs.size(); ++i)
  {
    const auto [point, dof] = dofs[i];
    const double lever = dof < 3 ? 1. : levers[point];
    border.corner(i, i) += per_weight * weights[point] * lever * lever;
  }
}

Eigen::VectorXd RigidUnknowns::scale(const std::vector<double>& weights, const std::vector<double>& levers) const
{
  Eigen::VectorXd result(dofs.size());
  for (std::size_t i = 0; i < dofs.size(); ++i)
    result[i] = dofs[i].dof < 3 ? weights[dofs[i].point] : weights[dofs[i].point] * levers[dofs[i].point];
  return result;
}

Eigen::VectorXd RigidUnknowns::scale(const RigidBalance& balance, const std::vector<double>& forces,
                                     const std::vector<double>& levers) const
{
  Eigen::VectorXd result = balance.magnitude;
  for (std::size_t i = 0; i < dofs.size(); ++i)
    if (dofs[i].dof >= 3)
      result[i] += forces[dofs[i].point] * levers[dofs[i].point];
  return result;
}

double RigidUnknowns::measure(const RigidBalance& balance, const Eigen::VectorXd& scale) const
{
  double sum = 0.;
  for (std::size_t i = 0; i < dofs.size(); ++i)
    if (const double left = std::abs(balance.residual[i]) - balance.likely_round_off(i); !(left <= 0.))
    {
      // the scale may be from before a joint began to turn the body
      const double share = left / (scale[i] > 0. ? scale[i] : balance.magnitude[i]);
      sum += share * share;
    }
  return std::sqrt(sum);
}
} // namespace kedge
