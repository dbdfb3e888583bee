#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/parameters/format.h>
#include <kedge/parameters/words.h>

using namespace kedge;
using namespace kedge::schema;

namespace
{
const InputContext context;
template <typename V> bool accepts(const Format<V>& format, const Json& json)
{
  try
  {
    format.read(json, Place(context).key("x"));
    return true;
  }
  catch (const InputError&)
  {
    return false;
  }
}
} // namespace

TEST(Bounds, OpenEndExcludesLimit)
{
  EXPECT_FALSE(Bounds().above(1.).hold(1.));
  EXPECT_TRUE(Bounds().at_least(1.).hold(1.));
  EXPECT_FALSE(Bounds().below(1.).hold(1.));
  EXPECT_TRUE(Bounds().at_most(1.).hold(1.));
}

TEST(Bounds, DescribeThemselves)
{
  EXPECT_EQ(Bounds().text(), "");
  EXPECT_EQ(Bounds().above(-1.).below(0.5).text(), " above -1 and below 0.5");
  EXPECT_EQ(Bounds().at_most(2.).text(), " at most 2");
}

TEST(Number, AcceptsWholeNumbersToo) { EXPECT_EQ(number("m").read(3, Place(context)), 3.); }

TEST(Count, RefusesAnythingButWholeNumbers)
{
  EXPECT_TRUE(accepts(count(), 3));
  EXPECT_TRUE(accepts(count(), 0));
  EXPECT_FALSE(accepts(count(), 3.0));
  EXPECT_FALSE(accepts(count(), -1));
  EXPECT_FALSE(accepts(count(), 4294967296));
  EXPECT_FALSE(accepts(count(), true));
}

TEST(NumberOr, AcceptsNumberAndWord)
{
  const auto format = number_or("auto", 0., number("s", positive()));
  EXPECT_EQ(format.read("auto", Place(context)), 0.);
  EXPECT_EQ(format.read(0.5, Place(context)), 0.5);
  EXPECT_FALSE(accepts(format, 0.));
  EXPECT_FALSE(accepts(format, "Auto"));
}

TEST(ListOf, RefusesTooFewEntries)
{
  EXPECT_TRUE(accepts(list_of(count(), 1), Json::array({1})));
  EXPECT_FALSE(accepts(list_of(count(), 1), Json::array()));
}

TEST(ExistingFile, IsLookedForInFolderOfInput)
{
  InputContext here;
  here.folder = "/nowhere";
  try
  {
    existing_file().read("a.stl", Place(here).key("stl"));
    FAIL();
  }
  catch (const InputError& error)
  {
    EXPECT_EQ(std::string(error.what()).substr(0, 44), "stl: there is no file \"/nowhere/a.stl\"; corr");
  }
}

TEST(OutputFolder, MustLieBelowTheRun)
{
  EXPECT_TRUE(accepts(output_folder(), "vtk/soil"));
  EXPECT_FALSE(accepts(output_folder(), "/tmp"));
  EXPECT_FALSE(accepts(output_folder(), "a/../../b"));
  EXPECT_FALSE(accepts(output_folder(), ""));
}

TEST(EditDistance, CountsErrors)
{
  EXPECT_EQ(edit_distance("gravity", "gravity"), 0u);
  EXPECT_EQ(edit_distance("gravty", "gravity"), 1u);
  EXPECT_EQ(edit_distance("garvity", "gravity"), 1u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("Load_Steps", "load steps"), 0u);
}

TEST(Nearest, ReturnsNothingIfNoWordIsNear)
{
  EXPECT_EQ(nearest("tolerence", {"tolerance", "poor factor"}), "tolerance");
  EXPECT_EQ(nearest("v", {"E", "nu"}), "");
  EXPECT_EQ(nearest("weight", {"tolerance", "poor factor"}), "");
}
