// Sparse factorisation of a whole system on one rank.
#pragma once

#include <kedge/base/tpetra.h>

namespace kedge
{
/// Solves A x = b for all columns of b by a multifrontal LU factorisation (UMFPACK: Davis 2004, doi
/// 10.1145/992200.992206). Rank 0 gathers the rows and does the work. The global numbers of the rows must be 0, 1, ...
/// Returns false if the matrix is singular. Collective.
bool solve_directly(const TpetraMatrix& matrix, const TpetraMultiVector& b, TpetraMultiVector& x);
} // namespace kedge
