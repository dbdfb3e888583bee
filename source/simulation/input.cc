#include "input_rules.h"
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <kedge/base/exceptions.h>
#include <kedge/materials/laws.h>
#include <kedge/output/fields.h>
#include <kedge/parameters/manual.h>
#include <kedge/parameters/section.h>
#include <kedge/particles/expressions.h>
#include <kedge/simulation/input.h>
#include <limits>
#include <sstream>

namespace kedge
{
using namespace schema;

namespace
{
Section<Stage> stage_section()
{
  const std::vector<std::string> off = {"off"};
  const std::string bodies = "rigid bodies";
  Section<Stage> section("A stage of the run; the state carries over from the stage before");
  section.include(stepping_section(), &Stage::stepping);
  section.required(bodies, &Stage::rigid_bodies, on_off(), "\"off\": the bodies are frozen and touch nothing");
  section.optional("boundary conditions", &Stage::boundary_conditions, object_of(boundary_conditions_section()),
                   "Conditions on the faces of the grid; without it all are free");
  section.optional(
      "adaptivity", &Stage::adaptivity, object_of(adaptivity_section()),
      "Refinement of the mesh; without it, or around frozen bodies, cells stay as the stage before leaves them, of "
      "base size at first");
  section
      .optional("rigid body surface placement", &Stage::surface_placement, on_off(),
                "Move all bodies vertically by one amount, so that the lowest surface point rests on the soil")
      .unused_for(bodies, off);
  section
      .optional("wished in place", &Stage::wished_in_place, on_off(),
                "The bodies are buried from the start of the stage; the soil inside them is left out")
      .unused_for(bodies, off);
  section
      .optional("largest motion", &Stage::largest_motion,
                number_or("off", std::numeric_limits<double>::infinity(), number("-", positive())),
                "Largest distance that a surface may go in one step as its point is prescribed, over the size of the "
                "cells at the surfaces: longer steps are made in 2, 4, 8 ... smaller ones, with a warning. Resistance "
                "is too high by about as much as the steps are long: by 3 to 14 % with a tenth of a cell, 13 to 50 % "
                "with two fifths. \"off\": steps are made as given")
      .unused_for(bodies, off);
  section
      .optional("rigid body boundary conditions", &Stage::point_conditions,
                list_of(object_of(point_conditions_section())), "Conditions of points in this stage alone")
      .unused_for(bodies, off);
  section
      .optional("boundary track", &Stage::track, object_of(boundary_track_section()),
                "Window of active soil that follows the bodies; without it all soil is active")
      .unused_for(bodies, off);
  return section;
}

Section<Input> domain_section()
{
  Section<Input> section("The grid and gravity");
  section.ignored("size", "Not read: \"extent\" is the size of the grid");
  section.optional(
      "extent", [](Input& input, const std::array<double, 3>& read) { input.grid_extent = read; },
      vector("m", positive()),
      "Upper corner of the grid, rounded up to whole base cells: room for soil that slides or collapses. Without it "
      "the "
      "grid ends where the soil does, and has as much empty space above it");
  section.required("gravity", &Input::gravity, vector("m/s2"),
                   "Acceleration of gravity; with \"tolerance\" not zero, but where there is a body force");
  section.optional("body force", &Input::body_force, expression_along_axes("m/s2", present_variables),
                   "Acceleration of the soil in addition to gravity; bodies do not feel it. X, Y, Z is the initial and "
                   "x, y, z the present position of a material point as a step begins (explicit: a basis step), t the "
                   "time since the start of the stage, in static stages the load fraction. It is not scaled by "
                   "\"gravity ramp\"");
  return section;
}

Section<Input> input_section()
{
  Section<Input> section("Input of Kedge: SI units, degrees, tension positive, z up. Systems and points are numbered "
                         "from 1, paths are relative to the input file");
  section.ignored("$schema", "Not read: where editors find what `kedge schema` prints");
  section.required(
      "GPU", &Input::gpu, on_off(),
      "Run on a GPU. Builds compute either on one or on the CPU; one that has not what is asked for warns");
  section.optional("dimension", &Input::dimension, count(Bounds().at_least(2).at_most(3)),
                   "3, or 2 for plane strain, where vectors are [x, z]");
  section.optional("basis", &Input::basis, choice<Basis>({{"gimp", Basis::gimp}, {"mpm", Basis::mpm}}),
                   "Generalised interpolation, or the standard material point method with its cell-crossing errors");
  section.optional(
      "domain update", [](Input& input) -> DomainUpdate& { return input.material_points.domain_update; },
      choice<DomainUpdate>({{"automatic", DomainUpdate::automatic},
                            {"none", DomainUpdate::none},
                            {"stretch", DomainUpdate::stretch},
                            {"flow", DomainUpdate::flow}}),
      "Material point domains keep their size, stretch with the whole deformation along their axes, or follow the flow "
      "step by step; those that grow too wide along an axis are split there. automatic: flow with F-bar, else none");
  section.group("domain", Key::Presence::required, domain_section(), "The grid and gravity");
  section.required(
      "material points",
      [](Input& input, const MaterialPointParameters& read)
      {
        const DomainUpdate kept = input.material_points.domain_update; // its key stands outside this section
        input.material_points = read;
        input.material_points.domain_update = kept;
      },
      object_of(material_points_section()), "The soil block and its material points");
  section.required("rigid bodies", &Input::systems, list_of(object_of(system_section())),
                   "Systems of rigid bodies; [] = none. Bodies touch soil, not each other");
  section.required("contact", &Input::contact, object_of(contact_section()), "Contact between soil and bodies");
  section.required("analysis", &Input::stages, list_of(object_of(stage_section()), 1), "The stages, in order");
  section.required("solver", &Input::solver, object_of(solver_section()), "Newton iterations and linear solver");
  section.required("output", &Input::output, object_of(output_section()), "Files written during the run");
  section.check(check_consistency);
  return section;
}

/// Contact springs that the input leaves open: softer ones in explicit stages, where stiff ones make time steps short
/// and speed of the points' noise. The document gets what is chosen, so that copies and restart files hold it.
void choose_springs(Json& document, Input& input)
{
  Json& given = document.at("contact");
  const bool touches_in_explicit_stage =
      std::any_of(input.stages.begin(), input.stages.end(),
                  [](const Stage& stage) { return stage.rigid_bodies && stage.stepping.type == StageType::explicit_; });
  const std::string normal = "normal penalty factor", tangential = "tangential penalty factor";
  if (!given.contains(normal) && touches_in_explicit_stage)
    given[normal] = input.contact.normal_penalty_factor = explicit_normal_penalty_factor;
  if (!given.contains(tangential) && given.contains(normal))
    given[tangential] = input.contact.tangential_penalty_factor = 0.5 * input.contact.normal_penalty_factor;
}

/// Needed before the document is checked, as it sets the length of vectors; a wrong value is refused with the rest.
unsigned int dimension_of(const Json& document)
{
  return document.is_object() && document.contains("dimension") && document.at("dimension") == 2 ? 2 : 3;
}
} // namespace

Input parse_input(const std::string& text, const std::string& folder, const std::string& source,
                  const std::vector<std::string>& overrides)
{
  Json document = parse_json(text, source);
  for (const std::string& assignment : overrides)
    apply_override(document, assignment);

  const Section<Input> section = input_section();
  InputContext context;
  context.dimension = dimension_of(document);
  context.folder = folder;
  context.sections_with_key = [&](const std::string& key) { return sections_with_key(section.schema(), key); };

  Input input;
  section.read(document, input, Place(context));
  Adaptivity cells;
  for (Stage& stage : input.stages)
  {
    if (!stage.rigid_bodies) // frozen bodies are neither refined around nor followed
    {
      stage.track = BoundaryTrack();
      if (stage.adaptivity.type == AdaptivityType::rigid_body_surface)
        stage.adaptivity.type = AdaptivityType::none;
    }
    if (stage.adaptivity.type == AdaptivityType::rigid_body_surface)
      cells = stage.adaptivity;
    stage.cells = cells;
  }
  choose_springs(document, input);
  input.effective_json = document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  return input;
}

Input read_input(const std::string& file, const std::vector<std::string>& overrides)
{
  std::error_code ignored;
  std::ifstream stream;
  if (std::filesystem::is_regular_file(file, ignored)) // opening a pipe would wait for its writer
    stream.open(file);
  std::ostringstream text;
  if (!stream.is_open() || !(text << stream.rdbuf()))
    throw InputError(file, "the input file cannot be read",
                     "check its path and its permissions, and that it is a file and not empty");
  return parse_input(text.str(), std::filesystem::path(file).parent_path().string(), file, overrides);
}

std::string input_schema()
{
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Kedge input"}};
  const Json section = input_section().schema();
  for (const auto& [name, value] : section.items())
    schema[name] = value;
  return schema.dump(2) + "\n";
}

namespace
{
std::string manual_of_fields()
{
  std::string page =
      "\n## Fields of material points\n\n"
      "Names for `vtk material point fields` and `csv material point fields`, with the columns of tables.\n\n"
      "| field | columns | unit | meaning |\n|---|---|---|---|\n";
  for (const FieldDescription& field : describe_particle_fields())
    page += fmt::format("| `{}` | {} | {} | {} |\n", field.name, field.columns, field.unit, field.sentence);
  page +=
      "\n## State variables of laws\n\n"
      "`law state` stands for the state variables of a layer's law, each a column of its own; laws without memory have "
      "none.\n\n"
      "| law | variable | unit | meaning |\n|---|---|---|---|\n";
  Laws::for_each(
      [&](const auto tag)
      {
        using Law = typename decltype(tag)::type;
        for (const StateVariable& variable : Law::state_variables)
          page += fmt::format("| {} | `{}` | {} | {} |\n", Law::name, variable.name, variable.unit, variable.sentence);
      });
  return page;
}
} // namespace

std::string input_manual()
{
  return "# Input parameters\n\n"
         "Generated from the declarations in the code; do not edit. An unknown key, a wrong type or a value out of\n"
         "bounds is an error; a key named `comment` may stand in every object. `x[]` stands for an entry of the list\n"
         "`x`. In 2-D, vectors are [x, z].\n" +
         markdown_tables(input_section().schema()) + manual_of_fields();
}
} // namespace kedge
