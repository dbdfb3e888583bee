// A few unknowns beside many others: dense columns and rows that border a sparse matrix.
#pragma once

#include <Eigen/Core>
#include <kedge/base/tpetra.h>

namespace kedge
{
/// The system [A C; B^T R] [x; y] = [b; c]. Its unknowns y are few, and every rank knows them. C and B have one column
/// per unknown in y, on the row map of A. Without columns the border is empty.
struct Border
{
  Teuchos::RCP<TpetraMultiVector> columns; ///< C
  Teuchos::RCP<TpetraMultiVector> rows;    ///< B
  Eigen::MatrixXd corner;                  ///< R

  bool empty() const { return corner.size() == 0; }
};

/// B^T x, the same on all ranks. Collective.
Eigen::VectorXd multiply_rows(const Border& border, const TpetraMultiVector& x);

/// x += factor * C y
void add_columns(const Border& border, double factor, const Eigen::VectorXd& y, TpetraMultiVector& x);
} // namespace kedge
