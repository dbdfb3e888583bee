#include "input_rules.h"
#include <algorithm>
#include <cmath>
#include <kedge/simulation/layout.h>
#include <set>

namespace kedge
{
using schema::Place;
using schema::shown;

namespace
{
bool has_surface(const Input& input)
{
  return std::any_of(input.systems.begin(), input.systems.end(),
                     [](const SystemParameters& system) { return !system.surfaces.empty(); });
}

bool has_plane(const std::array<TrackPlane, 3>& planes)
{
  return std::any_of(planes.begin(), planes.end(), [](const TrackPlane& plane) { return plane.type.has_value(); });
}

/// Of the material points, m.
double point_spacing(const Input& input)
{
  const double base =
      input.dimension == 3 ? make_grid_layout<3>(input).base_size : make_grid_layout<2>(input).base_size;
  return base / input.material_points.points_per_axis;
}

void check_extent(const Input& input, const Place& root)
{
  if (input.grid_extent == std::array<double, 3>{})
    return;
  std::array<double, 3> soil{};
  const unsigned int vertical = input.dimension - 1;
  std::copy_n(input.material_points.plan_extent.begin(), vertical, soil.begin());
  soil[vertical] = thickness_of(input.material_points.layers);
  for (unsigned int axis = 0; axis <= vertical; ++axis)
    if (input.grid_extent[axis] < soil[axis] * (1. - 1e-9))
      root.key("domain").key("extent").entry(axis).fail("the grid, " + shown(input.grid_extent[axis]) +
                                                            " m, is smaller than the soil, " + shown(soil[axis]) + " m",
                                                        "enlarge it, or leave \"extent\" out");
}

void check_soil(const Input& input, const Place& root)
{
  check_extent(input, root);
  if (input.gravity == std::array<double, 3>{} && input.body_force.empty() && input.solver.measures_by_weight())
    root.key("domain").key("gravity").fail(
        "gravity is zero, but \"tolerance\" measures convergence by the soil's weight",
        "give it a direction, for example [0, 0, -9.81], add a \"body force\", or leave \"tolerance\" out");
  const double spacing = point_spacing(input);
  const Place layers = root.key("material points").key("layers");
  for (std::size_t i = 0; i < input.material_points.layers.size(); ++i)
    if (const double thickness = input.material_points.layers[i].thickness; thickness < spacing * (1. - 1e-9))
      layers.entry(i)
          .key("thickness")
          .fail("the layer, " + shown(thickness) +
                    " m, is thinner than the spacing of the "
                    "material points, " +
                    shown(spacing) + " m",
                "thicken it or reduce \"element size\"");
  for (std::size_t i = 0; i < input.material_points.layers.size(); ++i)
    if (input.material_points.layers[i].material.overburden && !(input.gravity[input.dimension - 1] < 0.))
      layers.entry(i)
          .key("material")
          .key("E overburden")
          .fail("the weight above a material point sets its stiffness, but gravity does not point down",
                "remove it, or let \"gravity\" point down");
  const SteppingParameters& first = input.stages.front().stepping;
  if (input.material_points.K0 && first.type == StageType::static_ && first.load == GravityLoad::ramp)
    root.key("analysis")
        .entry(0)
        .key("load")
        .fail("\"gravity ramp\" starts without weight, but \"initial stress\" already balances the full weight",
              "set it to \"full\" or remove \"initial stress\"");
  if (input.material_points.K0 && input.gravity[input.dimension - 1] > 0.)
    root.key("material points")
        .key("initial stress")
        .fail("\"K0\" is the pressure of soil that its weight holds down, but gravity points up",
              "remove it, or change the sign of \"gravity\"");
  if (!input.material_points.initial_velocity.empty() && first.type == StageType::static_)
    root.key("material points")
        .key("initial velocity")
        .fail("the first stage is static, where nothing has a velocity", "remove it, or begin with a stage in time");
}

void check_sizes(const Stage& stage, const Input& input, const Place& place)
{
  const double base = input.material_points.element_size;
  const auto require_at_most_base = [base](const double size, const Place& key)
  {
    if (size > base)
      key.fail("expected at most the base cell size, " + shown(base) + " m, found " + shown(size),
               "refinement cannot coarsen: lower it");
  };
  const Adaptivity& adaptivity = stage.adaptivity;
  const Place keys = place.key("adaptivity");
  require_at_most_base(adaptivity.element_size, keys.key("element size"));
  require_at_most_base(adaptivity.element_size_in_region, keys.key("element size in region"));
  for (std::size_t i = 0; i < adaptivity.boxes.size(); ++i)
    require_at_most_base(adaptivity.boxes[i].element_size, keys.key("boxes").entry(i).key("element size"));
}

/// Surfaces are what is placed, followed by the window and refined around.
void check_surfaces(const Stage& stage, const Place& place)
{
  const std::string problem = "there is no surface: no system has \"stl files\" (2-D: \"outline\")";
  if (stage.surface_placement)
    place.key("rigid body surface placement").fail(problem, "set it to \"off\" or add a surface");
  if (stage.wished_in_place)
    place.key("wished in place").fail(problem, "set it to \"off\" or add a surface");
  if (stage.adaptivity.type == AdaptivityType::rigid_body_surface)
    place.key("adaptivity").key("type").fail(problem, "set it to \"none\" or \"uniform\", or add a surface");
  for (const auto& [side, planes] : {std::make_pair("min", stage.track.min), std::make_pair("max", stage.track.max)})
    if (has_plane(planes))
      place.key("boundary track").key(side).key("type").fail(problem, "set every axis to \"off\" or add a surface");
}

void check_point_conditions(const Stage& stage, const Input& input, const Place& list)
{
  std::set<std::pair<unsigned int, unsigned int>> seen;
  for (std::size_t i = 0; i < stage.point_conditions.size(); ++i)
  {
    const PointConditionsOverride& entry = stage.point_conditions[i];
    const auto require = [&](const std::string& what, unsigned int number, std::size_t available)
    {
      if (number > available)
        list.entry(i).key(what).fail("there is no " + what + " " + std::to_string(number),
                                     available == 0 ? "add it to the top-level \"rigid bodies\""
                                                    : "they count from 1, so use 1 to " + std::to_string(available));
    };
    require("system", entry.system, input.systems.size());
    require("point", entry.point, input.systems[entry.system - 1].points.size());
    if (!seen.insert({entry.system, entry.point}).second)
      list.entry(i).fail("the conditions of this point are given twice in the stage", "keep one of the two");
  }
}

/// Conditions of a point in a stage: the stage's own, or else those of the point.
const std::array<DofCondition, 6>& conditions_in(const Stage& stage, const Input& input, std::size_t system,
                                                 std::size_t point)
{
  for (const PointConditionsOverride& entry : stage.point_conditions)
    if (entry.system == system + 1 && entry.point == point + 1)
      return entry.conditions;
  return input.systems[system].points[point].conditions;
}

/// Forces alone move a free point of an explicit stage.
void check_inertia(const Stage& stage, const Input& input, const Place& systems)
{
  const char* const axes[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < input.systems.size(); ++i)
    for (std::size_t k = 0; k < input.systems[i].points.size(); ++k)
    {
      const PointParameters& point = input.systems[i].points[k];
      const std::array<DofCondition, 6>& conditions = conditions_in(stage, input, i, k);
      const Place place = systems.entry(i).key("points").entry(k);
      const std::string remedy = "give it some, fix it in the stage, or make the stage \"dynamic\"";
      const unsigned int dim = input.dimension, n_rotations = dim == 3 ? 3 : 1;
      for (unsigned int axis = 0; axis < dim; ++axis)
        if (conditions[axis].kind == DofCondition::Kind::free && !(point.mass > 0.))
          place.key("mass").fail("a point that is free in an explicit stage has no mass", remedy);
      for (unsigned int axis = 0; axis < n_rotations; ++axis)
        if (conditions[dim + axis].kind == DofCondition::Kind::free && !(point.inertia[axis] > 0.))
          place.key("rotational inertia")
              .fail(std::string("a point that may turn about ") + (dim == 3 ? axes[axis] : "y") +
                        " in an explicit stage has no inertia",
                    remedy);
    }
}
/// What is out of balance on bodies is measured by their weight.
void check_weight(const Stage& stage, const Input& input, const Place& systems)
{
  bool any_free = false;
  double mass = 0.;
  for (std::size_t i = 0; i < input.systems.size(); ++i)
    for (std::size_t k = 0; k < input.systems[i].points.size(); ++k)
    {
      const auto& conditions = conditions_in(stage, input, i, k);
      const unsigned int n_dofs = input.dimension == 3 ? 6 : 3;
      mass += input.systems[i].points[k].mass;
      any_free = any_free ||
                 std::any_of(conditions.begin(), conditions.begin() + n_dofs,
                             [](const DofCondition& condition) { return condition.kind == DofCondition::Kind::free; });
    }
  if (any_free && !(mass > 0.))
    systems.entry(0).key("points").entry(0).key("mass").fail(
        "bodies that may move have no mass at all, and their weight is what forces on them are compared with",
        "give them some, or fix them in every stage");
  if (any_free && input.gravity == std::array<double, 3>{} && input.solver.measures_by_weight())
    systems.entry(0).fail(
        "bodies that may move have no weight, for gravity is zero, and their weight is what forces "
        "on them are compared with",
        "give \"domain.gravity\" a direction, fix the bodies in every stage, or measure convergence by the forces "
        "(leave \"tolerance\" out)");
}

/// The key may stand at "contact" and the adhesion at a surface, or the other way round.
void check_tangential_limits(const Input& input, const Place& root)
{
  const auto fail = [](const Place& place)
  {
    place.key("tangential limit")
        .fail("it needs an \"adhesion\" to combine with friction, and there is none",
              "add \"adhesion\" (Pa), or remove the key for friction alone");
  };
  const InterfaceParameters& general = input.contact.interface;
  bool any_adhesion = general.adhesion.has_value();
  for (std::size_t s = 0; s < input.systems.size(); ++s)
    for (std::size_t i = 0; i < input.systems[s].surfaces.size(); ++i)
    {
      const InterfaceParameters& own = input.systems[s].surfaces[i].interface;
      any_adhesion = any_adhesion || own.adhesion;
      if (own.tangential_limit && !own.or_else(general).adhesion)
        fail(root.key("rigid bodies").entry(s).key(input.dimension == 3 ? "stl files" : "outline").entry(i));
    }
  if (general.tangential_limit && !any_adhesion)
    fail(root.key("contact"));
}

} // namespace

void check_consistency(const Input& input, const Place& root)
{
  check_soil(input, root);
  check_tangential_limits(input, root);
  for (std::size_t i = 0; i < input.stages.size(); ++i)
  {
    const Stage& stage = input.stages[i];
    const Place place = root.key("analysis").entry(i);
    check_sizes(stage, input, place);
    if (!stage.rigid_bodies)
      continue;
    if (!has_surface(input))
      check_surfaces(stage, place);
    if (stage.surface_placement && stage.wished_in_place)
      place.key("wished in place")
          .fail("a body cannot be buried from the start and be placed on the surface",
                "switch off one of \"wished in place\" and \"rigid body surface placement\"");
    check_point_conditions(stage, input, place.key("rigid body boundary conditions"));
    if (input.basis == Basis::mpm && has_surface(input))
      root.key("basis").fail(
          "\"mpm\" knows no contact: corners of a point's domain may lie in cells that it does not reach",
          "take \"gimp\", or switch \"rigid bodies\" off in all stages");
    if (stage.stepping.type == StageType::explicit_)
      check_inertia(stage, input, root.key("rigid bodies"));
    else
      check_weight(stage, input, root.key("rigid bodies"));
  }
}
} // namespace kedge
