// One linear system of Newton's method in a file, with all that it is computed from: to compute it again on another
// back end, and to time how long that takes.
#pragma once

#include <kedge/assembly/contact_border.h>
#include <kedge/assembly/nodal_equations.h>
#include <string>

namespace kedge
{
/// Contact of a rank at the increments, to be evaluated again. Motions point into the trees, which follow each other.
struct SavedContact
{
  ContactArrays arrays;
  SurfaceMotions motions;
  View<surface_tree::Node*> nodes;
  View<surface_tree::Facet*> facets;
  View<surface_tree::PartData*> parts;
  View<float*> grids;
  unsigned int keeps_multipliers = 0;   ///< 0 or 1
  std::vector<unsigned int> rate_point; ///< of each unknown of the border (assembly/contact_border.h)
  std::vector<double> rate_direction;   ///< 6 for each

  std::vector<RigidRate> rates() const;
};

/// With copies of all that changes and of the trees.
SavedContact save_contact(const ContactArrays& contact, const SurfaceMotions& motions, bool keeps_multipliers,
                          const std::vector<RigidRate>& rates);

/// Lets motions point into the trees that lie beside them.
void point_into_trees(SavedContact& contact);

/// What a rank has of the system. The forces at its increment are those of `parts` (and inertia), `other` and
/// `contact`.
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
  SavedContact contact;
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
