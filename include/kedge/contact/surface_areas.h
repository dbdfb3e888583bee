// The area of surface that each corner in contact stands for.
#pragma once

#include <Eigen/Core>
#include <array>
#include <kedge/bodies/rigid_systems.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// A corner that carries a surface, as plain data; places and lengths in world axes, m.
struct CarryingCorner
{
  Eigen::Vector3d position() const { return {x[0], x[1], x[2]}; }

  std::array<double, 3> x;
  double size;   ///< of its particle
  double weight; ///< what it stands for on a face along the axes, m2 (2-D: m)
};

/// The domain of a particle that may touch, as plain data; along y in plane strain of no account.
struct SoilBox
{
  Eigen::Vector3d centre() const { return {x[0], x[1], x[2]}; }
  Eigen::Vector3d half_width() const { return {half[0], half[1], half[2]}; }

  std::array<double, 3> x, half; ///< m
};

/// Area of the surface (m2; 2-D: m) that each of these corners stands for, so that together they stand for all of it
/// that soil covers. Within a face along the axes of the grid that is the weight of each corner. On an oblique one the
/// boxes make a staircase, and how many of their corners press depends on where its steps lie. The surface is cut into
/// small pieces, and each piece that a box covers is shared by the corners around it on the same side. Corners and
/// boxes may lie on any rank. Collective.
std::vector<double> share_area(const RigidSystems& bodies, const WeldedSurface& welded,
                               const std::vector<CarryingCorner>& corners, const std::vector<SoilBox>& boxes,
                               unsigned int dim, MPI_Comm communicator);
} // namespace kedge
