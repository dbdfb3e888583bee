// Algebraic multigrid for nodes with several equations each.
#pragma once

#include <kedge/base/tpetra.h>
#include <memory>
#include <string>

namespace kedge
{
/// One cycle of multigrid from zero, as a preconditioner. The finest level, which takes most of the time, is Kedge's:
/// BlockGaussSeidel smooths, Coarsening leads to the next level. MueLu has all others (smoothed aggregation, where
/// `strong`; else plain).
class Multigrid : public TpetraOperator
{
public:
  /// `near_null_space`: rigid body modes as columns, on the row map. `strong` takes longer and serves where the other
  /// fails. Null if no hierarchy is found; then `trouble` says what MueLu said. Collective.
  static Teuchos::RCP<Multigrid> build(const Teuchos::RCP<TpetraMatrix>& matrix,
                                       const Teuchos::RCP<TpetraMultiVector>& near_null_space, unsigned int block_size,
                                       bool strong, std::string& trouble);
  ~Multigrid() override;

  /// Follows new values of the matrix, with the aggregates of before. False if that fails. Collective.
  bool renew();

  Teuchos::RCP<const TpetraMap> getDomainMap() const override;
  Teuchos::RCP<const TpetraMap> getRangeMap() const override;
  /// y = cycle(x); alpha and beta must be 1 and 0. Collective.
  void apply(const TpetraMultiVector& x, TpetraMultiVector& y, Teuchos::ETransp mode, double alpha,
             double beta) const override;

private:
  struct Implementation;
  explicit Multigrid(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation;
};
} // namespace kedge
