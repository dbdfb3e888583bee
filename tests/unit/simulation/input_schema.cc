// The published schema and the manual made from it.
#include "input_files.h"
#include <cstdlib>
#include <gtest/gtest.h>
#include <kedge/materials/laws.h>
#include <kedge/parameters/manual.h>
#include <kedge/simulation/input.h>

using namespace kedge;
using schema::Json;

namespace
{
/// The keys and those that the laws declare.
std::vector<std::string> with_keys_of_laws(std::vector<std::string> keys)
{
  Laws::for_each(
      [&](const auto tag)
      {
        using Law = typename decltype(tag)::type;
        for (const LawKey* key : Law::keys)
          keys.push_back(key->name);
      });
  return keys;
}

/// The sections of the input, with every key that they hold.
const std::vector<std::pair<std::string, std::vector<std::string>>> format = {
    {"",
     {"$schema", "GPU", "comment", "dimension", "basis", "domain update", "domain", "material points", "rigid bodies",
      "contact", "analysis", "solver", "output"}},
    {"domain", {"size", "extent", "gravity", "body force"}},
    {"domain.body force", {"expression", "definitions"}},
    {"material points",
     {"extra capacity", "element size", "number of material points per element 1", "material size", "layers", "F-bar",
      "initial stress", "initial velocity"}},
    {"material points.initial velocity", {"expression", "definitions"}},
    {"material points.material size", {"max", "min"}},
    {"material points.layers[]", {"thickness", "material"}},
    {"material points.layers[].material", with_keys_of_laws({"type", "E", "nu", "density", "E overburden"})},
    {"material points.layers[].material.E overburden", {"reference stress", "exponent"}},
    {"material points.initial stress", {"type", "K0"}},
    {"rigid bodies[]", {"points", "constraints", "stl files", "outline", "tracked nodes", "offset"}},
    {"rigid bodies[].points[]", {"position", "mass", "rotational inertia", "boundary conditions"}},
    {"rigid bodies[].constraints[]",
     {"type", "points", "stiffness", "position 1", "position 2", "rotation centre", "direction 1", "direction 2",
      "rotational stiffness", "distance", "angle limit"}},
    {"rigid bodies[].stl files[]",
     {"stl", "point", "mesh cache", "name", "friction coefficient", "adhesion", "tangential limit", "bonded",
      "warn of sharp edges"}},
    {"rigid bodies[].outline[]",
     {"polygon", "edge radius", "point", "friction coefficient", "adhesion", "tangential limit", "bonded",
      "warn of sharp edges"}},
    {"rigid bodies[].tracked nodes[]", {"position", "point"}},
    {"contact",
     {"friction coefficient", "adhesion", "tangential limit", "bonded", "method", "normal penalty factor",
      "tangential penalty factor", "penetration tolerance"}},
    {"analysis[]",
     {"type",
      "rigid bodies",
      "load steps",
      "load",
      "dt",
      "basis step",
      "final time",
      "beta",
      "gamma",
      "mass",
      "cfl",
      "damping",
      "mass scaling",
      "boundary conditions",
      "adaptivity",
      "rigid body surface placement",
      "wished in place",
      "largest motion",
      "rigid body boundary conditions",
      "boundary track"}},
    {"analysis[].boundary conditions", {"min", "max"}},
    {"analysis[].adaptivity", {"type", "element size", "region", "element size in region", "boxes", "merge"}},
    {"analysis[].adaptivity.boxes[]", {"min", "max", "element size"}},
    {"analysis[].rigid body boundary conditions[]", {"system", "point", "boundary conditions"}},
    {"analysis[].boundary track", {"min", "max"}},
    {"analysis[].boundary track.min", {"type", "distance", "advance", "remove"}},
    {"analysis[].boundary track.max", {"type", "distance", "advance", "remove"}},
    {"solver",
     {"force tolerance", "tolerance", "max newton iterations", "poor factor", "ghost factor", "ghost factor mass",
      "max linear iterations", "line search", "linear solver", "reuse", "minimum step fraction"}},
    {"output",
     {"vtk", "csv", "vtk directory", "vtk percent", "csv directory", "csv percent", "vtk material point fields",
      "vtk rigid body fields", "csv material point fields", "csv rigid body fields", "checkpoint every",
      "checkpoint directory"}}};

const Json& published()
{
  static const Json schema = Json::parse(input_schema());
  return schema;
}

/// Whether a value of this schema holds numbers.
bool is_quantity(const Json& property)
{
  if (property.contains("items"))
    return is_quantity(property.at("items"));
  const Json options = property.value("anyOf", Json::array());
  for (const auto& option : options)
    if (is_quantity(option))
      return true;
  return property.value("type", "") == "number" || property.value("type", "") == "integer";
}
} // namespace

TEST(InputSchema, StatesItsDraft)
{
  EXPECT_EQ(published().at("$schema"), "https://json-schema.org/draft/2020-12/schema");
}

TEST(InputSchema, HoldsEveryKeyOfTheFormatAndNoOther)
{
  std::size_t sections = 0;
  const auto check = [&](const std::string& path, const Json& section)
  {
    ++sections;
    for (const auto& [listed, keys] : format)
      if (listed == path)
      {
        for (const std::string& key : keys)
          EXPECT_TRUE(section.at("properties").contains(key)) << path << ": " << key;
        for (const auto& [key, property] : section.at("properties").items())
          EXPECT_TRUE(key == "comment" || std::count(keys.begin(), keys.end(), key) > 0) << path << ": " << key;
        return;
      }
    ADD_FAILURE() << "section " << path << " is not in the format";
  };
  schema::for_each_section(published(), check);
  EXPECT_EQ(sections, format.size());
}

TEST(InputSchema, DescribesEveryKeyWithUnitAndStatus)
{
  schema::for_each_section(published(),
                           [](const std::string& path, const Json& section)
                           {
                             EXPECT_EQ(section.at("additionalProperties"), false) << path;
                             for (const auto& [key, property] : section.at("properties").items())
                             {
                               EXPECT_FALSE(property.value("description", "").empty()) << path << "." << key;
                               EXPECT_FALSE(property.value("status", "").empty()) << path << "." << key;
                               if (is_quantity(property))
                               {
                                 EXPECT_FALSE(property.value("unit", "").empty()) << path << "." << key;
                               }
                             }
                           });
}

TEST(InputManual, IsThePageInTheRepository)
{
  const auto page = input_files::root() / "doc" / "parameters.md";
  if (std::getenv("KEDGE_UPDATE_MANUAL"))
    std::ofstream(page) << input_manual();
  EXPECT_EQ(input_files::contents(page), input_manual())
      << "the declarations have changed: run this test with KEDGE_UPDATE_MANUAL=1 to write the page again";
}
