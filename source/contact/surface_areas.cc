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
/// Lengths that differ by less than this share are equal, so that round-off, which ranks do not have in common, does
/// not choose where a part is halved.
constexpr double equal_lengths = 1e-9;
/// Length of a piece, in sizes of the smallest particle whose corner shares it.
constexpr double piece_length = 0.5 * (1. + equal_lengths);
/// A box covers a piece if it holds the point so far off the surface, in extents of the box across the surface, the box
/// being widened by this factor: deeper than a staircase, and across what a reference gap leaves open.
constexpr double looked_for_at = 0.6, widened = 1.2;
/// What a corner may stand for, in its weights: the lone tips of the steepest staircases stand for little less. Corners
/// that are about to lose the surface do not take over all that others have lost.
constexpr double most_weights[] = {3., 8.}; // in the plane, in space
/// Others know of a corner or a box so far around their own, in the size of the largest particle.
constexpr double known_within = 8.;

using Box = dealii::BoundingBox<3>;
/// What reaches where, by number.
using Reaches = boost::geometry::index::rtree<std::pair<Box, unsigned int>, boost::geometry::index::rstar<16>>;

dealii::Point<3> point(const Eigen::Vector3d& x) { return {x[0], x[1], x[2]}; }

Box box_around(const Eigen::Vector3d& x, const double reach)
{
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(reach);
  return {{point(x - half), point(x + half)}};
}

template <typename Shape> bool reaches(const Reaches& tree, const Shape& shape)
{
  return tree.qbegin(boost::geometry::index::intersects(shape)) != tree.qend();
}

/// A part of a surface: a triangle, or in the plane a side of an outline.
struct Part
{
  std::array<Eigen::Vector3d, 3> corners; ///< world axes, m; a side has two
  unsigned int n;
  Eigen::Vector3d normal; ///< unit, outwards

  double area() const
  {
    const Eigen::Vector3d side = corners[1] - corners[0];
    return n == 2 ? side.norm() : 0.5 * side.cross(corners[2] - corners[0]).norm();
  }

  Eigen::Vector3d middle() const
  {
    return n == 2 ? Eigen::Vector3d(0.5 * (corners[0] + corners[1]))
                  : Eigen::Vector3d((corners[0] + corners[1] + corners[2]) / 3.);
  }

  /// The first corner of the longest edge.
  unsigned int longest() const
  {
    unsigned int first = 0;
    for (unsigned int i = 1; i < n; ++i)
      if (length(i) > (1. + equal_lengths) * length(first))
        first = i;
    return first;
  }

  double length(const unsigned int i) const { return (corners[(i + 1) % n] - corners[i]).norm(); }

  Box bounds() const
  {
    Eigen::Vector3d lower = corners[0], upper = corners[0];
    for (unsigned int i = 1; i < n; ++i)
    {
      lower = lower.cwiseMin(corners[i]);
      upper = upper.cwiseMax(corners[i]);
    }
    return {{point(lower), point(upper)}};
  }
};

/// All parts of a surface. In the plane a prism stands for an outline: of the two triangles of a side one has the side
/// at the prism's end.
std::vector<Part> parts_of(const WeldedSurface& welded, const Pose& pose, const unsigned int dim)
{
  const TriangleMesh& mesh = welded.surface.mesh();
  double end = 0.;
  for (const Eigen::Vector3d& vertex : mesh.vertices)
    end = std::max(end, vertex[1]);
  std::vector<Part> parts;
  for (const auto& t : mesh.triangles)
  {
    Eigen::Vector3d x[] = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    const Eigen::Vector3d across = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    const Eigen::Vector3d normal = pose.direction_to_world(across);
    if (dim == 3)
      parts.push_back({{pose.to_world(x[0]), pose.to_world(x[1]), pose.to_world(x[2])}, 3, normal});
    for (int i = 0; i < 3 && dim == 2 && std::abs(across[1]) < 0.5; ++i)
      if (const int j = (i + 1) % 3; x[i][1] == end && x[j][1] == end)
      {
        const auto in_plane = [&](Eigen::Vector3d place)
        {
          place[1] = 0.;
          return pose.to_world(place);
        };
        parts.push_back({{in_plane(x[i]), in_plane(x[j]), in_plane(x[i])}, 2, normal});
      }
  }
  return parts;
}

/// What a rank knows of all corners and boxes near its own corners.
struct Surroundings
{
  std::vector<CarryingCorner> corners; ///< its own ones first
  std::vector<SoilBox> boxes;
};

/// Sends to each rank those entries that lie in its box. Collective.
template <typename Entry, typename Place>
std::vector<Entry> hand_out(const std::vector<Entry>& mine, const std::vector<Eigen::AlignedBox3d>& box_of_rank,
                            const Place& place, const MPI_Comm communicator)
{
  std::vector<std::vector<Entry>> to_rank(box_of_rank.size());
  for (std::size_t r = 0; r < box_of_rank.size(); ++r)
    if (static_cast<int>(r) != rank_of(communicator))
      std::copy_if(mine.begin(), mine.end(), std::back_inserter(to_rank[r]),
                   [&](const Entry& entry) { return box_of_rank[r].contains(place(entry)); });
  std::vector<Entry> all = mine;
  const auto received = exchange_between_ranks(to_rank, communicator);
  for (std::size_t r = 0; r < received.size(); ++r)
    if (static_cast<int>(r) != rank_of(communicator))
      all.insert(all.end(), received[r].begin(), received[r].end());
  return all;
}

Surroundings look_around(const std::vector<CarryingCorner>& corners, const std::vector<SoilBox>& boxes,
                         const double largest, const MPI_Comm communicator)
{
  Eigen::AlignedBox3d mine;
  for (const CarryingCorner& corner : corners)
    mine.extend(corner.position());
  std::array<double, 6> bounds; // those of an empty box contain nothing
  for (int d = 0; d < 3; ++d)
  {
    bounds[d] = mine.min()[d] - known_within * largest;
    bounds[3 + d] = mine.max()[d] + known_within * largest;
  }
  std::vector<double> all(6 * size_of(communicator));
  MPI_Allgather(bounds.data(), 6, MPI_DOUBLE, all.data(), 6, MPI_DOUBLE, communicator);
  std::vector<Eigen::AlignedBox3d> box_of_rank;
  for (std::size_t r = 0; r < all.size() / 6; ++r)
    box_of_rank.emplace_back(Eigen::Map<const Eigen::Vector3d>(&all[6 * r]),
                             Eigen::Map<const Eigen::Vector3d>(&all[6 * r + 3]));
  return {hand_out(
              corners, box_of_rank, [](const CarryingCorner& corner) { return corner.position(); }, communicator),
          hand_out(
              boxes, box_of_rank, [](const SoilBox& box) { return box.centre(); }, communicator)};
}

/// Shares the pieces of a surface.
class Shares
{
public:
  Shares(const WeldedSurface& welded, const Pose& pose, const Surroundings& known, const std::size_t n_mine,
         const double largest, const unsigned int dim)
      : known(known), n_mine(n_mine), largest(largest), dim(dim), area(n_mine, 0.)
  {
    std::vector<std::pair<Box, unsigned int>> near_mine, near_all, near_boxes;
    for (unsigned int c = 0; c < known.corners.size(); ++c)
    {
      const CarryingCorner& corner = known.corners[c];
      normals.push_back(pose.direction_to_world(welded.surface.closest_point(pose.to_body(corner.position())).normal));
      near_all.emplace_back(box_around(corner.position(), shares_within * corner.size), c);
    }
    near_mine.assign(near_all.begin(), near_all.begin() + n_mine);
    for (unsigned int b = 0; b < known.boxes.size(); ++b)
    {
      const Eigen::Vector3d half = known.boxes[b].half_width();
      const double reach = 2. * looked_for_at * half.sum() + widened * half.maxCoeff();
      near_boxes.emplace_back(box_around(known.boxes[b].centre(), reach), b);
    }
    mine = Reaches(near_mine);
    all = Reaches(near_all);
    soil = Reaches(near_boxes);
  }

  /// Halves a part until its pieces are small, and shares those that are near corners of this rank. Pieces do not
  /// depend on the rank: those that are nearly small have only corners around them that all ranks with some there know.
  void add(const Part& part)
  {
    std::vector<Part> left{part};
    while (!left.empty())
    {
      const Part now = left.back();
      left.pop_back();
      const Box bounds = now.bounds();
      if (!reaches(mine, bounds))
        continue;
      const unsigned int i = now.longest(), j = (i + 1) % now.n;
      if (now.length(i) <= piece_length * smallest_near(bounds, now.length(i)))
      {
        share(now);
        continue;
      }
      Part first = now, second = now;
      first.corners[j] = second.corners[i] = 0.5 * (now.corners[i] + now.corners[j]);
      left.push_back(first);
      left.push_back(second);
    }
  }

  /// Of each corner of this rank.
  std::vector<double> take()
  {
    for (std::size_t c = 0; c < n_mine; ++c)
      area[c] = std::min(area[c], most_weights[dim - 2] * known.corners[c].weight);
    return std::move(area);
  }

private:
  /// Size of the smallest particle whose corner reaches into a box; zero for parts that are too long for any.
  double smallest_near(const Box& bounds, const double length) const
  {
    if (length > piece_length * largest)
      return 0.;
    double smallest = largest;
    std::for_each(all.qbegin(boost::geometry::index::intersects(bounds)), all.qend(),
                  [&](const auto& entry) { smallest = std::min(smallest, known.corners[entry.second].size); });
    return smallest;
  }

  /// Whether soil is at the outside.
  bool is_covered(const Eigen::Vector3d& place, const Eigen::Vector3d& normal) const
  {
    return std::any_of(soil.qbegin(boost::geometry::index::intersects(point(place))), soil.qend(),
                       [&](const auto& entry)
                       {
                         const SoilBox& box = known.boxes[entry.second];
                         const double across = 2. * box.half_width().dot(normal.cwiseAbs());
                         const Eigen::Vector3d x = place + looked_for_at * across * normal - box.centre();
                         for (int d = 0; d < 3; ++d)
                           if ((dim == 3 || d != 1) && std::abs(x[d]) > widened * box.half_width()[d])
                             return false;
                         return true;
                       });
  }

  void share(const Part& piece)
  {
    const Eigen::Vector3d place = piece.middle();
    if (!is_covered(place, piece.normal))
      return;
    claims.clear();
    double sum = 0.;
    std::for_each(all.qbegin(boost::geometry::index::intersects(point(place))), all.qend(),
                  [&](const auto& entry)
                  {
                    const CarryingCorner& corner = known.corners[entry.second];
                    if (normals[entry.second].dot(piece.normal) < same_side)
                      return;
                    const Eigen::Vector3d off = corner.position() - place;
                    const double along = (off - off.dot(piece.normal) * piece.normal).norm();
                    const double near = 1. - along / (shares_within * corner.size);
                    if (near <= 0.)
                      return;
                    claims.emplace_back(entry.second, corner.weight * near * near);
                    sum += claims.back().second;
                  });
    const double whole = piece.area();
    for (const auto& [c, claim] : claims)
      if (c < n_mine)
        area[c] += whole * claim / sum;
  }

  const Surroundings& known;
  std::size_t n_mine;
  double largest;
  unsigned int dim;
  std::vector<Eigen::Vector3d> normals;                ///< at the known corners
  Reaches mine, all, soil;                             ///< corners of this rank, all known ones, boxes
  std::vector<std::pair<unsigned int, double>> claims; ///< workspace
  std::vector<double> area;
};
} // namespace

std::vector<double> share_area(const RigidSystems& bodies, const WeldedSurface& welded,
                               const std::vector<CarryingCorner>& corners, const std::vector<SoilBox>& boxes,
                               const unsigned int dim, const MPI_Comm communicator)
{
  double largest = 0.;
  for (const CarryingCorner& corner : corners)
    largest = std::max(largest, corner.size);
  largest = max_over_ranks(largest, communicator);
  if (largest == 0.) // nothing carries
    return {};
  const Surroundings known = look_around(corners, boxes, largest, communicator);
  if (corners.empty())
    return {};
  const Pose& pose = bodies.points[welded.point].pose;
  Shares shares(welded, pose, known, corners.size(), largest, dim);
  for (const Part& part : parts_of(welded, pose, dim))
    shares.add(part);
  return shares.take();
}
} // namespace kedge
