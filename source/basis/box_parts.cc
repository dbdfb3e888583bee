#include <algorithm>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/basis/box_parts.h>

namespace kedge
{
namespace
{
// Because of round-off, a box that ends on a face may reach slightly across it. Such a sliver would activate nodes
// without stiffness.
constexpr double smallest_part = 1e-11;
constexpr double point_box = 1e-6;   // of the particle's
constexpr double least_width = 1e-4; // that is left of a box at the end of the window

template <int dim> struct Box
{
  std::array<double, dim> lower, upper; ///< m

  bool is_empty() const
  {
    for (unsigned int d = 0; d < dim; ++d)
      if (upper[d] <= lower[d])
        return true;
    return false;
  }

  /// Reaches out to another box.
  void include(const Box& other)
  {
    for (unsigned int d = 0; d < dim; ++d)
    {
      lower[d] = std::min(lower[d], other.lower[d]);
      upper[d] = std::max(upper[d], other.upper[d]);
    }
  }
};

/// A box that would reach beyond the window shrinks on both sides, down to a point. So its particle moves as the soil
/// where it is does, and never through a face that holds the soil: the mean over what is inside would pull it along
/// with the soil in front of the face.
template <int dim>
Box<dim> shrink(const LeafTable<dim>& table, const std::array<double, dim>& centre,
                const std::array<double, dim>& half_width)
{
  Box<dim> box;
  for (unsigned int d = 0; d < dim; ++d)
  {
    const double inside = std::min(centre[d] - table.lower_end(d), table.upper_end(d) - centre[d]);
    const double half = std::clamp(inside, least_width * half_width[d], half_width[d]);
    box.lower[d] = std::max(table.lower_end(d), centre[d] - half);
    box.upper[d] = std::min(table.upper_end(d), centre[d] + half);
  }
  return box;
}

template <int dim>
void append_parts(const LeafTable<dim>& table, const std::vector<unsigned int>& candidates, const Box<dim>& box,
                  BoxParts<dim>& parts)
{
  double whole = 1., total = 0.;
  for (unsigned int d = 0; d < dim; ++d)
    whole *= box.upper[d] - box.lower[d];
  const std::size_t first = parts.leaf.size();
  for (const unsigned int candidate : candidates)
  {
    const auto& leaf = table.leaves[candidate];
    double volume = 1.;
    std::array<double, dim> middle;
    for (unsigned int d = 0; d < dim && volume > 0.; ++d)
    {
      const double low = std::max(box.lower[d], leaf.lower[d]),
                   high = std::min(box.upper[d], leaf.lower[d] + leaf.size);
      volume *= std::max(0., high - low);
      middle[d] = 0.5 * (high + low);
    }
    if (volume > smallest_part * whole)
    {
      parts.leaf.push_back(candidate);
      parts.fraction.push_back(volume);
      parts.middle.push_back(middle);
      total += volume;
    }
  }
  for (std::size_t i = first; i < parts.leaf.size(); ++i)
    parts.fraction[i] /= total;
}
} // namespace

template <int dim>
BoxParts<dim> find_box_parts(const LeafTable<dim>& table, const std::vector<std::array<double, dim>>& centre,
                             const std::vector<std::array<double, dim>>& half_width,
                             const std::vector<unsigned int>& leaf)
{
  BoxParts<dim> parts;
  parts.begin.reserve(centre.size() + 1);
  std::vector<Box<dim>> boxes;
  std::vector<unsigned int> candidates;
  for (std::size_t begin = 0, end = 0; begin < centre.size(); begin = end)
  {
    boxes.clear();
    for (end = begin; end < centre.size() && (end == begin || (!leaf.empty() && leaf[end] == leaf[begin])); ++end)
      boxes.push_back(shrink<dim>(table, centre[end], half_width[end]));
    Box<dim> all = boxes.front();
    for (const Box<dim>& box : boxes)
      all.include(box);
    candidates.clear();
    table.find_leaves(all.lower, all.upper, candidates);
    for (const Box<dim>& box : boxes)
    {
      if (!box.is_empty())
        append_parts<dim>(table, candidates, box, parts);
      parts.begin.push_back(parts.leaf.size());
    }
  }
  return parts;
}

template <int dim>
std::vector<std::array<double, dim>> point_boxes(const std::vector<std::array<double, dim>>& half_width)
{
  std::vector<std::array<double, dim>> points = half_width;
  for (std::array<double, dim>& box : points)
    for (double& width : box)
      width *= point_box;
  return points;
}

template <int dim>
void refuse_boxes_outside(const BoxParts<dim>& parts, const std::vector<std::array<double, dim>>& centre)
{
  for (std::size_t p = 0; p < centre.size(); ++p)
    if (parts.begin[p] == parts.begin[p + 1])
      throw SolverError(fmt::format("a material point has left the grid at x = {:.6g} m; a larger domain or smaller "
                                    "steps help",
                                    centre[p][0]));
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template BoxParts<dim> find_box_parts<dim>(const LeafTable<dim>&, const std::vector<std::array<double, dim>>&,       \
                                             const std::vector<std::array<double, dim>>&,                              \
                                             const std::vector<unsigned int>&);                                        \
  template std::vector<std::array<double, dim>> point_boxes<dim>(const std::vector<std::array<double, dim>>&);         \
  template void refuse_boxes_outside<dim>(const BoxParts<dim>&, const std::vector<std::array<double, dim>>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
