#include <Teuchos_CommHelpers.hpp>
#include <algorithm>
#include <kedge/base/communication.h>
#include <kedge/base/world_axes.h>
#include <kedge/steps/rigid_unknowns.h>
#include <utility>

namespace kedge
{
namespace
{
/// Sums the contributions of all ranks to the owned dofs: `width` values per local dof. Bodies touch few nodes, so a
/// rank sends what is not zero, in one message to each owner. Collective.
Teuchos::RCP<TpetraMultiVector> collect(const std::vector<double>& local, const std::size_t width, const System& system)
{
  const NodeGraph& graph = system.graph();
  const auto owned = Teuchos::rcp(new TpetraMultiVector(graph.row_map, width));
  {
    const auto view = owned->getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (std::size_t dof = 0; dof < view.extent(0); ++dof)
      for (std::size_t i = 0; i < width; ++i)
        view(dof, i) = local[width * dof + i];
    std::vector<GlobalOrdinal> touched; // of other ranks
    std::vector<std::size_t> at;
    for (std::size_t dof = view.extent(0); dof < local.size() / width; ++dof)
      if (std::any_of(&local[width * dof], &local[width * dof] + width, [](const double value) { return value != 0.; }))
      {
        touched.push_back(graph.column_map->getGlobalElement(dof));
        at.push_back(width * dof);
      }
    std::vector<int> owner(touched.size());
    graph.row_map->getRemoteIndexList(Teuchos::arrayViewFromVector(std::as_const(touched)),
                                      Teuchos::arrayViewFromVector(owner));
    std::vector<std::vector<double>> to_rank(size_of(graph.communicator));
    for (std::size_t k = 0; k < touched.size(); ++k)
    {
      std::vector<double>& message = to_rank[owner[k]];
      message.push_back(static_cast<double>(touched[k]));
      message.insert(message.end(), &local[at[k]], &local[at[k]] + width);
    }
    for (const std::vector<double>& message : exchange_between_ranks(to_rank, graph.communicator))
      for (std::size_t row = 0; row < message.size(); row += 1 + width)
      {
        const auto dof = graph.row_map->getLocalElement(static_cast<GlobalOrdinal>(message[row]));
        for (std::size_t i = 0; i < width; ++i)
          view(dof, i) += message[row + 1 + i];
      }
  }
  for (std::size_t i = 0; i < width; ++i)
    system.zero_constrained(*owned->getVectorNonConst(i));
  return owned;
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

  const std::size_t n = dofs.size(), width = 2 * n; // columns, then rows
  std::vector<double> values(width * dim * system.graph().n_columns, 0.);
  for (std::size_t i = 0; i < n; ++i)
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
          double* const of_dof = values.data() + width * (static_cast<std::size_t>(dim) * points.nodes[v] + c);
          of_dof[i] -= points.weights[v] * force[world_axis(dim, c)];
          of_dof[n + i] -= points.weights[v] * load[world_axis(dim, c)];
        }
    }
  const auto all = collect(values, width, system);
  border.columns = all->subCopy(Teuchos::Range1D(0, n - 1));
  border.rows = all->subCopy(Teuchos::Range1D(n, width - 1));
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
