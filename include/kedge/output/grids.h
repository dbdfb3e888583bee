// The state of a run at one moment as grids in world axes. Plane strain lies in the plane y = 0.
#pragma once

#include <kedge/output/fields.h>
#include <kedge/output/vtu.h>

namespace kedge
{
/// The force of one contact point on the soil.
struct ContactForce
{
  Eigen::Vector3d position, force; ///< m, N (2-D: per metre)
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

/// All surfaces at their present position: triangles, or the sides of outlines in 2-D. Point data: "velocity" (m/s).
/// Cell data: "body", the number of the rigid point from 1, and "contact force", the force of the soil per area (N/m2).
/// The latter sums the contact points of all ranks nearest to a triangle and divides by its area (2-D: force per metre
/// by the length of the side); it is complete on rank 0 only. Collective.
template <int dim>
UnstructuredGrid body_surfaces(const RigidSystems& bodies, const std::vector<ContactForce>& contact,
                               MPI_Comm communicator);

/// The grids of all ranks, which have the same arrays, as one; on rank 0 only. Collective.
UnstructuredGrid gather_grid(UnstructuredGrid mine, MPI_Comm communicator);
} // namespace kedge
