#include <kedge/geometry/ac14.h>

#include "profile.h"
#include "slab.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>

namespace kedge
{
namespace
{
using Eigen::Vector2d;

/// Least radius of every convex edge, m: half a material point of 0.05 m.
constexpr double least_radius = 0.025;
/// Coarser triangles leave sharp edges on the ridges of the palms, m.
constexpr double largest_size_on_palms = 0.04;

/// Cubic step from 0 at `from` to 1 at `to`. `to` may be smaller than `from`.
double smooth_step(double from, double to, double x)
{
  const double t = std::clamp((x - from) / (to - from), 0., 1.);
  return t * t * (3. - 2. * t);
}

/// Dimensions of an anchor of this kind, m.
void require_length(const std::string& name, const double value)
{
  if (!(value >= 0.) || value > 10.)
    throw InputError(name, fmt::format("{:g} m does not suit this body", value), "use 0 to 10 m");
}

void require_mesh(const PartMesh& mesh)
{
  if (!(mesh.size >= 0.005) || mesh.size > 0.2)
    throw InputError("size", fmt::format("triangles with edges of {:g} m do not suit this body", mesh.size),
                     "use 0.005 to 0.2 m");
  if (mesh.segments == 0)
    throw InputError("edge segments", "a rounding cannot have 0 facets", "use at least 1");
}

/// Outline seen along z: from the back of the crown around its end, along a leaf-shaped fluke, and back into the slot.
std::vector<Vector2d> fluke_outline(const Ac14Fluke& fluke, const PartMesh& mesh)
{
  const double w = fluke.crown_width / 2., s = fluke.slot_width / 2., x = fluke.length / 1.7;
  return make_outline_chain({{{0., 0.}, 0.},
                             {{0., 0.7 * w}, 0.25},
                             {{0.25 * x, w}, 0.2},
                             {{0.6 * x, w}, 0.2},
                             {{0.7 * x, 0.84 * w}, 0.1},
                             {{1.08 * x, 0.79 * w}, 0.5},
                             {{1.42 * x, 0.60 * w}, 0.5},
                             {{fluke.length, s + 0.19}, 0.09},
                             {{fluke.length, s + 0.03}, 0.09},
                             {{fluke.length - 0.25, s}, 0.3},
                             {{fluke.slot_start, s}, 0.95 * s},
                             {{fluke.slot_start, 0.}, 0.}},
                            mesh.size, mesh.segments);
}

/// Outline of foot, tapered shaft and eye, seen along y.
OutlineChains shank_outline(const Ac14Shank& shank, const PartMesh& mesh)
{
  const double end = shank.start + shank.length;
  OutlineChains chains{make_outline_chain({{{shank.start, 0.}, 0.},
                                           {{shank.start, 0.16}, 0.15},
                                           {{shank.pivot + 0.15, 0.24}, 0.5},
                                           {{shank.eye - 0.45, 0.15}, 0.4},
                                           {{shank.eye - 0.15, 0.25}, 0.25},
                                           {{shank.eye + 0.13, 0.25}, 0.25},
                                           {{end, 0.14}, 0.13},
                                           {{end, 0.}, 0.}},
                                          mesh.size, mesh.segments)};
  if (shank.eye_radius > 0.)
  {
    chains.push_back(arc({shank.eye, 0.}, {shank.eye_radius, 0.}, {0., shank.eye_radius}, M_PI, mesh.segments));
    chains.back().back()[1] = 0.; // sin(pi) is not exactly 0
  }
  return chains;
}
} // namespace

TriangleMesh make_ac14_fluke(const Ac14Fluke& fluke, const PartMesh& mesh)
{
  require_mesh(mesh);
  require_length("crown width", fluke.crown_width);
  require_length("slot width", fluke.slot_width);
  require_length("palm height", fluke.palm_height);
  const double w = fluke.crown_width / 2., s = fluke.slot_width / 2., length = fluke.length, x0 = length / 1.7;
  const auto rim_width = [=](const Vector2d& p) { return 0.12 - 0.065 * p[0] / length; };
  const double size = std::min(mesh.size, largest_size_on_palms);
  const Planform planform = triangulate_outline({fluke_outline(fluke, mesh)}, rim_width, size, mesh.segments);

  // The crown is a wedge that thins towards the flukes.
  const auto crown = [=](const Vector2d& p)
  { return smooth_step(0.85 * x0, 0.5 * x0, p[0]) * smooth_step(0., 0.32 * x0, p[0]); };
  const auto flukes = [=](const Vector2d& p)
  {
    const double thinning = 1. - 0.7 * std::max(0., (p[0] - 0.6 * x0) / (length - 0.6 * x0));
    return thinning * (0.65 + 0.35 * smooth_step(0., 0.6 * x0, p[0]));
  };
  // This part is given: a constant under the rim of the crown, and the tripping palms, one ridge per half of the crown.
  const auto chosen = [=](const Vector2d& p)
  {
    const double y = std::abs(p[1]);
    const double along = smooth_step(0., 0.27 * x0, p[0]) * smooth_step(0.56 * x0, 0.28 * x0, p[0]);
    const double across = smooth_step(s - 0.05, s + 0.25, y) * smooth_step(w - 0.08, w - 0.38, y);
    return 0.06 + fluke.palm_height * along * across;
  };
  const Solid solid{fluke.mass / steel_density, fluke.centroid};
  return thicken(planform, fit_half_thickness(planform, chosen, crown, flukes, solid, rim_width, least_radius));
}

TriangleMesh make_ac14_shank(const Ac14Shank& shank, const PartMesh& mesh)
{
  require_mesh(mesh);
  require_length("eye radius", shank.eye_radius);
  const auto rim_width = [](const Vector2d&) { return 0.065; };
  const Planform planform = triangulate_outline(shank_outline(shank, mesh), rim_width, mesh.size, mesh.segments);
  const double middle = shank.start + shank.length / 2.;
  const auto uniform = [](const Vector2d&) { return 1.; };
  const auto taper = [=](const Vector2d& p) { return (middle - p[0]) / shank.length; };
  TriangleMesh part = thicken(planform, fit_half_thickness(
                                            planform, [](const Vector2d&) { return 0.; }, uniform, taper,
                                            {shank.mass / steel_density, shank.centroid}, rim_width, least_radius));
  for (Eigen::Vector3d& x : part.vertices) // its outline lies in x-z
    std::swap(x[1], x[2]);
  for (auto& triangle : part.triangles)
    std::swap(triangle[1], triangle[2]);
  return part;
}
} // namespace kedge
