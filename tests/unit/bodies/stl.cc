#include "shapes.h"
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <unistd.h>

namespace kedge
{
namespace
{
/// A file that the test removes at its end. Its name differs between parallel test runs.
class Stl : public testing::Test
{
protected:
  const std::string file =
      (std::filesystem::temp_directory_path() / fmt::format("kedge-test-{}.stl", getpid())).string();
  ~Stl() override { std::filesystem::remove(file); }

  void put(const std::string& content) { std::ofstream(file, std::ios::binary) << content; }

  std::string content() const
  {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  /// The message of the refusal; empty where the file is accepted.
  std::string refusal() const
  {
    try
    {
      read_stl(file, "rigid bodies[0].stl files[0].stl");
    }
    catch (const InputError& error)
    {
      EXPECT_EQ(error.path, "rigid bodies[0].stl files[0].stl");
      return error.what();
    }
    return "";
  }

  void expect_refusal(const std::string& part) const
  {
    const std::string message = refusal();
    EXPECT_NE(message.find(part), std::string::npos) << "the message is: " << message;
  }

  void expect_refusal_of(const TriangleMesh& mesh, const std::string& part)
  {
    write_stl(mesh, file);
    expect_refusal(part);
  }
};

std::string ascii(const TriangleMesh& mesh)
{
  std::string text = "solid a name with several words\n";
  for (const auto& triangle : mesh.triangles)
  {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const unsigned int v : triangle)
      text += fmt::format("   vertex {:e} {:e} {:e}\n", mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]);
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid a name\n";
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b)
{
  const unsigned int n = a.vertices.size();
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles)
    a.triangles.push_back({i + n, j + n, k + n});
  return a;
}

TriangleMesh turned_inside_out(TriangleMesh mesh)
{
  for (auto& triangle : mesh.triangles)
    std::swap(triangle[0], triangle[1]);
  return mesh;
}

TEST_F(Stl, BinaryRoundTripKeepsTheMesh)
{
  write_stl(test::unit_box(), file);
  const TriangleMesh mesh = read_stl(file, "stl");
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_DOUBLE_EQ(mass_properties(mesh).volume, 1.);
}

TEST_F(Stl, BinaryHeaderMayStartWithSolid)
{
  write_stl(test::unit_box(), file);
  std::string binary = content();
  binary.replace(0, 11, "solid facet");
  put(binary);
  EXPECT_EQ(read_stl(file, "stl").triangles.size(), 12u);
}

TEST_F(Stl, AsciiIsRead)
{
  put(ascii(test::unit_box()));
  EXPECT_EQ(read_stl(file, "stl").vertices.size(), 8u);
}

TEST_F(Stl, AsciiMayBeInCapitalsWithCarriageReturns)
{
  std::string text = ascii(test::unit_box());
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2)
    text.insert(i, "\r");
  for (char& c : text)
    c = std::toupper(c);
  put(text);
  EXPECT_EQ(read_stl(file, "stl").triangles.size(), 12u);
}

TEST_F(Stl, SeveralSolidsAreJoined)
{
  put(ascii(test::unit_box()) + ascii(test::box({2., 0., 0.}, {3., 1., 1.})));
  EXPECT_DOUBLE_EQ(mass_properties(read_stl(file, "stl")).volume, 2.);
}

TEST_F(Stl, VerticesApartByRoundingAreMerged)
{
  TriangleMesh soup;
  const TriangleMesh box = test::unit_box();
  for (const auto& triangle : box.triangles)
  {
    const unsigned int n = soup.vertices.size();
    for (unsigned int i = 0; i < 3; ++i)
      soup.vertices.push_back(box.vertices[triangle[i]] + Eigen::Vector3d::Constant(5e-8 * (n % 3)));
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  put(ascii(soup));
  EXPECT_EQ(read_stl(file, "stl").vertices.size(), 8u);
}

TEST_F(Stl, CavityIsAccepted)
{
  write_stl(joined(test::unit_box(), turned_inside_out(test::box({.4, .4, .4}, {.6, .6, .6}))), file);
  EXPECT_NEAR(mass_properties(read_stl(file, "stl")).volume, 1. - 0.008, 1e-7);
}

TEST_F(Stl, WritingIntoAMissingFolderIsAFileError)
{
  EXPECT_THROW(write_stl(test::unit_box(), "/nowhere/body.stl"), FileError);
}

TEST_F(Stl, MissingFileIsRefused) { expect_refusal("cannot be read"); }

TEST_F(Stl, EmptyFileIsRefused)
{
  put("");
  expect_refusal("is empty");
}

TEST_F(Stl, GarbageTextIsRefusedWithItsLine)
{
  put("\nthe quick brown fox jumps over the lazy dog, and again: the quick brown fox jumps over the lazy dog\n");
  expect_refusal("line 2: found \"the\" instead of \"solid\"");
}

TEST_F(Stl, BadNumberIsRefusedWithItsLine)
{
  std::string text = ascii(test::unit_box());
  text.replace(text.find("vertex") + 7, 12, "0.0x0000000 ");
  put(text);
  expect_refusal("line 4: found \"0.0x0000000\" instead of a number");
}

TEST_F(Stl, NoTrianglesAreRefused)
{
  put("solid\nendsolid\n");
  expect_refusal("holds no triangles");
}

TEST_F(Stl, TruncatedBinaryIsRefused)
{
  write_stl(test::unit_box(), file);
  put(content().substr(0, 84 + 5 * 50 + 20));
  expect_refusal("truncated: announces 12 triangles but ends within triangle 6");
}

TEST_F(Stl, TruncatedAsciiIsRefusedWithItsLine)
{
  const std::string text = ascii(test::unit_box());
  put(text.substr(0, text.find("endloop")));
  expect_refusal("truncated: ends at line 7 where \"endloop\" should follow");
}

TEST_F(Stl, AsciiWithoutItsEndIsRefused)
{
  const std::string text = ascii(test::unit_box());
  put(text.substr(0, text.find("endsolid")));
  expect_refusal("truncated");
}

TEST_F(Stl, NotANumberIsRefused)
{
  write_stl(test::unit_box(), file);
  std::string binary = content();
  const float nan = std::nanf("");
  std::memcpy(binary.data() + 84 + 2 * 50 + 12, &nan, 4);
  put(binary);
  expect_refusal("triangle 3 has a coordinate that is not a finite number");
}

TEST_F(Stl, CoordinatesFarFromTheOriginAreRefusedForWhatTheyAre)
{
  TriangleMesh mesh = test::unit_box();
  for (Eigen::Vector3d& x : mesh.vertices)
    x[0] += 4e6;
  put(ascii(mesh));
  expect_refusal("near the origin");
}

TEST_F(Stl, DegenerateTriangleIsRefusedWithItsCorners)
{
  TriangleMesh mesh = test::unit_box();
  mesh.vertices.emplace_back(0.5, 0., 0.); // on the edge 0-1
  mesh.triangles.push_back({0, 1, 8});
  expect_refusal_of(mesh, "triangle 13 has no area: its corners (0, 0, 0), (1, 0, 0) and (0.5, 0, 0)");
}

TEST_F(Stl, OpenSurfaceIsRefusedWithTheEdge)
{
  TriangleMesh mesh = test::unit_box();
  mesh.triangles.pop_back(); // 1 7 5
  expect_refusal_of(mesh, "not closed: only one triangle holds the edge from (1, 0, 0)");
}

TEST_F(Stl, InvertedSurfaceIsRefused)
{
  expect_refusal_of(turned_inside_out(test::box({1., 2., 3.}, {2., 3., 4.})), "inverted: the triangles face inwards");
}

TEST_F(Stl, OneInvertedPartIsRefusedWithAPointOfIt)
{
  expect_refusal_of(
      joined(test::box({0., 0., 0.}, {2., 2., 2.}), turned_inside_out(test::box({5., 0., 0.}, {6., 1., 1.}))),
      "inverted: the triangles face inwards in the part that holds (5, ");
}

TEST_F(Stl, OneTurnedTriangleIsRefusedWithItsEdge)
{
  TriangleMesh mesh = test::unit_box();
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  expect_refusal_of(mesh, "the triangles on either side of the edge from (");
}

TEST_F(Stl, MoreThanTwoTrianglesOnAnEdgeAreRefused)
{
  expect_refusal_of(joined(test::unit_box(), test::box({1., 1., 0.}, {2., 2., 1.})),
                    "more than two triangles meet at the edge from (1, 1, 0) to (1, 1, 1)");
}

TEST_F(Stl, PartsThatTouchInAPointAreRefused)
{
  expect_refusal_of(joined(test::unit_box(), test::box({1., 1., 1.}, {2., 2., 2.})), "single point (1, 1, 1)");
}

TEST_F(Stl, SelfCrossingIsRefusedWithAPointOnBothParts)
{
  // A thin bar through the face x = 1 of the box: only there do the two surfaces meet.
  write_stl(joined(test::unit_box(), test::box({0.5, 0.4, 0.4}, {1.5, 0.5, 0.5})), file);
  const std::string message = refusal();
  EXPECT_NE(message.find("crosses itself at (1, 0."), std::string::npos) << message;
}

TEST_F(Stl, SurfaceFoldedOntoItselfIsRefused)
{
  // The top corner is pushed through the bottom: the spike overlaps its own base.
  TriangleMesh mesh = test::sphere(1., 2);
  mesh.vertices[0] *= -2.;
  expect_refusal_of(mesh, "crosses itself at (");
}

TEST_F(Stl, PartInsideAnotherIsRefused)
{
  expect_refusal_of(joined(test::unit_box(), test::box({.4, .4, .4}, {.6, .6, .6})), "lies inside another part");
}
} // namespace
} // namespace kedge
