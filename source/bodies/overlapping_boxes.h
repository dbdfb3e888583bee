// Which of many boxes overlap.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

namespace kedge
{
/// Calls `visit` with the numbers of every two boxes that overlap or touch, each pair once and in either order. What
/// `visit` throws ends the search. Takes n log^3 n for n boxes and then as long as there are pairs (Zomorodian &
/// Edelsbrunner 2002, doi 10.1142/S0218195902000785).
void for_overlapping_pairs(const std::vector<Eigen::AlignedBox3d>& boxes,
                           const std::function<void(unsigned int, unsigned int)>& visit);
} // namespace kedge
