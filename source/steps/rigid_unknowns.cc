#include <Teuchos_CommHelpers.hpp>
#include <kedge/base/world_axes.h>
#include <kedge/steps/rigid_unknowns.h>

namespace kedge
{
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
      numbers.push_back(nodal_map->getMaxAllGlobalIndex() + 1 + i);
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
    const auto view = x.getLocalViewHost(Tpetra::Access::ReadOnly);
    for (std::size_t i = 0; i < dofs.size(); ++i)
      y[i] = view(view.extent(0) - dofs.size() + i, 0);
  }
  Teuchos::broadcast(*communicator, 0, static_cast<int>(dofs.size()), y.data());
  return y;
}

void RigidUnknowns::set_rigid(TpetraVector& x, const Eigen::VectorXd& y) const
{
  if (dofs.empty() || nodal_map->getComm()->getRank() != 0)
    return;
  const auto view = x.getLocalViewHost(Tpetra::Access::ReadWrite);
  for (std::size_t i = 0; i < dofs.size(); ++i)
    view(view.extent(0) - dofs.size() + i, 0) = y[i];
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

Teuchos::RCP<TpetraMultiVector> RigidUnknowns::collect(const std::vector<NodalVector>& local,
                                                       const System& system) const
{
  const auto owned = Teuchos::rcp(new TpetraMultiVector(nodal_map, local.size()));
  for (std::size_t i = 0; i < local.size(); ++i)
  {
    const auto column = owned->getVectorNonConst(i);
    system.collect(local[i], *column);
    system.zero_constrained(*column);
  }
  return owned;
}

Border RigidUnknowns::border(const RigidBalance& balance, const ContactCoupling& coupling, const PointForces& points,
                             const std::vector<Vector6>& increments, const System& system) const
{
  const unsigned int dim = system.graph().dim;
  std::vector<Eigen::Matrix<double, 6, 6>> map;
  for (const Vector6& increment : increments)
    map.push_back(generalised_map(increment));

  Border border;
  border.corner = balance.tangent;
  for (std::size_t i = 0; i < dofs.size(); ++i)
    for (std::size_t j = 0; j < dofs.size(); ++j)
      if (const unsigned int point = dofs[i].point; point == dofs[j].point)
        border.corner(i, j) -=
            map[point].col(dofs[i].dof).dot(coupling.load_by_body[point] * map[point].col(dofs[j].dof));

  std::vector<NodalVector> columns, rows;
  for (std::size_t i = 0; i < dofs.size(); ++i)
  {
    columns.push_back(system.make_nodal_vector());
    rows.push_back(system.make_nodal_vector());
    const auto column = Kokkos::create_mirror_view(columns[i]), row = Kokkos::create_mirror_view(rows[i]);
    for (const ContactCoupling::Entry& entry : coupling.entries)
    {
      if (entry.rigid_point != dofs[i].point)
        continue;
      const Vector6 direction = map[dofs[i].point].col(dofs[i].dof);
      const Eigen::Vector3d force = entry.force_by_body * direction;
      const Eigen::Vector3d load = entry.load_by_soil.transpose() * direction;
      for (unsigned int v = points.begin[entry.contact_point]; v < points.begin[entry.contact_point + 1]; ++v)
        for (unsigned int c = 0; c < dim; ++c)
        {
          const std::size_t dof = static_cast<std::size_t>(dim) * points.nodes[v] + c;
          column(dof) -= points.weights[v] * force[world_axis(dim, c)];
          row(dof) -= points.weights[v] * load[world_axis(dim, c)];
        }
    }
    Kokkos::deep_copy(columns[i], column);
    Kokkos::deep_copy(rows[i], row);
  }
  border.columns = collect(columns, system);
  border.rows = collect(rows, system);
  return border;
}

void RigidUnknowns::hold(Border& border, const double stiffness, const double lever) const
{
  for (std::size_t i = 0; i < dofs.size(); ++i)
    border.corner(i, i) += dofs[i].dof < 3 ? stiffness : stiffness * lever * lever;
}

double RigidUnknowns::measure(const Eigen::VectorXd& residual, const double weight, const double lever) const
{
  double sum = 0.;
  for (std::size_t i = 0; i < dofs.size(); ++i)
  {
    const double share = residual[i] / (dofs[i].dof < 3 ? weight : weight * lever);
    sum += share * share;
  }
  return std::sqrt(sum);
}
} // namespace kedge
