#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <kedge/base/exceptions.h>
#include <kedge/bodies/surface.h>
#include <limits>
#include <string_view>

namespace kedge
{
namespace
{
/// Coarsest resolution of the coordinates, over the largest edge of the body's box.
constexpr double coarsest = 1e-3;

constexpr std::size_t header_size = 84, facet_size = 50; // bytes of binary STL

std::uint32_t announced_facets(std::string_view content)
{
  std::uint32_t n;
  std::memcpy(&n, content.data() + 80, 4);
  return n;
}

/// A binary header may also start with "solid", so only the size of the file is a certain sign.
bool is_binary(std::string_view content)
{
  if (content.size() < header_size)
    return false;
  if (content.size() == header_size + facet_size * announced_facets(content))
    return true;
  return std::any_of(content.begin(), content.end(), [](unsigned char c) { return c < 32 && !std::isspace(c); });
}

TriangleMesh parse_binary(std::string_view content, const std::string& json_path, const std::string& file)
{
  const std::size_t announced = announced_facets(content), held = (content.size() - header_size) / facet_size;
  if (content.size() < header_size + facet_size * announced)
    throw InputError(
        json_path,
        fmt::format("{}: truncated: announces {} triangles but ends within triangle {}", file, announced, held + 1),
        "copy or export the file again");
  if (content.size() > header_size + facet_size * announced)
    throw InputError(json_path,
                     fmt::format("{}: not a binary STL: announces {} triangles, but {} bytes follow them", file,
                                 announced, content.size() - header_size - facet_size * announced),
                     "export the file again");

  TriangleMesh soup;
  for (std::size_t t = 0; t < announced; ++t)
  {
    // Skip the normal: it follows from the order of the corners.
    std::array<float, 9> x;
    std::memcpy(x.data(), content.data() + header_size + facet_size * t + 12, 36);
    for (unsigned int i = 0; i < 3; ++i)
      soup.vertices.emplace_back(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    const unsigned int first = 3 * t;
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// Words of an ASCII STL; keeps the line for error messages.
class Words
{
public:
  Words(std::string_view text, const std::string& json_path, const std::string& file)
      : text(text), json_path(json_path), file(file)
  {
  }

  /// The next word in lower case; empty at the end.
  std::string next()
  {
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at])))
      line += text[at++] == '\n';
    std::string word;
    while (at < text.size() && !std::isspace(static_cast<unsigned char>(text[at])))
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(text[at++])));
    return word;
  }

  void skip_line() { at = std::min(text.find('\n', at), text.size()); }

  void expect(const std::string& expected)
  {
    const std::string word = next();
    if (word != expected)
      fail(word, "\"" + expected + "\"");
  }

  double number()
  {
    const std::string word = next();
    double value;
    const char *begin = word.data() + (word[0] == '+'), *end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || stop != end)
      fail(word, "a number");
    return value;
  }

  [[noreturn]] void fail(const std::string& word, const std::string& expected) const
  {
    if (word.empty())
      throw InputError(json_path,
                       fmt::format("{}: truncated: ends at line {} where {} should follow", file, line, expected),
                       "copy or export the file again");
    throw InputError(json_path,
                     fmt::format("{}: line {}: found \"{}\" instead of {}", file, line, word.substr(0, 40), expected),
                     "export the body as ASCII or binary STL; Kedge reads no other format");
  }

private:
  std::string_view text;
  std::string json_path, file;
  std::size_t at = 0, line = 1;
};

TriangleMesh parse_ascii(std::string_view content, const std::string& json_path, const std::string& file)
{
  TriangleMesh soup;
  Words words(content, json_path, file);
  words.expect("solid");
  words.skip_line(); // name of the solid
  while (true)
  {
    std::string word = words.next();
    if (word == "endsolid")
    {
      words.skip_line();
      word = words.next();
      if (word.empty())
        return soup;
      if (word != "solid")
        words.fail(word, "\"solid\" or the end of the file");
      words.skip_line();
      continue;
    }
    if (word != "facet")
      words.fail(word, "\"facet\" or \"endsolid\"");
    // The normal follows from the corners; some exporters write nonsense here, so it is not even parsed.
    words.skip_line();
    words.expect("outer");
    words.expect("loop");
    const unsigned int first = soup.vertices.size();
    for (unsigned int i = 0; i < 3; ++i)
    {
      words.expect("vertex");
      const double x = words.number(), y = words.number(), z = words.number();
      soup.vertices.emplace_back(x, y, z);
    }
    soup.triangles.push_back({first, first + 1, first + 2});
    words.expect("endloop");
    words.expect("endfacet");
  }
}

/// Largest edge of the box around the vertices, m.
double extent_of(const TriangleMesh& mesh)
{
  const auto [lower, upper] = bounds(mesh);
  return (upper - lower).maxCoeff();
}
} // namespace

TriangleMesh read_stl(const std::string& file, const std::string& json_path)
{
  std::ifstream stream(file, std::ios::binary);
  std::string content;
  if (stream)
    content.assign(std::istreambuf_iterator<char>(stream), {});
  if (!stream || stream.bad())
    throw InputError(json_path, file + ": cannot be read", "check the name and the permissions of the file");
  if (content.empty())
    throw InputError(json_path, file + ": is empty", "copy or export the file again");

  const TriangleMesh soup =
      is_binary(content) ? parse_binary(content, json_path, file) : parse_ascii(content, json_path, file);
  double largest = 0.;
  for (const Eigen::Vector3d& x : soup.vertices)
  {
    if (!x.allFinite())
      throw InputError(json_path,
                       fmt::format("{}: triangle {} has a coordinate that is not a finite number", file,
                                   (&x - soup.vertices.data()) / 3 + 1),
                       "export the surface again");
    largest = std::max(largest, x.cwiseAbs().maxCoeff());
  }
  // Most programs store coordinates in single precision: the resolution is a few of its roundings.
  const double resolution = 2. * std::numeric_limits<float>::epsilon() * largest;
  if (const double extent = extent_of(soup); extent > 0. && resolution > coarsest * extent)
    throw InputError(
        json_path,
        fmt::format("{}: coordinates of up to {:.3g} m leave single precision, in which most programs write "
                    "them, {:.2g} m apart, which is too coarse for a body of {:.3g} m",
                    file, largest, resolution, extent),
        "export the surface near the origin and move it with \"offset\"");
  TriangleMesh mesh = merge_vertices(soup, resolution);
  check_surface(mesh, json_path, file, resolution / 4.);
  return mesh;
}

void write_stl(const TriangleMesh& mesh, const std::string& file)
{
  std::string content = "binary STL, unit m";
  content.resize(80, ' ');
  const auto append = [&](const auto& value) { content.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  append(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& [i, j, k] : mesh.triangles)
  {
    const Eigen::Vector3d &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    for (const Eigen::Vector3d& x : {normal, a, b, c})
      for (int d = 0; d < 3; ++d)
        append(static_cast<float>(x[d]));
    append(std::uint16_t(0));
  }
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  if (!stream.flush())
    throw FileError(file, "cannot be written");
}
} // namespace kedge
