// What points at which forces act on the soil add to nodal forces, products and matrices.
#pragma once

#include <kedge/assembly/nodal_exchange.h>
#include <kedge/contact_forces/point_forces.h>

namespace kedge
{
/// Only the points that act, next to each other in memory: for products, which read them many times.
PointForces gather_acting(const PointForces& points);

/// Adds sign * weight * force of every point to the nodal vector `force` (N).
void add_point_forces(unsigned int dim, const PointForces& points, double sign, const NodalVector& force);

/// Adds weight * |force| (N) of every point to entry dim * v of `size`.
void add_point_force_sizes(unsigned int dim, const PointForces& points, const NodalVector& size);

/// Adds sign * weight * tangent * displacement of every point, for `direction` (m), to `force` (N).
void add_point_products(unsigned int dim, const PointForces& points, double sign, const NodalVector& direction,
                        const NodalVector& force);

/// Adds sign * weight_a weight_b tangent to the blocks (a, b) of every point; what a row has no column for goes to its
/// diagonal. Local.
void add_point_tangents(const PointForces& points, double sign, const NodeGraph& graph, const View<double*>& values);
} // namespace kedge
