// The increments of free rigid points among the unknowns of a step.
#pragma once

#include <kedge/assembly/contact_border.h>
#include <kedge/bodies/rigid_balance.h>
#include <kedge/contact/contact.h>

namespace kedge
{
/// Unknowns x of a step: the nodal increments u and, behind them on the first rank, the increments y of the free rigid
/// dofs. So Newton's method sees one vector, and every sum over it counts y once.
class RigidUnknowns
{
public:
  /// `active`: whether free dofs are unknowns in this stage at all.
  RigidUnknowns(const RigidSystems& bodies, bool active, const Teuchos::RCP<const TpetraMap>& nodal_map);

  bool empty() const { return dofs.empty(); }
  const Teuchos::RCP<const TpetraMap>& map() const { return all_map; }

  /// The nodal part of x, which shares its memory.
  Teuchos::RCP<const TpetraVector> nodal(const TpetraVector& x) const { return x.offsetView(nodal_map, 0); }
  Teuchos::RCP<TpetraVector> nodal(TpetraVector& x) const { return x.offsetViewNonConst(nodal_map, 0); }

  /// The rigid part of x, on all ranks. Collective.
  Eigen::VectorXd rigid(const TpetraVector& x) const;
  void set_rigid(TpetraVector& x, const Eigen::VectorXd& y) const;

  /// The free dofs of the increments of all points, and the increments with other values there.
  Eigen::VectorXd pick(const std::vector<Vector6>& increments) const;
  std::vector<Vector6> fill(std::vector<Vector6> increments, const Eigen::VectorXd& y) const;

  /// How the bodies move while each free dof grows.
  std::vector<RigidRate> rates(const std::vector<Vector6>& increments) const;

  /// What the residual of each free dof is compared with: the weight (N) of its point, for moments times the lever (m).
  Eigen::VectorXd scale(const std::vector<double>& weights, const std::vector<double>& levers) const;
  /// The same by what acts on each dof: the sizes of the terms of its balance, for moments also the forces (N) on its
  /// point times the lever (m) of that point. So a light body does not hang in the air because another one is heavy.
  Eigen::VectorXd scale(const RigidBalance& balance, const std::vector<double>& forces,
                        const std::vector<double>& levers) const;
  /// Norm of the residuals over their scale. What may be round-off does not count.
  double measure(const RigidBalance& balance, const Eigen::VectorXd& scale) const;

  /// How y couples with u and with itself at the present increments: derivatives of the residuals (internal forces less
  /// contact forces at the last evaluation; the bodies' balance). Collective.
  template <int dim>
  Border border(const RigidBalance& balance, const Contact<dim>& contact, const std::vector<Vector6>& increments,
                const System& system) const;

  /// Springs (`per_weight`, 1/m, times the weight of the point, N; about an axis times the square of its lever, m)
  /// against every increment of y, in the tangent alone.
  void hold(Border& border, double per_weight, const std::vector<double>& weights,
            const std::vector<double>& levers) const;

private:
  std::vector<FreeDof> dofs;
  Teuchos::RCP<const TpetraMap> nodal_map, all_map;
};
} // namespace kedge
