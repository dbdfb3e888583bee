// All rigid bodies of a scene: points, joints between the points, and surfaces and tracked nodes welded to points.
#pragma once

#include <Eigen/Geometry>
#include <kedge/bodies/joints.h>
#include <kedge/bodies/rigid_body.h>
#include <kedge/bodies/surface.h>
#include <vector>

namespace kedge
{
/// A closed surface in the frame of the point it is welded to.
struct WeldedSurface
{
  Surface surface;
  unsigned int point; ///< from 0, over all systems
  /// Only the values that differ from "contact".
  InterfaceParameters interface = {};
};

struct TrackedNode
{
  Eigen::Vector3d position; ///< in the frame of its point, m
  unsigned int point;       ///< from 0, over all systems
};

struct RigidSystems
{
  std::vector<RigidPoint> points;
  std::vector<unsigned int> first_point; ///< of each system
  std::vector<Joint> joints;
  std::vector<WeldedSurface> surfaces;
  std::vector<TrackedNode> tracked;

  bool empty() const { return points.empty(); }
};

/// Reads the surfaces and places everything as the input says. Throws InputError.
RigidSystems make_rigid_systems(const std::vector<SystemParameters>& parameters, unsigned int dim);

/// Gives all points the conditions of the input, then replaces those that the stage overrides.
void apply_conditions(RigidSystems& systems, const std::vector<SystemParameters>& parameters,
                      const std::vector<PointConditionsOverride>& overrides, unsigned int dim);

/// Axis-aligned bounds of all surfaces at their present position, m; empty (min > max) without surfaces.
std::array<Eigen::Vector3d, 2> world_bounds(const RigidSystems& systems);
/// The same for one surface.
std::array<Eigen::Vector3d, 2> world_bounds(const RigidSystems& systems, const WeldedSurface& welded);

/// Half of the diagonal of these bounds for the surfaces of each point in the axes of the analysis, m; 0 for points
/// without one. In plane strain the extent across the plane does not count.
std::vector<double> levers_of_points(const RigidSystems& systems, unsigned int dim);

/// What joints hold together, to be measured by itself: bodies elsewhere change nothing of it. In plane strain lengths
/// are those within the plane.
struct SystemSize
{
  double extent = 0.;    ///< diagonal of the bounds of all surfaces, m; 0 without surfaces
  double farthest = 0.;  ///< largest distance of a surface from the rigid point that moves it, m
  double free_mass = 0.; ///< of the points that have a free dof, kg
  double lever = 0.;     ///< largest of theirs by levers_of_points(), without a surface the radius of gyration, m
};
std::vector<SystemSize> sizes_of_systems(const RigidSystems& systems, unsigned int dim);

/// The system of a point; both are numbered from 0, points over all systems. Where no systems are told there is one.
unsigned int system_of(const RigidSystems& systems, unsigned int point);

/// Largest distance between where two increments of rigid points take a surface, m, by rigid point.
std::vector<double> farthest_apart(const RigidSystems& systems, const std::vector<Vector6>& increments,
                                   const std::vector<Vector6>& others);

/// Farthest that any point of a surface goes in a requested step by what its rigid point is prescribed, m.
double largest_prescribed_motion(const RigidSystems& systems);

/// Whether any surface at its present position is at most `distance` (m) from the closed box between two corners in
/// world axes. A surface that crosses the box is at distance zero. Exact up to round-off.
bool surface_comes_within(const RigidSystems& systems, const Eigen::Vector3d& lower, const Eigen::Vector3d& upper,
                          double distance);

/// Moves all bodies along `axis` by one amount so that their lowest surface point lies at `height` (m).
void place_on_surface(RigidSystems& systems, unsigned int axis, double height);

/// True where x lies inside any of the bodies.
bool is_inside(const RigidSystems& systems, const Eigen::Vector3d& x);
} // namespace kedge
