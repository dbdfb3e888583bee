// What the input says about the background mesh, its boundary and its window.
#pragma once

#include <array>
#include <optional>
#include <vector>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
enum class FaceCondition
{
  free,
  roller,
  fixed
};

/// Conditions on the six (2-D: four) faces of the grid, by axis.
struct BoundaryConditions
{
  std::array<FaceCondition, 3> min{{FaceCondition::free, FaceCondition::free, FaceCondition::free}};
  std::array<FaceCondition, 3> max{{FaceCondition::free, FaceCondition::free, FaceCondition::free}};
};

enum class AdaptivityType
{
  none,
  uniform,
  rigid_body_surface
};

/// A box in which cells stay fine, wherever the bodies are.
struct RefinedBox
{
  std::array<double, 3> min{}, max{}; ///< m; in 2-D [x, z]
  double element_size = 0.;           ///< m
};

struct Adaptivity
{
  AdaptivityType type = AdaptivityType::none;
  double element_size = 0.;           ///< at the surface, m
  double region = 0.;                 ///< distance from the surface, m; 0: none
  double element_size_in_region = 0.; ///< m
  std::vector<RefinedBox> boxes;
  bool merge = false;
};

/// All cell sizes (m) that are requested besides the base size.
std::vector<double> finer_sizes(const Adaptivity& adaptivity);

/// Edge of the cells at the bodies' surfaces on a grid of base cells, m: a base cell halved until it is small enough.
double cell_size_at_surfaces(const Adaptivity& adaptivity, double base_size);

enum class Advance
{
  positive,
  negative,
  both
};

/// One plane of the moving window.
struct TrackPlane
{
  std::optional<FaceCondition> type; ///< empty: off
  double distance = 0.;              ///< from the bodies' extent, m
  Advance advance = Advance::positive;
  bool remove = false;
};

struct BoundaryTrack
{
  std::array<TrackPlane, 3> min, max;
};

/// Keys of a stage's "boundary conditions", "adaptivity" and "boundary track".
schema::Section<BoundaryConditions> boundary_conditions_section();
schema::Section<Adaptivity> adaptivity_section();
schema::Section<BoundaryTrack> boundary_track_section();
} // namespace kedge
