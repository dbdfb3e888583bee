// Linear systems: GMRES with algebraic multigrid, or a direct factorisation.
#pragma once

#include <kedge/solvers/border.h>
#include <kedge/solvers/near_matrix.h>
#include <kedge/solvers/parameters.h>
#include <memory>
#include <string>

namespace kedge
{
struct LinearReport
{
  bool converged = false;
  unsigned int iterations = 0;
  std::string method;           ///< what finally solved it
  unsigned int escalations = 0; ///< harder methods tried after the first
};

/// Solves A x = b for general (unsymmetric) matrices with `block_size` equations per node. The multigrid hierarchy
/// (MueLu, smoothed aggregation) and the sparse factorisation (UMFPACK) live behind this class.
class LinearSolver
{
public:
  LinearSolver(const SolverParameters& parameters, unsigned int block_size);
  ~LinearSolver();

  /// A new sparsity (new mesh, new active nodes). `near_null_space`: rigid body modes as columns, on the row map. Where
  /// the places of the owned nodes are given, the preconditioner is built from the NearMatrix. Collective.
  void set_structure(const Teuchos::RCP<TpetraMatrix>& matrix, const Teuchos::RCP<TpetraMultiVector>& near_null_space,
                     const NodePlaces& places = {});

  /// Solves to the given relative residual. A failed Krylov solve is repeated with a fresh hierarchy and, where the
  /// size allows it, by a factorisation. `x` need not be set. Collective.
  LinearReport solve(const TpetraVector& right_side, TpetraVector& x, double relative_tolerance);

  /// The same for a matrix with a border. The few unknowns y are eliminated, so GMRES sees A - C R^-1 B^T and the
  /// multigrid is still that of A. Does not converge where R is singular. Collective.
  LinearReport solve(const TpetraVector& right_side, const Eigen::VectorXd& border_right_side, const Border& border,
                     TpetraVector& x, Eigen::VectorXd& y, double relative_tolerance);

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

/// Solves A x = b for a symmetric, positive (semi-)definite matrix by conjugate gradients scaled with its diagonal, to
/// a relative residual. False where they stall. Collective.
bool solve_positive_definite(const Teuchos::RCP<const TpetraMatrix>& matrix, const TpetraVector& right_side,
                             TpetraVector& x, double relative_tolerance);

/// Rigid body modes of nodes at `position` (dim per node, m): translations, then rotations about the centre. Dofs
/// with `constrained[dof] != 0` get next to zero. Sizes follow the row map of `map`.
Teuchos::RCP<TpetraMultiVector> make_rigid_body_modes(const Teuchos::RCP<const TpetraMap>& map, unsigned int dim,
                                                      const std::vector<double>& position,
                                                      const std::vector<unsigned char>& constrained);
} // namespace kedge
