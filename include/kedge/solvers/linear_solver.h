// Linear systems: GMRES with algebraic multigrid, or a direct factorisation.
#pragma once

#include <functional>
#include <kedge/solvers/border.h>
#include <kedge/solvers/parameters.h>
#include <memory>
#include <string>

namespace kedge
{
struct LinearReport
{
  bool converged = false;
  unsigned int iterations = 0;
  std::string method;           ///< the method that solved the system in the end
  unsigned int escalations = 0; ///< number of stronger methods tried after the first one
  std::string trouble;          ///< why there was no multigrid hierarchy, maybe several lines; else empty
};

/// A linear system as its solvers need it. All parts have the row map of A, with the equations of a node together.
struct LinearSystem
{
  Teuchos::RCP<const TpetraOperator> product;        ///< A x, at any time the present one
  Teuchos::RCP<TpetraMultiVector> near_null_space;   ///< rigid body modes as columns
  std::function<Teuchos::RCP<TpetraMatrix>()> near;  ///< assembles a sparse matrix near the present A; collective
  std::function<Teuchos::RCP<TpetraMatrix>()> whole; ///< assembles the present A, for factorisations; collective
};

/// Solves A x = b for general (unsymmetric) matrices with `block_size` equations per node. The multigrid hierarchy
/// (MueLu, smoothed aggregation) and the sparse factorisation (UMFPACK) live behind this class.
class LinearSolver
{
public:
  LinearSolver(const SolverParameters& parameters, unsigned int block_size);
  ~LinearSolver();

  /// Takes a system with a new structure (new mesh, new active nodes).
  void set_structure(const LinearSystem& system);
  /// The same for a matrix.
  void set_structure(const Teuchos::RCP<TpetraMatrix>& matrix, const Teuchos::RCP<TpetraMultiVector>& near_null_space);

  /// Whether a system of that many equations is factorised at once: then only `whole` is needed.
  bool prefers_direct(std::size_t n_equations) const;

  /// Solves to the given relative residual. After a failed Krylov solve it tries a new hierarchy, one with a stronger
  /// smoother and, if the size permits, a factorisation. The initial value of `x` does not matter. Collective.
  LinearReport solve(const TpetraVector& right_side, TpetraVector& x, double relative_tolerance);

  /// The same for a matrix with a border. The few unknowns y are eliminated: GMRES sees A - C R^-1 B^T, the multigrid
  /// is that of A. GMRES does not converge if R is singular. Collective.
  LinearReport solve(const TpetraVector& right_side, const Eigen::VectorXd& border_right_side, const Border& border,
                     TpetraVector& x, Eigen::VectorXd& y, double relative_tolerance);

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation;
};

/// Solves A x = b for a symmetric, positive (semi-)definite operator to a relative residual, by conjugate gradients
/// scaled with the diagonal. Returns false if they stall. Collective.
bool solve_positive_definite(const Teuchos::RCP<const TpetraOperator>& product, const TpetraVector& diagonal,
                             const TpetraVector& right_side, TpetraVector& x, double relative_tolerance);

/// Prepares a matrix for the smoothers of a preconditioner: raises diagonal entries to a tenth of the other entries of
/// their row, and all by a fiftieth of these. Soil with a non-associated flow rule has rows with smaller and even
/// negative diagonals, on which Gauss-Seidel diverges.
void reinforce_diagonal(TpetraMatrix& matrix);

/// Rigid body modes of the nodes at `position` (dim per node, m): translations, then rotations about the centre. Dofs
/// with `constrained[dof] != 0` get almost zero. `map` has the dofs of these nodes in the same order.
Teuchos::RCP<TpetraMultiVector> make_rigid_body_modes(const Teuchos::RCP<const TpetraMap>& map, unsigned int dim,
                                                      const std::vector<double>& position,
                                                      const std::vector<unsigned char>& constrained);
} // namespace kedge
