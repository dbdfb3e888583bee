// Splitting of the particles that are too wide for their cells.
#pragma once

#include <kedge/materials/material.h>
#include <kedge/particles/particle_set.h>

namespace kedge
{
/// A particle that became two for every axis along which it was cut.
template <int dim> struct Split
{
  long long parent;
  std::array<long long, 1u << dim> children;  ///< by octant: bit d is set in the upper half along axis d
  std::array<double, dim> centre, half_width; ///< of the parent, m
  unsigned int axes;                          ///< bit d is set if it was cut along axis d

  bool is_cut_along(const unsigned int axis) const { return (axes >> axis) & 1u; }
  /// An octant without a child has a bit of an axis that was not cut.
  bool has_child(const unsigned int octant) const { return (octant & axes) == octant; }
  unsigned int n_children() const
  {
    unsigned int n = 1;
    for (unsigned int d = 0; d < dim; ++d)
      n *= is_cut_along(d) ? 2u : 1u;
    return n;
  }
};

/// The cells before they were refined, and the materials of the layers: what the children of a cell's particles need to
/// follow the stress in it. The ranks must still hold all parts of their former cells.
template <int dim> struct FormerCells
{
  const LeafTable<dim>& leaves;
  const Materials& materials;
};

/// Cuts every particle in two along each axis where its domain is wider than sqrt(2) * cell size / points_per_axis,
/// again and again until all fit. The factor lies midway, in steps of halving, between a particle that fits and one
/// that is twice as wide. Mass, momentum, volume and sum V0 tau are kept to round-off: a child has its share of the
/// parent's mass, volume and domain, and a copy of everything else, so a material point keeps its F, stiffness and
/// layer.
///
/// Where cells have just been refined, the stress of children follows the linear field through the stresses of the
/// former cell, as far as their law bears it: copies would make steps of it, and soil at rest would not stay so.
///
/// The first child keeps the parent's number; the others are numbered from the next free number on, by the order of
/// their parents' numbers, whichever ranks hold them. A child whose centre would lie outside the grid is moved just
/// inside. Children end up on the rank that owns their cell, however far that is.
///
/// Returns the splits of the particles that this rank held, also of those children that other ranks had to split
/// again; a parent precedes its children. Collective; one reduction where nothing is to split.
template <int dim>
std::vector<Split<dim>> split_particles(ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh,
                                        unsigned int points_per_axis,
                                        const std::optional<FormerCells<dim>>& former = {});

/// Whether there is a particle to split on any rank. A scan and one reduction.
template <int dim>
bool any_too_wide(const ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh, unsigned int points_per_axis);
} // namespace kedge
