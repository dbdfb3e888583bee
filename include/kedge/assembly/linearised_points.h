// The derivative of point forces, held by point.
#pragma once

#include <kedge/assembly/nodal_exchange.h>
#include <kedge/contact/point_forces.h>

namespace kedge
{
/// The points of PointForces whose tangent is not zero: point i has the nodes nodes[begin[i] .. begin[i + 1]), their
/// weights and the tangent's dim x dim part (N/m) at 9 i, row by row.
struct LinearisedPoints
{
  View<unsigned int*> begin, nodes;
  View<double*> weights, tangent;

  std::size_t n() const { return begin.extent(0) - 1; }
};

LinearisedPoints linearise_points(const PointForces& points);

/// Adds sign * weight * tangent * displacement of every point, for `direction` (m), to `force` (N).
void add_linearised_points(unsigned int dim, const LinearisedPoints& points, double sign, const NodalVector& direction,
                           const NodalVector& force);
} // namespace kedge
