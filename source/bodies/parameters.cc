#include <cmath>
#include <kedge/bodies/parameters.h>
#include <kedge/bodies/surface.h>
#include <kedge/parameters/section.h>

namespace kedge
{
using namespace schema;

namespace
{
Format<DofCondition> dof_condition()
{
  Format<DofCondition> format;
  format.expects = "\"free\", \"fixed\" or {\"prescribed\": q}";
  format.unit = "m or rad per step";
  format.read = [expects = format.expects](const Json& json, const Place& place)
  {
    using Kind = DofCondition::Kind;
    if (json.is_object())
    {
      Section<DofCondition> moved("A prescribed movement");
      moved.required("prescribed", &DofCondition::increment, number("m or rad per step"), "Movement per uncut step");
      DofCondition condition{Kind::prescribed, 0.};
      moved.read(json, condition, place);
      return condition;
    }
    if (json != "free" && json != "fixed")
      place.expected(expects, shown(json));
    return DofCondition{json == "free" ? Kind::free : Kind::fixed, 0.};
  };
  const Json movement = {{"description", "Movement per uncut step"}, {"type", "number"}};
  format.schema = {{"anyOf",
                    {{{"enum", {"free", "fixed"}}},
                     {{"type", "object"},
                      {"properties", {{"prescribed", movement}, {"comment", Json::object()}}},
                      {"required", Json::array({"prescribed"})},
                      {"additionalProperties", false}}}}};
  return format;
}

Format<std::array<DofCondition, 6>> point_conditions()
{
  return fixed_list<6>(dof_condition(), Layout{6, 3, "[x, y, z, about x, about y, about z]", "[x, z, rotation]"});
}

Section<PointParameters> point_section()
{
  using P = PointParameters;
  Section<P> section("A rigid frame that carries mass");
  section.required("position", &P::position, vector("m"), "Position, usually the centre of mass");
  section.required("mass", &P::mass, number("kg", not_negative()), "Mass");
  section.required("rotational inertia", &P::inertia,
                   fixed_list<3>(number("kg m2", not_negative()), Layout{3, 1, "[xx, yy, zz]", "[in the plane]"}),
                   "Principal moments of inertia about the point");
  section.required("boundary conditions", &P::conditions, point_conditions(),
                   "Condition on each degree of freedom in every stage that does not replace it");
  return section;
}

void check_joint(const JointParameters& joint, const Place& place)
{
  const auto is_zero = [](const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]) == 0.; };
  const bool hinge = joint.type == JointType::hinge;
  if (hinge && place.context().dimension == 2)
    place.key("type").fail("a hinge axis has no meaning in 2-D", "use \"coincidence\", which acts as a hinge in 2-D");
  if (joint.points[0] == joint.points[1])
    place.key("points").fail("both are point " + std::to_string(joint.points[0]), "join two different points");
  if (hinge)
    for (const auto& [name, direction] :
         {std::make_pair("direction 1", joint.direction_1), std::make_pair("direction 2", joint.direction_2)})
      if (is_zero(direction))
        place.key(name).fail("the direction is zero", "give the hinge axis, of any length");
  if (joint.type == JointType::rod && joint.position_1 == joint.position_2)
    place.key("position 2")
        .fail("it is \"position 1\", and a rod between the two has no direction",
              "give the rod's two ends; \"distance\" may differ from theirs");
  if (joint.type == JointType::stop)
    for (const auto& [name, position] :
         {std::make_pair("position 1", joint.position_1), std::make_pair("position 2", joint.position_2)})
      if (position == joint.rotation_centre)
        place.key(name).fail("the anchor lies on the rotation centre, where no angle is defined",
                             "move it away from the centre");
}

Section<JointParameters> joint_section()
{
  using P = JointParameters;
  const std::string ball = "coincidence", hinge = "rotation lock", rod = "distance lock", stop = "distance stop";
  Section<P> section("A penalty joint between two points of the system");
  section.required(
      "type", &P::type,
      choice<JointType>(
          {{ball, JointType::ball}, {hinge, JointType::hinge}, {rod, JointType::rod}, {stop, JointType::stop}}),
      "Ball, hinge, rod, or rope that goes taut at an opening angle");
  section.required("points", &P::points, fixed_list<2>(count(Bounds().at_least(1)), Layout{2, 2, "[a, b]", "[a, b]"}),
                   "The two points, numbered from 1 in their system");
  section.required("stiffness", &P::stiffness, number("N/m", positive()), "Penalty stiffness");
  section.required("position 1", &P::position_1, vector("m"), "Anchor carried by the first point")
      .only_for("type", {ball, rod, stop});
  section.required("position 2", &P::position_2, vector("m"), "Anchor carried by the second point")
      .only_for("type", {ball, rod, stop});
  section.required("rotation centre", &P::rotation_centre, vector("m"), "The pin, or the centre of the opening angle")
      .only_for("type", {hinge, stop});
  section.required("direction 1", &P::direction_1, vector("-"), "Hinge axis carried by the first point")
      .only_for("type", {hinge});
  section.required("direction 2", &P::direction_2, vector("-"), "Hinge axis carried by the second point")
      .only_for("type", {hinge});
  section
      .required("rotational stiffness", &P::rotational_stiffness, number("N m", positive()),
                "Penalty stiffness that keeps the two axes parallel")
      .only_for("type", {hinge});
  section.required("distance", &P::distance, number("m", positive()), "Length of the rod").only_for("type", {rod});
  section
      .required("angle limit", &P::angle_limit, number("degrees", positive().at_most(180.)),
                "Opening angle at which the stop goes taut")
      .only_for("type", {stop});
  section.check(check_joint);
  return section;
}

const char* const which_point = "Point that carries it, numbered from 1 in its system";

void declare_edge_warning(Section<SurfaceParameters>& section)
{
  section.optional("warn of sharp edges", &SurfaceParameters::warns_of_sharp_edges, on_off(),
                   "Warn where the soil at the surface is too coarse for its edges; \"off\" accepts that soil may slip "
                   "past them, or hold them: an edge right above corners of points that its face has pressed meets "
                   "up to four times the resistance, until it has moved on by what it has sunk in");
}

Section<SurfaceParameters> stl_section()
{
  using P = SurfaceParameters;
  Section<P> section("A closed surface welded to a point");
  section.required("stl", &P::stl, existing_file(),
                   "ASCII or binary STL file in global coordinates, relative to the input file");
  section.required("point", &P::point, count(Bounds().at_least(1)), which_point);
  section.include(interface_section(false), &P::interface);
  declare_edge_warning(section);
  section.ignored("mesh cache", "Not read: no volume mesh is needed");
  section.ignored("name", "Not read: a label");
  return section;
}

Section<SurfaceParameters> outline_section()
{
  using P = SurfaceParameters;
  Section<P> section("A closed polygon welded to a point, in 2-D");
  section.required("polygon", &P::outline, list_of(fixed_list<2>(number("m"), Layout{2, 2, "[x, z]", "[x, z]"}), 3),
                   "Corners in order; the last is joined to the first");
  section.optional("edge radius", &P::edge_radius, number("m", not_negative()),
                   "Radius of the arcs that replace convex corners, in chords over at most 22.5 degrees; mass and "
                   "inertia do not follow");
  section.required("point", &P::point, count(Bounds().at_least(1)), which_point);
  section.include(interface_section(false), &P::interface);
  declare_edge_warning(section);
  section.check([](const P& surface, const Place& place)
                { round_outline(surface.outline, surface.edge_radius, place.path()); });
  return section;
}

Section<TrackedNodeParameters> tracked_node_section()
{
  using P = TrackedNodeParameters;
  Section<P> section("A marker that moves with a point and is written to the output");
  section.required("position", &P::position, vector("m"), "Position of the marker");
  section.required("point", &P::point, count(Bounds().at_least(1)), which_point);
  return section;
}

void check_system(const SystemParameters& system, const Place& place)
{
  const auto require_point = [&](unsigned int point, const Place& where)
  {
    if (point > system.points.size())
      where.fail("there is no point " + std::to_string(point),
                 "points count from 1, so use 1 to " + std::to_string(system.points.size()));
  };
  for (std::size_t i = 0; i < system.joints.size(); ++i)
    for (std::size_t end = 0; end < 2; ++end)
      require_point(system.joints[i].points[end], place.key("constraints").entry(i).key("points").entry(end));

  std::size_t files = 0, outlines = 0;
  for (const SurfaceParameters& surface : system.surfaces)
  {
    const bool flat = place.context().dimension == 2, is_outline = surface.stl.empty();
    const Place where = is_outline ? place.key("outline").entry(outlines++) : place.key("stl files").entry(files++);
    if (is_outline != flat)
      where.fail(flat ? "a 3-D surface in a 2-D scene" : "an outline in a 3-D scene",
                 flat ? "use \"outline\"" : "use \"stl files\", or set \"dimension\" to 2");
    require_point(surface.point, where.key("point"));
  }
  for (std::size_t i = 0; i < system.tracked_nodes.size(); ++i)
    require_point(system.tracked_nodes[i].point, place.key("tracked nodes").entry(i).key("point"));
}
} // namespace

Section<SystemParameters> system_section()
{
  using P = SystemParameters;
  Section<P> section("A system of points that constraints may join");
  section.required("points", &P::points, list_of(object_of(point_section()), 1), "The points, numbered from 1");
  section.optional("constraints", &P::joints, list_of(object_of(joint_section())), "Joints between points");
  const auto add = [](P& system, const std::vector<SurfaceParameters>& surfaces)
  { system.surfaces.insert(system.surfaces.end(), surfaces.begin(), surfaces.end()); };
  section.optional("stl files", add, list_of(object_of(stl_section())), "Surfaces that touch the soil");
  section.optional("outline", add, list_of(object_of(outline_section())), "In 2-D: polygons that touch the soil");
  section.optional("tracked nodes", &P::tracked_nodes, list_of(object_of(tracked_node_section())),
                   "Markers, written as track1, track2, ...");
  section.optional("offset", &P::offset, vector("m"), "Moves the whole system before the run");
  section.check(check_system);
  return section;
}

Section<PointConditionsOverride> point_conditions_section()
{
  using P = PointConditionsOverride;
  Section<P> section("Conditions of one point for this stage");
  section.required("system", &P::system, count(Bounds().at_least(1)), "System, numbered from 1");
  section.required("point", &P::point, count(Bounds().at_least(1)), "Point, numbered from 1 in its system");
  section.required("boundary conditions", &P::conditions, point_conditions(), "Condition on each degree of freedom");
  return section;
}
} // namespace kedge
