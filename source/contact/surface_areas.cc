#include <Eigen/Geometry>
#include <algorithm>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <deal.II/numerics/rtree.h>
#include <kedge/base/communication.h>
#include <kedge/contact/surface_areas.h>

namespace kedge
{
namespace
{
/// Corners share the pieces up to this distance along the surface, in sizes of their particles: the steps of a
/// staircase of boxes are shorter.
constexpr double shares_within = 2.;
/// Cosine of the angle between the normals of a corner and of a piece from which on they are on one side.
constexpr double same_side = 0.5;
/// Length of a piece, in sizes of the smallest particle; longer where there would be more than so many pieces.
constexpr double piece_length = 0.5;
constexpr double most_pieces = 3e5;
/// A box covers a piece if it holds the point so far off the surface, in extents of the box across the surface, the box
/// being widened by this factor: deeper than a staircase, and across what a reference gap leaves open.
constexpr double looked_for_at = 0.6, widened = 1.2;

struct Piece
{
  Eigen::Vector3d place, normal; ///< m; unit, outwards
  double area;                   ///< m2; 2-D: m
};

/// The pieces of a surface in world axes that lie in a box; none is longer than `length`.
class Pieces
{
public:
  Pieces(const Pose& pose, const Eigen::AlignedBox3d& box, const double length) : pose(pose), box(box), length(length)
  {
  }

  void add_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
  {
    const Eigen::Vector3d across = (b - a).cross(c - a);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int n = std::max(1., std::ceil(longest / length));
    const double area = 0.5 * across.norm() / (n * n);
    const Eigen::Vector3d along = (b - a) / n, aside = (c - a) / n;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j)
      {
        add(a + (i + 1. / 3.) * along + (j + 1. / 3.) * aside, across.normalized(), area);
        if (i + j + 1 < n)
          add(a + (i + 2. / 3.) * along + (j + 2. / 3.) * aside, across.normalized(), area);
      }
  }

  /// Of the outline of a prism along y.
  void add_side(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& normal)
  {
    const int n = std::max(1., std::ceil((b - a).norm() / length));
    for (int i = 0; i < n; ++i)
    {
      Eigen::Vector3d place = a + (i + 0.5) / n * (b - a);
      place[1] = 0.;
      add(place, normal, (b - a).norm() / n);
    }
  }

  std::vector<Piece> all;

private:
  void add(const Eigen::Vector3d& place, const Eigen::Vector3d& normal, const double area)
  {
    const Eigen::Vector3d x = pose.to_world(place);
    if (box.contains(x))
      all.push_back({x, pose.direction_to_world(normal), area});
  }

  const Pose& pose;
  const Eigen::AlignedBox3d& box;
  double length;
};

std::vector<Piece> cut(const WeldedSurface& welded, const Pose& pose, const Eigen::AlignedBox3d& box,
                       const double length, const unsigned int dim)
{
  const TriangleMesh& mesh = welded.surface.mesh();
  Pieces pieces(pose, box, length);
  double end = 0.; // of a prism, whose mean plane is that of the analysis
  for (const Eigen::Vector3d& vertex : mesh.vertices)
    end = std::max(end, vertex[1]);
  for (const auto& t : mesh.triangles)
  {
    const Eigen::Vector3d x[] = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    if (dim == 3)
    {
      pieces.add_triangle(x[0], x[1], x[2]);
      continue;
    }
    const Eigen::Vector3d normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    for (int i = 0; i < 3 && std::abs(normal[1]) < 0.5; ++i) // of its two triangles one has the side at this end
      if (x[i][1] == end && x[(i + 1) % 3][1] == end)
        pieces.add_side(x[i], x[(i + 1) % 3], normal);
  }
  return std::move(pieces.all);
}

dealii::Point<3> point(const Eigen::Vector3d& x) { return {x[0], x[1], x[2]}; }

dealii::BoundingBox<3> box_around(const Eigen::Vector3d& x, const Eigen::Vector3d& half)
{
  return {{point(x - half), point(x + half)}};
}

/// Places or boxes of soil by number, to be found by where they are.
template <typename Entry> using Register = std::vector<std::pair<Entry, unsigned int>>;

/// Calls visit(number) for the entries of a tree that touch a box.
template <typename Tree, typename Visit>
void for_each_in(const Tree& tree, const dealii::BoundingBox<3>& box, const Visit& visit)
{
  std::for_each(tree.qbegin(boost::geometry::index::intersects(box)), tree.qend(),
                [&](const auto& entry) { visit(entry.second); });
}

/// Whether soil is at the outside of a piece. `half` is that of the largest box there may be.
template <typename Tree>
bool is_covered(const Piece& piece, const std::vector<SoilBox>& boxes, const Tree& tree, const Eigen::Vector3d& half)
{
  bool found = false;
  const Eigen::Vector3d reach = (2. * looked_for_at * half.norm() + half.maxCoeff()) * Eigen::Vector3d::Ones();
  for_each_in(tree, box_around(piece.place, reach),
              [&](const unsigned int b)
              {
                const SoilBox& box = boxes[b];
                const double across = 2. * box.half_width.dot(piece.normal.cwiseAbs());
                const Eigen::Vector3d x = piece.place + looked_for_at * across * piece.normal - box.centre;
                found = found || (x.cwiseAbs().array() <= widened * box.half_width.array()).all();
              });
  return found;
}

/// What the corners around a piece have of it: visit(number, share); not yet divided by their sum.
template <typename Tree, typename Visit>
void share_piece(const Piece& piece, const std::vector<CarryingCorner>& corners,
                 const std::vector<Eigen::Vector3d>& normals, const Tree& tree, const double largest,
                 const Visit& visit)
{
  for_each_in(tree, box_around(piece.place, shares_within * largest * Eigen::Vector3d::Ones()),
              [&](const unsigned int c)
              {
                if (normals[c].dot(piece.normal) < same_side)
                  return;
                const Eigen::Vector3d off = corners[c].position - piece.place;
                const double along = (off - off.dot(piece.normal) * piece.normal).norm();
                const double near = 1. - along / (shares_within * corners[c].size);
                if (near > 0.)
                  visit(c, corners[c].weight * near * near);
              });
}
} // namespace

std::vector<double> share_area(const RigidSystems& bodies, const WeldedSurface& welded,
                               const std::vector<CarryingCorner>& corners, const std::vector<SoilBox>& boxes,
                               const unsigned int dim, const MPI_Comm communicator)
{
  std::vector<double> area(corners.size(), 0.);
  const Pose& pose = bodies.points[welded.point].pose;
  double limits[9]; // smallest and largest size, largest box, and minus the lower and the upper ends of the corners
  std::fill(std::begin(limits), std::end(limits), -INFINITY);
  for (const CarryingCorner& corner : corners)
  {
    limits[0] = std::max(limits[0], -corner.size);
    limits[1] = std::max(limits[1], corner.size);
    for (int d = 0; d < 3; ++d)
    {
      limits[3 + d] = std::max(limits[3 + d], -corner.position[d]);
      limits[6 + d] = std::max(limits[6 + d], corner.position[d]);
    }
  }
  for (const SoilBox& box : boxes)
    limits[2] = std::max(limits[2], box.half_width.maxCoeff());
  MPI_Allreduce(MPI_IN_PLACE, limits, 9, MPI_DOUBLE, MPI_MAX, communicator);
  if (!(limits[1] > 0.)) // nothing carries
    return area;
  const double largest = limits[1];
  const Eigen::Vector3d margin = shares_within * largest * Eigen::Vector3d::Ones();
  Eigen::AlignedBox3d around(-Eigen::Vector3d(limits[3], limits[4], limits[5]) - margin,
                             Eigen::Vector3d(limits[6], limits[7], limits[8]) + margin);
  const double whole = mass_properties(welded.surface.mesh()).area;
  const double length = std::max(-piece_length * limits[0], dim == 3 ? std::sqrt(2. * whole / most_pieces) : 0.);
  const std::vector<Piece> pieces = cut(welded, pose, around, length, dim);

  Register<dealii::Point<3>> places;
  std::vector<Eigen::Vector3d> normals;
  for (const CarryingCorner& corner : corners)
  {
    places.emplace_back(point(corner.position), places.size());
    normals.push_back(pose.direction_to_world(welded.surface.closest_point(pose.to_body(corner.position)).normal));
  }
  Register<dealii::BoundingBox<3>> soil;
  for (const SoilBox& box : boxes)
    soil.emplace_back(box_around(box.centre, box.half_width), soil.size());
  const auto corner_tree = dealii::pack_rtree(places);
  const auto soil_tree = dealii::pack_rtree(soil);

  // of every piece whether soil covers it, and the sum of what its corners ask for
  std::vector<double> sums(2 * pieces.size(), 0.);
  const Eigen::Vector3d half = limits[2] * Eigen::Vector3d::Ones();
  for (std::size_t i = 0; i < pieces.size(); ++i)
  {
    sums[2 * i] = is_covered(pieces[i], boxes, soil_tree, half);
    share_piece(pieces[i], corners, normals, corner_tree, largest,
                [&](unsigned int, const double share) { sums[2 * i + 1] += share; });
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), message_length(sums.size()), MPI_DOUBLE, MPI_SUM, communicator);
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (sums[2 * i] > 0. && sums[2 * i + 1] > 0.)
      share_piece(pieces[i], corners, normals, corner_tree, largest,
                  [&](const unsigned int c, const double share)
                  { area[c] += pieces[i].area * share / sums[2 * i + 1]; });
  return area;
}
} // namespace kedge
