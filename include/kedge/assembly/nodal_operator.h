// Operators on the owned dofs whose kernels work on the local nodes of each rank.
#pragma once

#include <functional>
#include <kedge/assembly/system.h>

namespace kedge
{
/// y = A x on the free dofs, where the ranks' parts of A add up; constrained dofs neither act nor answer: there y = x.
class NodalOperator : public TpetraOperator
{
public:
  /// Adds this rank's part of A times `direction` to `result`, both with dim entries per local node.
  using Product = std::function<void(const NodalVector& direction, const NodalVector& result)>;

  /// `system` gives the dofs and must outlive the operator.
  NodalOperator(const System& system, Product product);

  Teuchos::RCP<const TpetraMap> getDomainMap() const override { return system.graph().row_map; }
  Teuchos::RCP<const TpetraMap> getRangeMap() const override { return system.graph().row_map; }
  /// Collective.
  void apply(const TpetraMultiVector& x, TpetraMultiVector& y, Teuchos::ETransp mode, double alpha,
             double beta) const override;

private:
  const System& system;
  Product product;
  mutable TpetraVector direction, result; ///< workspace
  NodalVector local_result;
};
} // namespace kedge
