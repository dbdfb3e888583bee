#include <kedge/mesh/parameters.h>
#include <kedge/parameters/section.h>

namespace kedge
{
using namespace schema;

namespace
{
using Planes = std::array<TrackPlane, 3>;

/// Setter that fills one member of all planes from a list.
template <typename V> auto per_axis(V TrackPlane::*member)
{
  return [member](Planes& planes, const std::array<V, 3>& values)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
      planes[axis].*member = values[axis];
  };
}

/// Only a plane that the bodies leave behind may remove soil: a lower plane that moves up, or an upper plane that moves
/// down.
void check_removal(const Planes& planes, const Place& place, Advance trailing)
{
  for (std::size_t axis = 0; axis < planes.size(); ++axis)
    if (planes[axis].type && planes[axis].remove && planes[axis].advance != trailing)
      place.key("remove").entry(axis).fail("\"yes\" is for a trailing plane, which this one is not",
                                           std::string("set it to \"no\", or \"advance\" of this axis to \"") +
                                               (trailing == Advance::positive ? "positive" : "negative") + "\"");
}

Section<Planes> planes_section(const std::string& side, Advance trailing)
{
  Section<Planes> section("Planes of the window on the " + side + " side of the bodies");
  section.required(
      "type", per_axis(&TrackPlane::type),
      fixed_list<3>(choice<std::optional<FaceCondition>>(
                        {{"off", std::nullopt}, {"roller", FaceCondition::roller}, {"fixed", FaceCondition::fixed}}),
                    axes()),
      "Condition on the plane, in place of that of the grid's face; a plane stops at that face; \"off\": no plane on "
      "this axis");
  section.required("distance", per_axis(&TrackPlane::distance), vector("m", not_negative()),
                   "Distance from the extent of the bodies' surfaces, rounded outward to base cells");
  section.required(
      "advance", per_axis(&TrackPlane::advance),
      fixed_list<3>(
          choice<Advance>({{"positive", Advance::positive}, {"negative", Advance::negative}, {"both", Advance::both}}),
          axes()),
      "Directions in which the plane may move along its axis after the start of the stage, where it was placed");
  section.required(
      "remove", per_axis(&TrackPlane::remove), fixed_list<3>(yes_no(), axes()),
      "\"yes\": the soil behind the plane is deleted (on a trailing plane only); \"no\": it stays and waits");
  section.check([trailing](const Planes& planes, const Place& place) { check_removal(planes, place, trailing); });
  return section;
}

void check_region(const Adaptivity& adaptivity, const Place& place)
{
  if (adaptivity.region > 0. && adaptivity.element_size_in_region == 0.)
    place.key("element size in region").fail("\"region\" is given without the cell size in it", "add it, in m");
  if (adaptivity.element_size_in_region > 0. && adaptivity.region == 0.)
    place.key("region").fail("\"element size in region\" is given without the extent of the region", "add it, in m");
  if (adaptivity.region > 0. && adaptivity.element_size_in_region < adaptivity.element_size)
    place.key("element size in region")
        .fail("expected at least \"element size\", " + shown(adaptivity.element_size) + " m, found " +
                  shown(adaptivity.element_size_in_region),
              "refine the surface at least as much as the region around it");
}

/// In 2-D the third entries are 0 on both sides.
void check_box(const RefinedBox& box, const Place& place)
{
  for (std::size_t axis = 0; axis < (place.context().dimension == 2 ? 2u : 3u); ++axis)
    if (box.max[axis] <= box.min[axis])
      place.key("max").entry(axis).fail("expected more than \"min\" of this axis, " + shown(box.min[axis]) +
                                            " m, found " + shown(box.max[axis]),
                                        "give the box an extent along every axis");
}

Section<RefinedBox> box_section()
{
  using P = RefinedBox;
  Section<P> section("A box in which cells stay fine wherever the bodies are");
  section.required("min", &P::min, vector("m"), "Lower corner");
  section.required("max", &P::max, vector("m"), "Upper corner; a cell that reaches into the box is refined");
  section.required("element size", &P::element_size, number("m", positive()), "Cell size in the box");
  section.check(check_box);
  return section;
}
} // namespace

std::vector<double> finer_sizes(const Adaptivity& adaptivity)
{
  std::vector<double> sizes;
  if (adaptivity.type != AdaptivityType::rigid_body_surface)
    return sizes;
  sizes.push_back(adaptivity.element_size);
  if (adaptivity.region > 0.)
    sizes.push_back(adaptivity.element_size_in_region);
  for (const RefinedBox& box : adaptivity.boxes)
    sizes.push_back(box.element_size);
  return sizes;
}

double cell_size_at_surfaces(const Adaptivity& adaptivity, const double base_size)
{
  double size = base_size;
  if (adaptivity.type == AdaptivityType::rigid_body_surface)
    while (size > adaptivity.element_size * (1. + 1e-9))
      size *= 0.5;
  return size;
}

Section<BoundaryConditions> boundary_conditions_section()
{
  using P = BoundaryConditions;
  const auto faces = fixed_list<3>(
      choice<FaceCondition>(
          {{"free", FaceCondition::free}, {"roller", FaceCondition::roller}, {"fixed", FaceCondition::fixed}}),
      axes());
  Section<P> section("Conditions on the faces of the grid");
  section.required("min", &P::min, faces, "Faces at the lower end of each axis");
  section.required("max", &P::max, faces,
                   "Faces at the upper end of each axis; that of z lies above the soil: at twice its thickness, or "
                   "where \"extent\" ends");
  return section;
}

Section<Adaptivity> adaptivity_section()
{
  using P = Adaptivity;
  const std::vector<std::string> surface = {"rigid body surface"};
  Section<P> section("Refinement of the mesh");
  section.required(
      "type", &P::type,
      choice<AdaptivityType>({{"none", AdaptivityType::none},
                              {"uniform", AdaptivityType::uniform},
                              {surface[0], AdaptivityType::rigid_body_surface}}),
      "Base size where there is soil, base size everywhere, or finer where the bodies' surfaces are. After a stage "
      "that refines, the first two keep its cells");
  section.required("element size", &P::element_size, number("m", positive()), "Cell size at the surfaces")
      .only_for("type", surface);
  // Functions set these members, because their zeros mean "no region" and must not be published as defaults.
  section
      .optional(
          "region", [](P& into, double read) { into.region = read; }, number("m", positive()),
          "Distance from the surfaces up to which cells are refined too")
      .only_for("type", surface);
  section
      .optional(
          "element size in region", [](P& into, double read) { into.element_size_in_region = read; },
          number("m", positive()), "Cell size in that region")
      .only_for("type", surface);
  section
      .optional("boxes", &P::boxes, list_of(object_of(box_section())),
                "Boxes that are fine before a body comes near: a mesh that does not change changes no resistance")
      .only_for("type", surface);
  section.optional("merge", &P::merge, on_off(), "Merge split material points again where the bodies have left");
  section.check(check_region);
  return section;
}

Section<BoundaryTrack> boundary_track_section()
{
  Section<BoundaryTrack> section("A window of active soil that follows the bodies");
  section.required("min", &BoundaryTrack::min, object_of(planes_section("lower", Advance::positive)),
                   "Planes on the lower side of the bodies");
  section.required("max", &BoundaryTrack::max, object_of(planes_section("upper", Advance::negative)),
                   "Planes on the upper side of the bodies");
  return section;
}
} // namespace kedge
