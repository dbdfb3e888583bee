#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/parameters/manual.h>
#include <kedge/parameters/section.h>

using namespace kedge;
using namespace kedge::schema;

namespace
{
struct Wheel
{
  double radius = 0.3;
  unsigned int spokes = 32;
};

struct Bicycle
{
  bool lit = false;
  std::string kind;
  double charge = 0.;
  std::optional<double> basket;
  std::array<double, 3> hub{};
  std::vector<Wheel> wheels;
  Wheel spare;
};

Section<Wheel> wheel_section()
{
  Section<Wheel> section("A wheel");
  section.optional("radius", &Wheel::radius, number("m", positive()), "Radius to the rim");
  section.optional("spokes", &Wheel::spokes, count(), "Number of spokes");
  return section;
}

Section<Bicycle> bicycle_section()
{
  Section<Bicycle> section("A bicycle");
  section.required("kind", &Bicycle::kind, word({"plain", "electric"}), "What drives it");
  section.required("charge", &Bicycle::charge, number("J", not_negative()), "Energy stored")
      .only_for("kind", {"electric"});
  section.optional("light", &Bicycle::lit, on_off(), "Whether it is lit").unused_for("kind", {"electric"});
  section.optional("basket", &Bicycle::basket, maybe(number("m3")), "Room in the basket").needed_for("kind", {"plain"});
  section.optional("hub", &Bicycle::hub, vector("m"), "Place of the hub");
  section.optional("wheels", &Bicycle::wheels, list_of(object_of(wheel_section())), "The wheels");
  section.ignored("colour", "Not read");
  return section;
}

Bicycle read_bicycle(const std::string& text, unsigned int dimension = 3)
{
  InputContext context;
  context.dimension = dimension;
  Bicycle bicycle;
  bicycle_section().read(parse_json(text, "text"), bicycle, Place(context).key("bicycle"));
  return bicycle;
}

std::string error_of_bicycle(const std::string& text, unsigned int dimension = 3)
{
  try
  {
    read_bicycle(text, dimension);
  }
  catch (const InputError& error)
  {
    return error.what();
  }
  return "accepted";
}
} // namespace

TEST(Section, FillsMembers)
{
  const Bicycle bicycle = read_bicycle(R"({"kind": "plain", "basket": 0.02, "light": "on", "hub": [1, 2.5, 3],
                                   "wheels": [{}, {"radius": 0.25, "spokes": 28}]})");
  EXPECT_EQ(bicycle.kind, "plain");
  EXPECT_EQ(bicycle.basket, 0.02);
  EXPECT_TRUE(bicycle.lit);
  EXPECT_EQ(bicycle.hub, (std::array<double, 3>{1., 2.5, 3.}));
  ASSERT_EQ(bicycle.wheels.size(), 2u);
  EXPECT_EQ(bicycle.wheels[0].spokes, 32u);
  EXPECT_EQ(bicycle.wheels[1].radius, 0.25);
}

TEST(Section, KeepsDefaultOfStructForAbsentKey)
{
  const Bicycle bicycle = read_bicycle(R"({"kind": "electric", "charge": 5})");
  EXPECT_FALSE(bicycle.basket.has_value());
  EXPECT_FALSE(bicycle.lit);
}

TEST(Section, AcceptsCommentAndIgnoredKeyOfAnyType)
{
  EXPECT_EQ(error_of_bicycle(R"({"kind": "electric", "charge": 5, "comment": ["a", 1], "colour": {"r": 1},
                         "wheels": [{"comment": "front"}]})"),
            "accepted");
}

TEST(Section, ReadsTwoEntriesOfVectorInTwoDimensions)
{
  const std::string text = R"({"kind": "electric", "charge": 5, "hub": [1, 2]})";
  EXPECT_EQ(read_bicycle(text, 2).hub, (std::array<double, 3>{1., 2., 0.}));
  EXPECT_EQ(error_of_bicycle(text, 3),
            "bicycle.hub: expected a list [x, y, z], each entry a number (m), found a list of 2; "
            "correct the value (Place of the hub)");
}

TEST(Section, NamesPathInsideLists)
{
  EXPECT_EQ(error_of_bicycle(R"({"kind": "electric", "charge": 5, "wheels": [{}, {"radius": 0}]})"),
            "bicycle.wheels[1].radius: expected a number above 0 (m), found 0; correct the value (Radius to the rim)");
}

TEST(Section, RequiresOnlyForKeyWhereItBelongs)
{
  EXPECT_NE(error_of_bicycle(R"({"kind": "electric"})").find("bicycle.charge: this required key is missing"),
            std::string::npos);
  EXPECT_NE(
      error_of_bicycle(R"({"kind": "plain", "basket": 1, "charge": 5})").find("belongs to \"kind\": \"electric\""),
      std::string::npos);
}

TEST(Section, RequiresNeededForKeyOnlyThere)
{
  EXPECT_NE(error_of_bicycle(R"({"kind": "plain"})").find("bicycle.basket: this required key is missing"),
            std::string::npos);
  EXPECT_EQ(error_of_bicycle(R"({"kind": "electric", "charge": 5, "basket": 0.02})"), "accepted");
}

TEST(Section, ChecksFormOfUnusedKeyButDropsItsValue)
{
  EXPECT_FALSE(read_bicycle(R"({"kind": "electric", "charge": 5, "light": "on"})").lit);
  EXPECT_NE(error_of_bicycle(R"({"kind": "electric", "charge": 5, "light": "bright"})").find("bicycle.light"),
            std::string::npos);
}

TEST(Section, IncludesKeysOfAnotherAtTheSameLevel)
{
  Section<Bicycle> section("A bicycle");
  Section<Wheel> spare = wheel_section();
  spare.check(
      [](const Wheel& wheel, const Place& place)
      {
        if (wheel.spokes == 0)
          place.key("spokes").fail("none", "add some");
      });
  section.include(spare, &Bicycle::spare);
  const InputContext context;
  Bicycle bicycle;
  section.read(parse_json(R"({"radius": 0.2})", "text"), bicycle, Place(context));
  EXPECT_EQ(bicycle.spare.radius, 0.2);
  EXPECT_THROW(section.read(parse_json(R"({"spokes": 0})", "text"), bicycle, Place(context)), InputError);
}

TEST(Section, AppliesDefaultThatTheStructDoesNotHold)
{
  Section<Bicycle> section("A bicycle");
  section.optional("kind", &Bicycle::kind, word({"plain", "electric"}), "What drives it", std::string("plain"));
  const InputContext context;
  Bicycle bicycle;
  section.read(Json::object(), bicycle, Place(context));
  EXPECT_EQ(bicycle.kind, "plain");
  EXPECT_EQ(section.schema().at("properties").at("kind").at("default"), "plain");
}

TEST(Section, SuggestsPlaceOfKeyFromElsewhere)
{
  InputContext context;
  context.sections_with_key = [](const std::string&) { return std::vector<std::string>{"garage"}; };
  Bicycle bicycle;
  try
  {
    bicycle_section().read(parse_json(R"({"roof": 1})", "text"), bicycle, Place(context));
    FAIL();
  }
  catch (const InputError& error)
  {
    EXPECT_STREQ(error.what(), "roof: unknown key here; it belongs in \"garage\"");
  }
}

TEST(Section, DescribesItselfAsSchema)
{
  const Json schema = bicycle_section().schema();
  EXPECT_EQ(schema.at("additionalProperties"), false);
  EXPECT_EQ(schema.at("required"), Json::array({"kind"}));
  const Json& radius = schema.at("properties").at("wheels").at("items").at("properties").at("radius");
  EXPECT_EQ(radius.at("unit"), "m");
  EXPECT_EQ(radius.at("default"), 0.3);
  EXPECT_EQ(radius.at("exclusiveMinimum"), 0.);
  EXPECT_EQ(radius.at("description"), "Radius to the rim");
  EXPECT_EQ(schema.at("properties").at("charge").at("status"), "required, only with \"kind\": \"electric\"");
  EXPECT_EQ(schema.at("allOf").size(), 2u);
}

TEST(Manual, FindsSectionsByKey)
{
  EXPECT_EQ(sections_with_key(bicycle_section().schema(), "radius"), std::vector<std::string>{"wheels[]"});
  EXPECT_EQ(sections_with_key(bicycle_section().schema(), "kind"), std::vector<std::string>{""});
}

TEST(Manual, WritesOneRowPerKey)
{
  EXPECT_NE(markdown_tables(bicycle_section().schema())
                .find("| `radius` | a number above 0 (m) | m | `0.3` | optional | Radius to the rim |\n"),
            std::string::npos);
}
