// The equations of an implicit step on the active nodes: the soil's forces, their derivative, the matrices of
// preconditioner and factorisation. Needs neither a mesh nor bodies.
#pragma once

#include <kedge/assembly/acting_points.h>
#include <kedge/assembly/ghost.h>
#include <kedge/assembly/inertia.h>
#include <kedge/assembly/linearised_force.h>
#include <kedge/assembly/nodal_operator.h>
#include <kedge/base/report.h>
#include <kedge/solvers/linear_solver.h>
#include <memory>

namespace kedge
{
/// What the equations consist of, as plain data.
struct NodalParts
{
  ParticleArrays particles;
  Materials materials;
  StencilSet stencils;
  CellGroups cells;       ///< of F-bar; empty without it
  Elements elements;      ///< only for preconditioners
  GhostFaces ghost_faces; ///< maybe none
  NodeNumbering numbering;
  std::vector<double> position;           ///< of the owned nodes, dim numbers each, m
  std::vector<unsigned char> constrained; ///< dofs of the local nodes
};

template <int dim> class NodalEquations
{
public:
  /// Sets up the sparsity. `factorises`: every system at once; then the matrix of system() is the tangent, else that of
  /// the preconditioner. `is_dynamic`: the equations may have inertia. Collective.
  NodalEquations(NodalParts parts, bool factorises, bool is_dynamic, Timings& timings);

  const System& system() const { return *dofs; }
  const NodalParts& parts() const { return data; }
  /// How this rank's part of the mass couples nodes; empty in static steps.
  const NodeGraph& mass_graph() const { return graph_of_mass; }

  /// At the start of a dynamic step; empty until it is set.
  void set_motion(const NodalMotion& motion_) { start = motion_; }
  const NodalMotion& motion() const { return start; }
  /// Without a time step the equations have no inertia, as at first.
  void set_newmark(const Newmark& newmark_) { newmark = newmark_; }

  /// Adds the forces of soil, ghost faces and inertia (N) for the increments of all local nodes (m) to `force`. Returns
  /// the number of particles of this rank whose increment is not admissible.
  unsigned long add_force(const NodalVector& increment, const NodalVector& force) const;

  /// Takes down the derivative of these forces, less those of `points` (maybe none), at the last add_force(), whose
  /// increment it was. For Newton's damping, yielding particles get at least `elastic_share` of their elastic moduli in
  /// addition.
  void linearise(const NodalVector& increment, const PointForces& points, double elastic_share);

  /// Adds the derivative times `direction` (m) to `result` (N).
  void add_product(const NodalVector& direction, const NodalVector& result) const;
  /// A sparse matrix near the derivative, and the derivative itself, both at the last linearise(). Collective.
  Teuchos::RCP<TpetraMatrix> assemble_near();
  Teuchos::RCP<TpetraMatrix> assemble_whole();

  /// For solvers; it must not outlive these equations. Collective.
  LinearSystem linear_system();

private:
  std::vector<NodeLists> all_couplings() const;
  void finish_matrix(System& into) const;

  NodalParts data;
  bool factorises;
  Timings& timings;
  std::unique_ptr<System> dofs;
  std::unique_ptr<System> whole_system; ///< the tangent for a factorisation after all else has failed
  NodeGraph graph_of_mass;
  NodalMotion start;
  Newmark newmark;
  // of the last linearisation
  double damping = 0.;
  LinearisedForce force_derivative;
  LinearisedGhost ghost_derivative;
  PointForces acting_points;
};
} // namespace kedge
