// What every step sets up first: basis, numbering, constraints, contact pairs.
#pragma once

#include <kedge/assembly/node_graph.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/basis/cell_groups.h>
#include <kedge/basis/elements.h>
#include <kedge/basis/ghost_faces.h>
#include <kedge/steps/trial_step.h>

namespace kedge
{
/// Overlap of the particles with the cells, and the nodes that carry unknowns.
struct StepBasis
{
  ActiveNodes nodes;
  StencilSet stencils;
  CellGroups cells;       ///< of F-bar; empty without it
  Elements elements;      ///< only where they were asked for
  GhostFaces ghost_faces; ///< none where the factors are zero

  /// Bytes that the particles of this rank take of it.
  double bytes() const;
};

/// Strength of the ghost stabilisation of an input that names no factor: enough for slivers, and clay does not notice
/// it.
constexpr double automatic_ghost_strength = 0.02;

GhostFactors ghost_factors(const SolverParameters& solver);

/// `with_elements`: for implicit steps. Collective.
template <int dim>
StepBasis make_step_basis(const StepContext<dim>& context, const GhostFactors& ghost_factors, bool with_elements);

/// As the assembly knows the nodes.
NodeNumbering numbering_of(const ActiveNodes& nodes);

/// Marks the dofs (dim per local node) that the conditions on the faces of the grid or of the window hold.
template <int dim>
std::vector<unsigned char> find_constrained_dofs(const StepContext<dim>& context, const ActiveNodes& nodes);

/// Finds the corners that could touch a body during a whole step. Collective.
template <int dim>
void find_contact_pairs(const StepContext<dim>& context, const ActiveNodes& nodes, const RigidStep& whole);

/// What holds the rigid points: without contact, where the stage has no bodies in it, against their weight alone.
template <int dim>
std::vector<Vector6> find_reactions(const StepContext<dim>& context, const RigidStep& step,
                                    const std::vector<Vector6>& increments, const BodyLoads& loads);
} // namespace kedge
