#include "initial_stress.h"
#include "step_limit.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/world_axes.h>
#include <kedge/simulation/layout.h>
#include <kedge/simulation/scene_warnings.h>

namespace kedge
{
namespace
{
constexpr double facets = 0.9; // a rounding of a few facets measures a little less than its radius
constexpr double round_off = 1e-9;
constexpr double much_smaller = 0.75;
constexpr double parallel_within = 0.1;  ///< angle of a hinge's axes, degrees
constexpr double as_drawn_within = 0.01; ///< share of a rod's length
constexpr unsigned int most_points = 4;
/// Strength of the ghost stabilisation from which on it costs accuracy, and below which steps fail; no unit.
constexpr double strongest_ghost = 0.3, weakest_ghost = 1e-3;
constexpr double most_poor = 0.5;
constexpr int samples = 16; // per axis of the part of a body's box that lies in the soil
constexpr double softest = 0.05, stiffest = 200., stiff_if_explicit = 2.; // of contact springs
constexpr double quiet_gamma = 0.75;                                      // see "gamma" in time/parameters.cc

std::string find_sharp_edge(const std::size_t number, const double radius, const double particle)
{
  if (radius >= facets * 0.5 * particle)
    return "";
  return fmt::format(
      "surface {} has convex edges of radius {:.3g} m, sharper than half a material point ({:.3g} m): "
      "soil may slip past them, or its corners catch on them, most of all where an edge begins right above "
      "corners of points; take finer cells there, round them as "
      "kedge geometry --edge-radius does for plates and frusta, or accept it with \"warn of sharp "
      "edges\": \"off\"",
      number, radius, 0.5 * particle);
}

/// Whether a limit by the smaller of friction and adhesion leaves no room for the adhesion.
bool adhesion_is_idle(const InterfaceParameters& interface)
{
  return interface.limit() == TangentialLimit::smaller && interface.adhesion != 0. &&
         interface.friction_coefficient == 0. && !interface.bonded.value_or(false);
}

/// Of a box in world axes that shares nothing with the ground plan of the grid, or in `upwards` axes neither with its
/// height.
template <int dim>
bool lies_beside(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper, const GridLayout<dim>& grid,
                 const bool upwards)
{
  for (int d = 0; d < (upwards ? dim : dim - 1); ++d)
  {
    const unsigned int axis = world_axis(dim, d);
    if (upper[axis] < -round_off || lower[axis] > grid.extent(d) + round_off)
      return true;
  }
  return false;
}

template <int dim> std::string text_of(const GridLayout<dim>& grid)
{
  std::string text;
  for (int d = 0; d < dim; ++d)
    text += fmt::format("{}{:.4g}", d == 0 ? "" : " x ", grid.extent(d));
  return text + " m from the origin";
}

template <int dim>
void add_warnings_about_surfaces(const Input& input, const RigidSystems& bodies, const GridLayout<dim>& grid,
                                 std::vector<std::string>& warnings)
{
  const double particle = grid.finest_size / input.material_points.points_per_axis;
  std::size_t number = 0;
  for (const SystemParameters& system : input.systems)
    for (const SurfaceParameters& parameters : system.surfaces)
    {
      const WeldedSurface& welded = bodies.surfaces[number++];
      const double radius =
          dim == 3 ? welded.surface.sharpest_edge_radius()
                   : sharpest_corner_radius(round_outline(parameters.outline, parameters.edge_radius, "outline"));
      if (const std::string warning = find_sharp_edge(number, radius, particle);
          parameters.warns_of_sharp_edges && !warning.empty())
        warnings.push_back(warning);
      if (adhesion_is_idle(parameters.interface.or_else(input.contact.interface)))
        warnings.push_back(
            fmt::format("the adhesion of surface {} has no effect: the smaller of it and a friction of zero "
                        "is zero; set \"tangential limit\" to \"sum\"",
                        number));
      const auto box = world_bounds(bodies, welded);
      if (lies_beside<dim>(box[0], box[1], grid, false)) // its height may be found by placing it on the soil
        warnings.push_back(fmt::format("surface {} begins beside the grid, which reaches {}: no soil meets it there",
                                       number, text_of<dim>(grid)));
    }
}

/// What a joint does to its bodies as soon as it may; nothing where they begin as it holds them.
std::string find_first_pull(const JointParameters& joint)
{
  using Vector = Eigen::Map<const Eigen::Vector3d>;
  if (joint.type == JointType::hinge)
  {
    const Vector first(joint.direction_1.data()), second(joint.direction_2.data());
    const double angle = std::atan2(first.cross(second).norm(), std::abs(first.dot(second))) * 180. / M_PI;
    return angle > parallel_within ? fmt::format("\"direction 1\" and \"direction 2\" are {:.3g} degrees apart; the "
                                                 "hinge turns its bodies until they are parallel",
                                                 angle)
                                   : "";
  }
  const double apart = (Vector(joint.position_2.data()) - Vector(joint.position_1.data())).norm();
  if (joint.type == JointType::rod && std::abs(apart - joint.distance) > as_drawn_within * joint.distance)
    return fmt::format("its ends are {:.4g} m apart, and \"distance\" is {:.4g} m; the rod pulls or pushes its bodies "
                       "there in the first step",
                       apart, joint.distance);
  return "";
}

void add_warnings_about_joints(const Input& input, std::vector<std::string>& warnings)
{
  for (std::size_t s = 0; s < input.systems.size(); ++s)
    for (std::size_t j = 0; j < input.systems[s].joints.size(); ++j)
      if (const std::string pull = find_first_pull(input.systems[s].joints[j]); !pull.empty())
        warnings.push_back(fmt::format("rigid bodies[{}].constraints[{}]: {}", s, j, pull));
}

/// About choices that experiments have shown to be poor; the manual has the numbers.
void add_warnings_about_choices(const Input& input, const double finest_size, std::vector<std::string>& warnings)
{
  const double ghost = input.solver.ghost_factor.value_or(0.) * finest_size * finest_size;
  if (ghost > strongest_ghost)
    warnings.push_back(
        fmt::format("\"ghost factor\" {:.3g} is {:.2g} over the square of the finest cells, which stiffens "
                    "soil that flows; take 0.02 over it, as without the key",
                    *input.solver.ghost_factor, ghost));
  const auto is_implicit = [](const Stage& stage)
  { return stage.rigid_bodies && stage.stepping.type != StageType::explicit_; };
  if (ghost > 0. && ghost < weakest_ghost && std::any_of(input.stages.begin(), input.stages.end(), is_implicit))
    warnings.push_back(
        fmt::format("\"ghost factor\" {:.3g} is only {:.2g} over the square of the finest cells: soil that flows "
                    "takes more iterations and cut steps; leave the key out for 0.02 over it",
                    *input.solver.ghost_factor, ghost));
  const unsigned int points = input.material_points.points_per_axis;
  if (points == 1)
    warnings.push_back("one material point per axis of a cell leaves empty cells where soil stretches; take 2");
  if (points > most_points)
    warnings.push_back(
        fmt::format("{} material points per axis of a cell cost much and gain nothing; take 2, and finer "
                    "cells",
                    points));
  if (input.solver.poor_factor > most_poor)
    warnings.push_back(
        fmt::format("\"poor factor\" {:.3g} takes cells that soil almost fills for boundary cells, which "
                    "the ghost stabilisation stiffens; take 0.25",
                    input.solver.poor_factor));
  const bool has_joints = std::any_of(input.systems.begin(), input.systems.end(),
                                      [](const SystemParameters& system) { return !system.joints.empty(); });
  for (std::size_t i = 0; i < input.stages.size(); ++i)
  {
    const SteppingParameters& newmark = input.stages[i].stepping;
    if (newmark.type != StageType::dynamic)
      continue;
    const double beta = newmark.beta, gamma = newmark.gamma;
    if (2. * beta < gamma)
      warnings.push_back(fmt::format("stage {}: \"beta\", {:g}, is less than half of \"gamma\", {:g}: Newmark's method "
                                     "lets the fastest waves of the mesh grow unless steps are as short as explicit "
                                     "ones; (gamma + 1/2)^2 / 4, here {:g}, is stable",
                                     i + 1, beta, gamma, 0.25 * (gamma + 0.5) * (gamma + 0.5)));
    if (gamma < quiet_gamma && input.stages[i].rigid_bodies && !input.systems.empty())
      warnings.push_back(
          fmt::format("stage {}: with \"gamma\" {:g} contacts that open and close{} may add energy; 1, with "
                      "\"beta\" 0.5625, does not",
                      i + 1, gamma, has_joints ? ", and stiff joints in steps longer than their periods," : ""));
  }
  const double factor = input.contact.normal_penalty_factor;
  const auto with_bodies = [](const Stage& stage) { return stage.rigid_bodies; };
  const auto is_explicit = [&](const Stage& stage)
  { return with_bodies(stage) && stage.stepping.type == StageType::explicit_; };
  if (std::any_of(input.stages.begin(), input.stages.end(), is_explicit) && factor > stiff_if_explicit)
    warnings.push_back(fmt::format("\"normal penalty factor\" {:.3g} makes contact chatter and time steps short in "
                                   "explicit stages; take 0.25",
                                   factor));
  else if (std::any_of(input.stages.begin(), input.stages.end(), with_bodies) && !input.systems.empty() &&
           (factor < softest || factor > stiffest))
    warnings.push_back(
        fmt::format("\"normal penalty factor\" {:.3g} is far outside of what has been tried, 0.25 to 50: bodies {}",
                    factor, factor < softest ? "sink into the soil" : "find no balance"));
}

/// Whether the block of soil reaches deeper than `allowed` (m) into a body.
template <int dim>
bool holds_soil(const RigidSystems& bodies, const WeldedSurface& welded, const GridLayout<dim>& grid,
                const double allowed)
{
  const auto box = world_bounds(bodies, welded);
  Eigen::Vector3d lower = Eigen::Vector3d::Zero(), step = Eigen::Vector3d::Zero();
  int n[3] = {1, 1, 1};
  for (int d = 0; d < dim; ++d)
  {
    const unsigned int axis = world_axis(dim, d);
    const double top = grid.soil_extent[d] > 0. ? grid.soil_extent[d] : grid.extent(d);
    const double from = std::max(0., box[0][axis]), to = std::min(top, box[1][axis]);
    if (to <= from)
      return false;
    n[axis] = samples;
    step[axis] = (to - from) / samples;
    lower[axis] = from + 0.5 * step[axis];
  }
  const Pose& pose = bodies.points[welded.point].pose;
  for (int i = 0; i < n[0] * n[1] * n[2]; ++i)
  {
    const Eigen::Vector3d at(i % n[0], i / n[0] % n[1], i / n[0] / n[1]);
    const auto closest = welded.surface.closest_point_within(pose.to_body(lower + step.cwiseProduct(at)), 0.);
    if (closest && closest->gap < -allowed)
      return true;
  }
  return false;
}

/// About bodies that begin in soil which nobody takes out. Where they are placed on the soil, they are not in it.
template <int dim>
void add_warning_about_buried_bodies(const Input& input, const RigidSystems& bodies, const GridLayout<dim>& grid,
                                     std::vector<std::string>& warnings)
{
  const auto stage =
      std::find_if(input.stages.begin(), input.stages.end(), [](const Stage& s) { return s.rigid_bodies; });
  if (stage == input.stages.end() || stage->wished_in_place || stage->surface_placement)
    return;
  const double particle = grid.finest_size / input.material_points.points_per_axis;
  std::string numbers;
  for (std::size_t i = 0; i < bodies.surfaces.size(); ++i)
    if (holds_soil<dim>(bodies, bodies.surfaces[i], grid, particle))
      numbers += fmt::format("{}{}", numbers.empty() ? "" : ", ", i + 1);
  if (!numbers.empty())
    warnings.push_back(fmt::format(
        "surface {} begins in the soil, which contact then presses out of it: move it (its coordinates are global, and "
        "\"offset\" shifts it), or bury it with \"wished in place\": \"on\" in stage {}",
        numbers, stage - input.stages.begin() + 1));
}

/// About bodies that stages leave out and later ones find again, with soil in them.
void add_warnings_about_pauses(const Input& input, std::vector<std::string>& warnings)
{
  bool have_acted = false;
  for (std::size_t i = 0; i < input.stages.size(); ++i)
  {
    const Stage& stage = input.stages[i];
    if (stage.rigid_bodies && have_acted && !input.stages[i - 1].rigid_bodies && !stage.wished_in_place)
      warnings.push_back(fmt::format("stage {} has the bodies \"on\" again after \"off\", when nothing kept soil out "
                                     "of them; hold bodies that rest with \"fixed\" conditions instead",
                                     i + 1));
    have_acted = have_acted || (stage.rigid_bodies && !input.systems.empty());
  }
}

/// Where a body goes too far in a step for the cells at it. Throws InputError where no parts of steps are short enough.
template <int dim>
void add_warnings_about_steps(const Input& input, const GridLayout<dim>& grid, std::vector<std::string>& warnings)
{
  RigidSystems bodies = make_rigid_systems(input.systems, dim); // with the conditions of one stage after the other
  for (std::size_t i = 0; i < input.stages.size(); ++i)
  {
    const Stage& stage = input.stages[i];
    apply_conditions(bodies, input.systems, stage.point_conditions, dim);
    const StepLimit limit = find_step_limit(stage, bodies, grid.base_size);
    refuse_long_steps(limit, stage, input.solver.minimum_step_fraction, fmt::format("analysis[{}]", i));
    const double in_cells = limit.in_cells();
    const std::string motion =
        fmt::format("stage {} moves a body by {:.3g} m in a step, {:.2g} of the cells of {:.3g} m at it", i + 1,
                    limit.motion, in_cells, limit.cell_size);
    if (limit.n_parts > 1)
      warnings.push_back(fmt::format("{}: each step is made in {} smaller ones, because \"largest motion\" is {:.3g} "
                                     "cells; resistance grows with the length of the steps",
                                     motion, limit.n_parts, stage.largest_motion));
    else if (stage.rigid_bodies && in_cells > Stage().largest_motion * (1. + round_off))
      warnings.push_back(motion + ": resistance grows with the length of the steps, so make them shorter");
  }
}

template <int dim> std::vector<std::string> find_warnings(const Input& input, const RigidSystems& bodies)
{
  const GridLayout<dim> grid = make_grid_layout<dim>(input);
  std::vector<std::string> warnings;
  if (grid.base_size < much_smaller * input.material_points.element_size)
    warnings.push_back(fmt::format(
        "base cells are {:.4g} m instead of the {:.4g} m requested: the base size must be the smallest size of "
        "any stage, {:.4g} m, times a power of two",
        grid.base_size, input.material_points.element_size, grid.finest_size));
  for (std::string& warning : find_unborne_stress<dim>(input.material_points, grid, std::abs(input.gravity[dim - 1])))
    warnings.push_back(std::move(warning));
  add_warnings_about_choices(input, grid.finest_size, warnings);
  add_warnings_about_joints(input, warnings);
  add_warnings_about_steps<dim>(input, grid, warnings);
  if (std::any_of(input.stages.begin(), input.stages.end(), [](const Stage& stage) { return stage.rigid_bodies; }))
    add_warnings_about_surfaces<dim>(input, bodies, grid, warnings);
  add_warning_about_buried_bodies<dim>(input, bodies, grid, warnings);
  add_warnings_about_pauses(input, warnings);
  for (std::size_t i = 0; i < input.stages.size(); ++i)
  {
    const Stage& stage = input.stages[i];
    if (!stage.rigid_bodies && !stage.adaptivity.boxes.empty())
      warnings.push_back(
          fmt::format("stage {} has its bodies \"off\", and nothing is refined in such stages: its boxes "
                      "have no effect",
                      i + 1));
    for (const RefinedBox& box : stage.adaptivity.boxes)
      if (lies_beside<dim>(to_world_axes(box.min, dim), to_world_axes(box.max, dim), grid, true))
        warnings.push_back(fmt::format("a box of fine cells in stage {} lies outside the grid, which reaches {}", i + 1,
                                       text_of<dim>(grid)));
  }
  return warnings;
}
} // namespace

std::vector<std::string> find_warnings(const Input& input, const RigidSystems& bodies)
{
  return input.dimension == 2 ? find_warnings<2>(input, bodies) : find_warnings<3>(input, bodies);
}
} // namespace kedge
