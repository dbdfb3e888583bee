#include "overlapping_boxes.h"

#include <CGAL/box_intersection_d.h>

namespace kedge
{
void for_overlapping_pairs(const std::vector<Eigen::AlignedBox3d>& boxes,
                           const std::function<void(unsigned int, unsigned int)>& visit)
{
  using NumberedBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, unsigned int>;
  std::vector<NumberedBox> numbered;
  numbered.reserve(boxes.size());
  for (unsigned int i = 0; i < boxes.size(); ++i)
  {
    const Eigen::Vector3d &low = boxes[i].min(), &high = boxes[i].max();
    numbered.emplace_back(CGAL::Bbox_3(low[0], low[1], low[2], high[0], high[1], high[2]), i);
  }

  // Fewer boxes are compared each with each along one axis: where many share a plane, this takes long for large sets.
  constexpr std::ptrdiff_t largest_scanned_set = 50;
  CGAL::box_self_intersection_d(
      numbered.begin(), numbered.end(),
      [&visit](const NumberedBox& a, const NumberedBox& b) { visit(a.info(), b.info()); }, largest_scanned_set);
}
} // namespace kedge
