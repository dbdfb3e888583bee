#include <kedge/materials/parameters.h>
#include <kedge/parameters/section.h>

namespace kedge
{
using namespace schema;

namespace
{
const std::vector<std::string> frictional = {"drucker prager", "willam warnke", "mohr coulomb"};

Section<Overburden> overburden_section()
{
  Section<Overburden> section("Stiffness by depth: E = E_ref (sigma_v / reference stress)^exponent, with sigma_v the "
                              "weight above a material point's first position");
  section.required("reference stress", &Overburden::reference_stress, number("Pa", positive()),
                   "Vertical stress at which Young's modulus is \"E\"");
  section.required("exponent", &Overburden::exponent, number("-", not_negative()),
                   "Power of the vertical stress; 0: E is constant");
  return section;
}

void check_strength(const MaterialParameters& material, const Place& place)
{
  if (material.type == MaterialType::elastic || material.type == MaterialType::von_mises)
    return;
  if (material.dilation_angle > material.friction_angle)
    place.key("dilation angle")
        .fail("expected at most the friction angle, " + shown(material.friction_angle) + " degrees, found " +
                  shown(material.dilation_angle),
              "lower it: a soil that dilates by more than it rubs would create energy");
  if (material.friction_angle > 0.)
    return;
  if (material.type == MaterialType::willam_warnke)
    place.key("friction angle")
        .fail("expected a number above 0 (degrees), found 0",
              "the cone needs a slope; use \"von mises\" for a soil without friction");
  if (material.cohesion == 0.)
    place.key("cohesion")
        .fail("the friction angle and the cohesion are both 0, so the soil has no strength",
              "give at least one of them above 0");
}
} // namespace

Section<MaterialParameters> material_section()
{
  using P = MaterialParameters;
  const Format<double> angle = number("degrees", not_negative().below(90.));
  Section<P> section("Constitutive law of a layer, at finite strain (Hencky elasticity)");
  section.required("type", &P::type,
                   choice<MaterialType>({{"elastic", MaterialType::elastic},
                                         {"von mises", MaterialType::von_mises},
                                         {"drucker prager", MaterialType::drucker_prager},
                                         {"willam warnke", MaterialType::willam_warnke},
                                         {"mohr coulomb", MaterialType::mohr_coulomb}}),
                   "Elastic law or yield surface");
  section.required("E", &P::young, number("Pa", positive()),
                   "Young's modulus; with \"E overburden\" its value at the reference stress");
  section.required("nu", &P::poisson, number("-", Bounds().above(-1.).below(0.5)), "Poisson's ratio");
  section.required("density", &P::density, number("kg/m3", positive()),
                   "Density; of submerged soil the buoyant density");
  section.required("yield stress", &P::yield_stress, number("Pa", positive()), "Yield stress in uniaxial tension")
      .only_for("type", {"von mises"});
  section.required("friction angle", &P::friction_angle, angle, "Friction angle").only_for("type", frictional);
  section.required("dilation angle", &P::dilation_angle, angle, "Dilation angle, at most the friction angle")
      .only_for("type", frictional);
  section.required("cohesion", &P::cohesion, number("Pa", not_negative()), "Cohesion").only_for("type", frictional);
  section.optional("E overburden", &P::overburden, maybe(object_of(overburden_section())),
                   "Makes Young's modulus grow with depth");
  section.check(check_strength);
  return section;
}
} // namespace kedge
