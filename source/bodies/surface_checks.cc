#include "overlapping_boxes.h"
#include "surface_crossing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/bodies/surface.h>
#include <numeric>

namespace kedge
{
namespace
{
std::string at(const Eigen::Vector3d& x) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]); }

/// Throws InputError with the name of the surface in front of each problem.
struct Refusal
{
  std::string path, name;
  [[noreturn]] void operator()(const std::string& problem, const std::string& remedy) const
  {
    throw InputError(path, (name.empty() ? "" : name + ": ") + problem, remedy);
  }
};

std::string and_others(std::size_t count) { return count > 1 ? fmt::format(" (one of {} such places)", count) : ""; }

/// A side of a triangle with its undirected edge; sorting brings the sides of one edge together.
struct Side
{
  unsigned int low, high, triangle;
  bool upwards; ///< runs from low to high
  bool operator<(const Side& other) const { return std::tie(low, high) < std::tie(other.low, other.high); }
  bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Side> sorted_sides(const TriangleMesh& mesh)
{
  std::vector<Side> sides;
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
    for (unsigned int i = 0; i < 3; ++i)
    {
      const unsigned int a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::stable_sort(sides.begin(), sides.end());
  return sides;
}

void check_triangles(const TriangleMesh& mesh, double resolution, const Refusal& refuse)
{
  if (mesh.triangles.empty())
    refuse("holds no triangles", "export the body as a closed triangulated surface");
  std::size_t degenerate = 0, first = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
  {
    const auto& [i, j, k] = mesh.triangles[t];
    const Eigen::Vector3d &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
    if (!(a + b + c).allFinite())
      refuse(fmt::format("triangle {} has a coordinate that is not a finite number", t + 1),
             "export the surface again");
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    if ((b - a).cross(c - a).norm() <= resolution * longest && degenerate++ == 0)
      first = t;
  }
  if (degenerate == 0)
    return;
  const auto& [i, j, k] = mesh.triangles[first];
  refuse(fmt::format("triangle {} has no area: its corners {}, {} and {} lie on one line or coincide{}", first + 1,
                     at(mesh.vertices[i]), at(mesh.vertices[j]), at(mesh.vertices[k]), and_others(degenerate)),
         "remesh the surface or remove such triangles");
}

/// Every edge must belong to two triangles, which pass it in opposite directions.
void check_edges(const TriangleMesh& mesh, const std::vector<Side>& sides, const Refusal& refuse)
{
  std::size_t open = 0, crowded = 0, opposed = 0;
  const Side *first_open = nullptr, *first_crowded = nullptr, *first_opposed = nullptr;
  const auto note = [](std::size_t& count, const Side*& first, const Side& side)
  {
    if (count++ == 0)
      first = &side;
  };
  // The sides of one edge stand next to each other: count them and keep the first edge of each problem.
  for (std::size_t i = 0, j = 0; i < sides.size(); i = j)
  {
    for (j = i; j < sides.size() && sides[j].same_edge(sides[i]);)
      ++j;
    if (j - i == 1)
      note(open, first_open, sides[i]);
    else if (j - i > 2)
      note(crowded, first_crowded, sides[i]);
    else if (sides[i].upwards == sides[i + 1].upwards)
      note(opposed, first_opposed, sides[i]);
  }
  // Report the worst problem first: an edge with too many triangles, then a hole, then opposite orientations.
  const auto where = [&](const Side& side, std::size_t count)
  {
    return fmt::format("the edge from {} to {}{}", at(mesh.vertices[side.low]), at(mesh.vertices[side.high]),
                       and_others(count));
  };
  if (crowded > 0)
    refuse("not manifold: more than two triangles meet at " + where(*first_crowded, crowded),
           "unite the parts that touch there, or move them apart");
  if (open > 0)
    refuse("not closed: only one triangle holds " + where(*first_open, open), "close the hole");
  if (opposed > 0)
    refuse("the triangles on either side of " + where(*first_opposed, opposed) + " face opposite sides",
           "orient all triangles outwards");
}

/// Union-find over numbers 0..n-1.
class Groups
{
public:
  explicit Groups(std::size_t n) : parent(n) { std::iota(parent.begin(), parent.end(), 0u); }
  unsigned int root(unsigned int i)
  {
    while (parent[i] != i)
      i = parent[i] = parent[parent[i]];
    return i;
  }
  void join(unsigned int i, unsigned int j) { parent[root(i)] = root(j); }

private:
  std::vector<unsigned int> parent;
};

/// The triangles around a vertex must form one fan. Corners joined across edges then make one group per vertex.
void check_vertices(const TriangleMesh& mesh, const std::vector<Side>& sides, const Refusal& refuse)
{
  const auto corner = [&](unsigned int t, unsigned int v)
  {
    const auto& triangle = mesh.triangles[t];
    return static_cast<unsigned int>(3 * t + (std::find(triangle.begin(), triangle.end(), v) - triangle.begin()));
  };
  Groups corners(3 * mesh.triangles.size());
  for (std::size_t i = 0; i + 1 < sides.size(); i += 2) // check_edges: sides come in pairs
    for (const unsigned int v : {sides[i].low, sides[i].high})
      corners.join(corner(sides[i].triangle, v), corner(sides[i + 1].triangle, v));

  constexpr unsigned int none = -1;
  std::vector<unsigned int> fan(mesh.vertices.size(), none);
  for (unsigned int t = 0; t < mesh.triangles.size(); ++t)
    for (unsigned int i = 0; i < 3; ++i)
    {
      const unsigned int v = mesh.triangles[t][i], root = corners.root(3 * t + i);
      if (fan[v] == none)
        fan[v] = root;
      else if (fan[v] != root)
        refuse("not manifold: two parts of the surface touch in the single point " + at(mesh.vertices[v]),
               "unite the parts or move them apart");
    }
}

/// Shell (connected part) of every triangle, numbered from 0.
std::vector<unsigned int> number_shells(const TriangleMesh& mesh, unsigned int& n_shells)
{
  Groups vertices(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles)
  {
    vertices.join(a, b);
    vertices.join(a, c);
  }
  constexpr unsigned int none = -1;
  std::vector<unsigned int> number(mesh.vertices.size(), none), shells;
  n_shells = 0;
  for (const auto& triangle : mesh.triangles)
  {
    unsigned int& shell = number[vertices.root(triangle[0])];
    if (shell == none)
      shell = n_shells++;
    shells.push_back(shell);
  }
  return shells;
}

/// Solid angle of a triangle seen from the origin (van Oosterom & Strackee 1983, doi 10.1109/TBME.1983.325207).
double solid_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2. * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

struct Shell
{
  std::vector<std::size_t> triangles;
  Eigen::Vector3d point; ///< one of its corners
  Eigen::AlignedBox3d box;
  double volume = 0.;
};

/// The corners of a triangle seen from x.
std::array<Eigen::Vector3d, 3> seen_from(const Eigen::Vector3d& x, const TriangleMesh& mesh, const std::size_t triangle)
{
  const auto& [i, j, k] = mesh.triangles[triangle];
  return {mesh.vertices[i] - x, mesh.vertices[j] - x, mesh.vertices[k] - x};
}

std::vector<Shell> find_shells(const TriangleMesh& mesh)
{
  unsigned int n_shells;
  const std::vector<unsigned int> number = number_shells(mesh, n_shells);
  std::vector<Shell> shells(n_shells);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
  {
    Shell& shell = shells[number[t]];
    if (shell.triangles.empty())
      shell.point = mesh.vertices[mesh.triangles[t][0]];
    shell.triangles.push_back(t);
    for (const unsigned int vertex : mesh.triangles[t])
      shell.box.extend(mesh.vertices[vertex]);
    const auto [a, b, c] = seen_from(shell.point, mesh, t);
    shell.volume += a.dot(b.cross(c)) / 6.;
  }
  return shells;
}

/// How often each shell lies within others: around its point, how often the surface of the others winds. A shell winds
/// around no point outside its box.
std::vector<long> depths(const std::vector<Shell>& shells, const TriangleMesh& mesh)
{
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Shell& shell : shells)
    boxes.push_back(shell.box);

  std::vector<double> angles(shells.size(), 0.);
  const auto add_angle = [&](const unsigned int inner, const unsigned int outer)
  {
    if (boxes[outer].contains(shells[inner].point))
      for (const std::size_t t : shells[outer].triangles)
      {
        const auto [a, b, c] = seen_from(shells[inner].point, mesh, t);
        angles[inner] += solid_angle(a, b, c);
      }
  };
  for_overlapping_pairs(boxes,
                        [&](const unsigned int i, const unsigned int j)
                        {
                          add_angle(i, j);
                          add_angle(j, i);
                        });

  std::vector<long> depths;
  for (const double angle : angles)
    depths.push_back(std::lround(angle / (4. * M_PI)));
  return depths;
}

/// A shell must have a positive volume and lie outside all others, or a negative volume (a cavity) and lie inside one.
void check_orientation(const TriangleMesh& mesh, const Refusal& refuse)
{
  const std::vector<Shell> shells = find_shells(mesh);
  const std::vector<long> depth = depths(shells, mesh);
  for (std::size_t i = 0; i < shells.size(); ++i)
  {
    const Shell& shell = shells[i];
    const Eigen::Vector3d& x = shell.point;
    const std::string part = shells.size() == 1 ? "" : fmt::format(" in the part that holds {}", at(x));
    if (shell.volume < 0. && depth[i] != 1)
      refuse(fmt::format("inverted: the triangles face inwards{} (volume {:.6g} m3, for example at {})", part,
                         shell.volume, at(x)),
             "reverse the order of the corners of every triangle there");
    if (shell.volume >= 0. && depth[i] != 0)
      refuse("the part that holds " + at(x) + " lies inside another part and is not a cavity",
             "remove it, or reverse its triangles if it is a cavity");
  }
}
} // namespace

void check_connections(const TriangleMesh& mesh, const std::string& path, const std::string& name,
                       const double resolution)
{
  const Refusal refuse{path, name};
  check_triangles(mesh, resolution, refuse);
  const std::vector<Side> sides = sorted_sides(mesh);
  check_edges(mesh, sides, refuse);
  check_vertices(mesh, sides, refuse);
}

void check_surface(const TriangleMesh& mesh, const std::string& path, const std::string& name, double resolution)
{
  const Refusal refuse{path, name};
  check_connections(mesh, path, name, resolution);
  if (const std::optional<Crossing> crossing = find_crossing(mesh))
    refuse(fmt::format("crosses itself at {} (triangles {} and {})", at(crossing->position), crossing->triangles[0] + 1,
                       crossing->triangles[1] + 1),
           "unite overlapping parts into one surface");
  check_orientation(mesh, refuse);
}
} // namespace kedge
