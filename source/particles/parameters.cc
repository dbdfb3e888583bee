#include <kedge/parameters/section.h>
#include <kedge/particles/expressions.h>

namespace kedge
{
using namespace schema;

namespace
{
using P = MaterialPointParameters;

Section<Layer> layer_section()
{
  Section<Layer> section("A soil layer as wide as the block");
  section.required(
      "thickness", &Layer::thickness, number("m", positive()),
      "Thickness; points end at the interface, but a cell on both sides of it deforms as one, so stiffness "
      "is best changed at faces of cells; the soil's surface is rounded up to a whole row of points");
  section.required("material", &Layer::material, object_of(material_section()), "What the layer is made of");
  return section;
}

Section<P> material_size_section()
{
  Section<P> section("Plan extent of the block");
  section.required("max", &P::plan_extent, fixed_list<2>(number("m", positive()), Layout{2, 1, "[x, y]", "[x]"}),
                   "Far corner of the block in plan, rounded up to whole base cells");
  section.ignored("min", "Not read: the block starts at 0");
  return section;
}

Section<P> initial_stress_section()
{
  Section<P> section("Stress before the first stage: sigma_v = weight above, of tilted gravity its part across the "
                     "surface; sigma_h = K0 sigma_v");
  section.required(
      "type", [](P&, const std::string&) {}, word({"K0"}), "Way in which the stress is set");
  section.required("K0", &P::K0, maybe(number("-", not_negative())), "Horizontal over vertical stress");
  return section;
}
} // namespace

Section<MaterialPointParameters> material_points_section()
{
  Section<P> section("The soil block and its material points");
  section.required("extra capacity", &P::extra_capacity, number("-", Bounds().at_least(1.)),
                   "Of no effect: storage grows with the number of material points");
  section.required("element size", &P::element_size, number("m", positive()),
                   "Base cell size, rounded down to the smallest size in the file times a power of two");
  section.required(
      "number of material points per element 1", &P::points_per_axis, count(Bounds().at_least(1)),
      "Material points per cell along each axis: 2. One leaves empty cells as soon as soil stretches; 3 or "
      "4 change factors of short pushes in clay by 0.7 % at most, cost two to eight times as much, and make walls in "
      "sand that dilates worse");
  section.group("material size", Key::Presence::required, material_size_section(), "Plan extent of the block");
  section.required("layers", &P::layers, list_of(object_of(layer_section()), 1), "Soil layers from the surface down");
  section.optional(
      "F-bar", &P::f_bar, on_off(),
      "Against locking where soil flows: the material points of a cell share its change of volume and its "
      "pressure, full cells correct their quadrature, and domains follow the flow. For soil that keeps its "
      "volume and for soil that dilates");
  section.group("initial stress", Key::Presence::optional, initial_stress_section(),
                "Stress before the first stage; without it the soil starts free of stress");
  section.optional("initial velocity", &P::initial_velocity, expression_along_axes("m/s", initial_variables),
                   "Velocity at the start of the first stage, a function of the position; without it the soil is at "
                   "rest");
  return section;
}
} // namespace kedge
