// Points at which forces act on the soil, as kernels read them: what they add to forces, products and matrices.
#pragma once

#include <kedge/assembly/nodal_exchange.h>
#include <kedge/contact/point_forces.h>

namespace kedge
{
/// The points of PointForces whose force or tangent is not zero: point i has the nodes nodes[begin[i] .. begin[i + 1]),
/// their weights, the force (N) at 3 i and the tangent (N/m) at 9 i, row by row, of both the first dim along each axis.
struct ActingPoints
{
  View<unsigned int*> begin, nodes;
  View<double*> weights, force, tangent;

  std::size_t n() const { return force.extent(0) / 3; }
};

ActingPoints gather_acting(const PointForces& points);

/// Adds sign * weight * force of every point to the nodal vector `force` (N).
void add_point_forces(unsigned int dim, const ActingPoints& points, double sign, const NodalVector& force);

/// Adds weight * |force| (N) of every point to entry dim * v of `size`.
void add_point_force_sizes(unsigned int dim, const ActingPoints& points, const NodalVector& size);

/// Adds sign * weight * tangent * displacement of every point, for `direction` (m), to `force` (N).
void add_point_products(unsigned int dim, const ActingPoints& points, double sign, const NodalVector& direction,
                        const NodalVector& force);

/// Adds sign * weight_a weight_b tangent to the blocks (a, b) of every point; what a row has no column for goes to its
/// diagonal. Local.
void add_point_tangents(const ActingPoints& points, double sign, const NodeGraph& graph, const View<double*>& values);
} // namespace kedge
