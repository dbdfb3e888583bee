#include <algorithm>
#include <kedge/output/fields.h>
#include <kedge/output/parameters.h>
#include <kedge/parameters/section.h>

namespace kedge
{
using namespace schema;

namespace
{
/// Names out of `known`, each at most once.
Format<std::vector<std::string>> names(const std::vector<std::string>& known)
{
  Format<std::vector<std::string>> format = list_of(word(known));
  format.expects = "a list of field names";
  format.read = [read = format.read](const Json& json, const Place& place)
  {
    const std::vector<std::string> list = read(json, place);
    for (std::size_t i = 0; i < list.size(); ++i)
      if (std::find(list.begin(), list.begin() + i, list[i]) != list.begin() + i)
        place.entry(i).fail("the field \"" + list[i] + "\" is listed twice", "remove one of the two");
    return list;
  };
  format.schema["uniqueItems"] = true;
  return format;
}

/// "10 min": a positive number and s, min or h.
bool is_duration(const std::string& text)
{
  const std::size_t space = text.find(' ');
  if (space == std::string::npos)
    return false;
  const std::string unit = text.substr(space + 1);
  const Json value = Json::parse(text.substr(0, space), nullptr, false);
  return value.is_number() && value.get<double>() > 0. && (unit == "s" || unit == "min" || unit == "h");
}

Format<std::string> interval()
{
  Format<std::string> format;
  format.expects = "a whole number of steps of at least 1, or a wall time such as \"10 min\"";
  format.read = [steps = count(Bounds().at_least(1)), expects = format.expects](const Json& json, const Place& place)
  {
    if (json.is_number())
      return std::to_string(steps.read(json, place));
    if (!json.is_string() || !is_duration(json.get<std::string>()))
      place.expected(expects, shown(json), "write 50, \"30 s\", \"10 min\" or \"2 h\"");
    return json.get<std::string>();
  };
  format.unit = "steps or wall time";
  format.schema = {{"anyOf",
                    {{{"type", "integer"}, {"minimum", 1}},
                     {{"type", "string"}, {"pattern", "^[0-9]+(\\.[0-9]+)?([eE][+-]?[0-9]+)? (s|min|h)$"}}}}};
  return format;
}

/// The keys of one family of files all start with its name.
Section<SeriesParameters> series_section(const std::string& name)
{
  using P = SeriesParameters;
  Section<P> section(name + " files");
  section.required(name, &P::on, on_off(), "Whether " + name + " files are written");
  section.required(name + " directory", &P::directory, output_folder(), "Folder of these files")
      .needed_for(name, {"on"});
  section
      .required(name + " percent", &P::percent, number("%", not_negative().at_most(100.)),
                "Steps between files, as a share of the stage's steps; 0: every converged step or part of one")
      .needed_for(name, {"on"});
  section.optional(name + " material point fields", &P::particle_fields, names(particle_field_names()),
                   "Fields written of material points; [] = none", particle_field_names());
  section.optional(name + " rigid body fields", &P::body_fields, names(body_field_names()),
                   "Fields written of rigid points; [] = none", body_field_names());
  return section;
}
} // namespace

const std::vector<std::string>& particle_field_names()
{
  static const std::vector<std::string> names = []
  {
    std::vector<std::string> known;
    for (const FieldDescription& field : describe_particle_fields())
      known.push_back(field.name);
    return known;
  }();
  return names;
}

const std::vector<std::string>& body_field_names()
{
  static const std::vector<std::string> names = {
      "position", "velocity",       "acceleration",    "angular velocity", "angular acceleration",
      "mass",     "reaction force", "reaction moment", "rotation"};
  return names;
}

Section<OutputParameters> output_section()
{
  using P = OutputParameters;
  Section<P> section("Files written during the run, below its output folder");
  section.include(series_section("vtk"), &P::vtk);
  section.include(series_section("csv"), &P::csv);
  section.optional(
      "checkpoint every", &P::checkpoint_every, interval(),
      "Interval between restart files, of which the last two are kept; without it, a restart file is written at the "
      "end of every stage but the last one, when a run fails and when a signal ends it");
  section.optional("checkpoint directory", &P::checkpoint_directory, output_folder(), "Folder of the restart files");
  return section;
}
} // namespace kedge
