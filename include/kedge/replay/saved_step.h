// One linear system of Newton's method in a file, with all that it is computed from: to compute it again on another
// back end, and to time how long that takes.
#pragma once

#include <kedge/assembly/nodal_equations.h>
#include <kedge/solvers/border.h>
#include <string>

namespace kedge
{
/// What a rank has of the system. The forces at its increment are those of `parts` (and inertia), `other` and `points`.
struct SavedStep
{
  unsigned int dim = 3;
  unsigned int n_ranks = 1;
  NodalParts parts;
  unsigned int is_dynamic = 0; ///< 0 or 1
  Newmark newmark;
  NodalMotion motion;
  NodalVector increment; ///< of the local nodes, m
  NodalVector other;     ///< on the owned dofs: weight and what else does not follow from the increment, N
  PointForces points;    ///< of contact, at the increment
  std::vector<double> columns, rows, corner; ///< of the border (solvers/border.h), column by column
  std::vector<double> rigid_side;            ///< the residual of the border's unknowns
  double elastic_share = 0., tolerance = 0.;

  // What the run that saved it has found, on the owned dofs.
  std::vector<double> residual, solution; ///< N; m
  std::vector<double> product;            ///< the derivative times the solution, without the border, N
};

/// The file of this rank. With several ranks each has its own: their numbers end the name.
std::string rank_file(const std::string& path, MPI_Comm communicator);

/// Throw FileError.
void write_step(SavedStep& step, const std::string& path);
SavedStep read_step(const std::string& path, unsigned int copies = 1);

/// Replaces the soil of a step that one rank has saved by `copies` of it, which no force couples but the bodies, all
/// the same: they move as before, and so does the soil. Before what every stress update writes has its room. Throws
/// InputError.
void repeat_step(SavedStep& step, unsigned int copies);

/// The columns or rows of a border on this rank's part of `map`, and back.
std::vector<double> values_of(const TpetraMultiVector& vectors);
Teuchos::RCP<TpetraMultiVector> vectors_of(const std::vector<double>& values, const Teuchos::RCP<const TpetraMap>& map,
                                           std::size_t n_vectors);
} // namespace kedge
