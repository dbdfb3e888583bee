#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/bodies/surface.h>
#include <kedge/geometry/command.h>
#include <unistd.h>

namespace kedge
{
namespace
{
class GeometryCommand : public testing::Test
{
protected:
  const std::string file =
      (std::filesystem::temp_directory_path() / fmt::format("kedge-command-{}.stl", getpid())).string();
  ~GeometryCommand() override { std::filesystem::remove(file); }

  /// Runs "geometry <arguments> --output <file>" and returns what it prints.
  std::string run(const std::string& arguments)
  {
    CLI::App app;
    add_geometry_command(app);
    testing::internal::CaptureStdout();
    try
    {
      app.parse("geometry " + arguments + " --output " + file);
    }
    catch (...)
    {
      testing::internal::GetCapturedStdout();
      throw;
    }
    return testing::internal::GetCapturedStdout();
  }
};

TEST_F(GeometryCommand, WritesEveryBodyWithItsDefaults)
{
  for (const std::string body : {"plate", "frustum", "cone", "sphere", "box", "ac14 --part fluke", "ac14 --part shank"})
  {
    run(body);
    EXPECT_GT(mass_properties(read_stl(file, "stl")).volume, 0.) << body;
  }
}

TEST_F(GeometryCommand, PrintsMassForADensity)
{
  const std::string text = run("box --size 0.1 0.2 0.3 --density 8000");
  EXPECT_NE(text.find("volume    0.006 m3"), std::string::npos) << text;
  EXPECT_NE(text.find("mass      48 kg"), std::string::npos) << text;
}

TEST_F(GeometryCommand, TranslatesTheBody)
{
  const std::string text = run("plate --side 0.1 --thickness 0.01 --edge-radius 0.0025 --translate 1 -2 3.5");
  EXPECT_NE(text.find("extent    0.995 to 1.005, -2.05 to -1.95, 3.45 to 3.55 m"), std::string::npos) << text;
  const auto [lower, upper] = bounds(read_stl(file, "stl"));
  EXPECT_NEAR((lower - Eigen::Vector3d(0.995, -2.05, 3.45)).norm(), 0., 1e-6);
}

TEST_F(GeometryCommand, RefusesARadiusThatDoesNotFit)
{
  EXPECT_THROW(run("plate --thickness 0.01 --edge-radius 0.01"), InputError);
}

TEST_F(GeometryCommand, RefusesUnknownOptions) { EXPECT_THROW(run("plate --diameter 1"), CLI::ParseError); }

TEST_F(GeometryCommand, NeedsABody) { EXPECT_THROW(run(""), CLI::ParseError); }
} // namespace
} // namespace kedge
