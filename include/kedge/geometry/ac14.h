// The AC-14 anchor as two parametric bodies. It lies along x and has its planes of symmetry at y = 0 and z = 0. Pivot,
// eye, lengths, masses and centroids come from the drag-anchor tutorial of AMPSSIE and from Bird et al. 2026
// (arXiv:2512.03632); outlines and thicknesses are this project's own (doc/geometry-ac14.md). SI units.
#pragma once

#include <kedge/bodies/surface.h>

namespace kedge
{
constexpr double steel_density = 7850.; ///< kg/m3

/// Mesh of a part of the anchor.
struct PartMesh
{
  double size =
      0.06; ///< edges of the triangles on the flat sides, m; at most 0.04 m on the fluke, whose palms are curved
  unsigned int segments = 4; ///< facets over a quarter turn of roundings
};

/// Crown, palms and flukes in one piece, on both sides of y = 0, with the tips towards +x. The thickness of the crown
/// and of the flukes, which thin towards their tips, follows from mass and centroid.
struct Ac14Fluke
{
  double mass = 6583.2;      ///< kg
  double centroid = 0.62;    ///< along x, m
  double length = 1.7;       ///< from the back of the crown at x = 0 to the tips, m
  double crown_width = 2.2;  ///< across y, m
  double slot_width = 0.46;  ///< between the flukes, m
  double slot_start = 0.62;  ///< x where the slot ends in the crown, m
  double palm_height = 0.42; ///< of the tripping palms over the crown, on either side of z = 0, m
};

/// Shank with foot and eye. It turns about (pivot, y, 0). Its thickness along y follows from mass and centroid.
struct Ac14Shank
{
  double mass = 2116.7;     ///< kg
  double centroid = 1.7592; ///< along x, m
  double start = 0.17;      ///< x of the foot's end, m
  double length = 3.3;      ///< m
  double pivot = 0.489;     ///< x, m
  double eye = 3.0294;      ///< x of the eye's centre, m
  double eye_radius = 0.06; ///< of the hole; 0: none, m
};

/// Both throw InputError if a part with these dimensions cannot be built.
TriangleMesh make_ac14_fluke(const Ac14Fluke& fluke, const PartMesh& mesh);
TriangleMesh make_ac14_shank(const Ac14Shank& shank, const PartMesh& mesh);
} // namespace kedge
