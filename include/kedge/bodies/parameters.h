// What the input says about rigid bodies: points, joints, surfaces. Positions are global, before the offset; in 2-D the
// first two entries of a vector are [x, z].
#pragma once

#include <array>
#include <kedge/bodies/interface.h>
#include <string>
#include <vector>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
/// Condition on one degree of freedom of a rigid point.
struct DofCondition
{
  enum class Kind
  {
    free,
    fixed,
    prescribed
  };
  Kind kind = Kind::fixed;
  double increment = 0.; ///< prescribed: m or rad per uncut step
};

struct PointParameters
{
  std::array<double, 3> position{};       ///< m
  double mass = 0.;                       ///< kg
  std::array<double, 3> inertia{};        ///< principal moments about the point, kg m2; in 2-D only [0], in the plane
  std::array<DofCondition, 6> conditions; ///< x, y, z, about x, y, z; in 2-D [0..2]: x, z, rotation
};

/// Kinds of joints, and the energy of their springs: g = x_1 - x_2 is the distance vector of the anchors, k the
/// stiffness, d_1 and d_2 are the hinge axes, k_r the rotational stiffness, L is a length.
enum class JointType
{
  ball,  ///< "coincidence": k/2 |g|^2
  hinge, ///< "rotation lock": k/2 |g|^2 + k_r/2 |d_1 - d_2|^2 = k/2 |g|^2 + k_r (1 - cos(angle between the axes))
  rod,   ///< "distance lock": k/2 (|g| - L)^2, in tension and compression
  stop   ///< "distance stop": k/2 <|g| - L>^2; the kink is rounded over L / 1000 to keep the stiffness continuous
};

/// Penalty joint between two points. joint_section() says which members each type reads.
struct JointParameters
{
  JointType type = JointType::ball;
  std::array<unsigned int, 2> points{{1, 2}}; ///< numbered from 1
  std::array<double, 3> position_1{}, position_2{}, rotation_centre{}, direction_1{}, direction_2{};
  double distance = 0.;             ///< m
  double angle_limit = 0.;          ///< degrees
  double stiffness = 0.;            ///< N/m
  double rotational_stiffness = 0.; ///< N m
};

/// A closed surface welded to a point: an STL file in 3-D, a polygon in 2-D.
struct SurfaceParameters
{
  std::string stl;                            ///< path, resolved against the folder of the input file
  std::vector<std::array<double, 2>> outline; ///< 2-D only, [x, z]
  double edge_radius = 0.;                    ///< of the outline's convex corners, m; see round_outline
  unsigned int point = 1;                     ///< numbered from 1
  InterfaceParameters interface;              ///< only the values that differ from "contact"
  bool warns_of_sharp_edges = true;
};

struct TrackedNodeParameters
{
  std::array<double, 3> position{};
  unsigned int point = 1;
};

struct SystemParameters
{
  std::vector<PointParameters> points;
  std::vector<JointParameters> joints;
  std::vector<SurfaceParameters> surfaces;
  std::vector<TrackedNodeParameters> tracked_nodes;
  std::array<double, 3> offset{};
};

/// Replaces the conditions of one point for a stage.
struct PointConditionsOverride
{
  unsigned int system = 1, point = 1; ///< numbered from 1
  std::array<DofCondition, 6> conditions;
};

/// Keys of one system of "rigid bodies".
schema::Section<SystemParameters> system_section();
/// Keys of one entry of a stage's "rigid body boundary conditions".
schema::Section<PointConditionsOverride> point_conditions_section();
} // namespace kedge
