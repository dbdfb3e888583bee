// What is shown of a moment, as grids in the world's axes; plane strain lies in the plane y = 0.
#pragma once

#include <kedge/output/fields.h>
#include <kedge/output/vtu.h>

namespace kedge
{
/// The force of one contact point on the soil. Plain data: it is sent between ranks.
struct ContactForce
{
  double position[3], force[3]; ///< m, N (2-D: per metre)
  unsigned int surface;
};

/// The domains of particles as boxes (2-D: rectangles), the fields as cell data.
template <int dim>
UnstructuredGrid particle_boxes(const std::vector<ParticleView>& particles, const std::vector<ParticleField>& fields);

/// The leaves of this rank that hold a particle, with their "level" of refinement from the base cell.
template <int dim> UnstructuredGrid soil_cells(const BackgroundMesh<dim>& mesh, const ParticleSet<dim>& particles);

/// One vertex per rigid point, the fields as point data.
UnstructuredGrid rigid_points(const RigidSystems& bodies, const std::vector<Vector6>& reactions,
                              const std::vector<BodyField>& fields);

/// One vertex per tracked node: "track" and "body" (numbers from 1) and "velocity" (m/s).
UnstructuredGrid tracked_nodes(const RigidSystems& bodies);

/// All surfaces as they stand: triangles, or the outlines' sides in 2-D. Point data: "velocity" (m/s). Cell data:
/// "body", the number of the rigid point from 1, and "contact force", what the soil exerts per area (N/m2): the forces
/// of the contact points nearest to a triangle, summed and divided by its area (2-D: forces per metre by the side's
/// length).
template <int dim> UnstructuredGrid body_surfaces(const RigidSystems& bodies, const std::vector<ContactForce>& contact);
} // namespace kedge
