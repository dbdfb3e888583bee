#include <kedge/contact/parameters.h>
#include <kedge/parameters/section.h>

namespace kedge
{
using namespace schema;

Section<ContactParameters> contact_section()
{
  using P = ContactParameters;
  Section<P> section("Contact between the soil and the surfaces of the rigid bodies");
  section.include(interface_section(true), &P::interface);
  section.optional("method", &P::method,
                   choice<ContactMethod>({{"penalty", ContactMethod::penalty},
                                          {"augmented lagrangian", ContactMethod::augmented_lagrangian}}),
                   "Penalty springs alone, or with multipliers that take out the penetration");
  section.optional(
      "normal penalty factor", &P::normal_penalty_factor, number("-", positive()),
      "Normal contact stiffness over that of the material point; about 50 suits elastic soil, but makes contacts "
      "chatter on soil that yields: 0.5 to 5 suit that, with resistances within 1 to 3 % of each other. In a run "
      "whose bodies touch soil in an explicit stage the default is 0.25");
  section.optional("tangential penalty factor", &P::tangential_penalty_factor, number("-", positive()),
                   "Sticking stiffness over that of the material point; by default half of the normal one");
  section
      .optional("penetration tolerance", &P::penetration_tolerance, number("-", positive().below(1.)),
                "Largest penetration left, as a share of a material point's size")
      .only_for("method", {"augmented lagrangian"});
  return section;
}
} // namespace kedge
