#include <algorithm>
#include <cmath>
#include <kedge/basis/elements.h>
#include <numeric>

namespace kedge
{
namespace
{
/// Volume, sums of place and of its square over the parts in a leaf.
template <int dim> struct Moments
{
  double volume = 0.;
  std::array<double, dim> first{}, second{};
};

template <int dim>
void append_gradients(const LeafTable<dim>& table, const unsigned int leaf, const Moments<dim>& soil,
                      const std::vector<unsigned int>& number, std::vector<unsigned int>& nodes,
                      std::vector<double>& gradients)
{
  std::array<double, dim> mean, spread;
  for (unsigned int d = 0; d < dim; ++d)
  {
    mean[d] = soil.first[d] / soil.volume;
    spread[d] = std::sqrt(std::max(0., soil.second[d] / soil.volume - mean[d] * mean[d]));
  }
  const auto& cell = table.leaves[leaf];
  const auto node = [&](const unsigned int n) { return number[table.nodes[cell.node_begin + n]]; };
  std::vector<unsigned int> order(cell.n_nodes);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](const unsigned int a, const unsigned int b) { return node(a) < node(b); });
  for (const unsigned int n : order)
    nodes.push_back(node(n));
  std::vector<std::array<double, dim>> found;
  for (unsigned int sample = 0; sample < (1u << dim); ++sample)
  {
    std::array<double, dim> x;
    for (unsigned int d = 0; d < dim; ++d)
      x[d] = mean[d] + ((sample >> d) & 1u ? spread[d] : -spread[d]);
    find_leaf_gradients<dim>(table, leaf, x, found);
    for (const unsigned int n : order)
      gradients.insert(gradients.end(), found[n].begin(), found[n].end());
  }
}
} // namespace

template <int dim>
Elements make_elements(const LeafTable<dim>& table, const BoxParts<dim>& parts,
                       const std::vector<CellCorrection<dim>>& corrections, const std::vector<double>& volume,
                       const std::vector<unsigned int>& number, const std::vector<int>& group_of_leaf)
{
  // Count and sum up by leaf.
  const std::size_t n_particles = volume.size();
  std::vector<Moments<dim>> moments(table.leaves.size());
  std::vector<unsigned int> count(table.leaves.size(), 0);
  std::vector<double> whole(n_particles, 0.);
  for (std::size_t p = 0; p < n_particles; ++p)
    for (std::size_t i = parts.begin[p]; i < parts.begin[p + 1]; ++i)
    {
      Moments<dim>& soil = moments[parts.leaf[i]];
      const CellCorrection<dim> correction = correction_of<dim>(corrections, parts.leaf[i]);
      const std::array<double, dim> place = correction.corrected(parts.middle[i]);
      const double v = parts.fraction[i] * correction.scale * volume[p];
      whole[p] += parts.fraction[i] * correction.scale;
      ++count[parts.leaf[i]];
      soil.volume += v;
      for (unsigned int d = 0; d < dim; ++d)
      {
        soil.first[d] += v * place[d];
        soil.second[d] += v * place[d] * place[d];
      }
    }

  // Elements in the order of leaves.
  std::vector<unsigned int> node_begin{0}, nodes, part_begin{0}, element(table.leaves.size());
  std::vector<int> cell;
  std::vector<double> gradients;
  for (unsigned int leaf = 0; leaf < table.leaves.size(); ++leaf)
    if (count[leaf] > 0)
    {
      element[leaf] = cell.size();
      cell.push_back(group_of_leaf.empty() ? -1 : group_of_leaf[leaf]);
      append_gradients<dim>(table, leaf, moments[leaf], number, nodes, gradients);
      node_begin.push_back(nodes.size());
      part_begin.push_back(part_begin.back() + count[leaf]);
    }
  std::vector<unsigned int> next(part_begin.begin(), part_begin.end() - 1), particle(part_begin.back());
  std::vector<double> share(part_begin.back());
  for (std::size_t p = 0; p < n_particles; ++p)
    for (std::size_t i = parts.begin[p]; i < parts.begin[p + 1]; ++i)
    {
      const unsigned int at = next[element[parts.leaf[i]]]++;
      particle[at] = p;
      share[at] = parts.fraction[i] * correction_of<dim>(corrections, parts.leaf[i]).scale / whole[p];
    }
  gradients.push_back(0.); // kernels read whole SIMD registers
  return {dim,
          upload(node_begin, "element node begin"),
          upload(nodes, "element nodes"),
          upload(part_begin, "element part begin"),
          upload(particle, "element particles"),
          upload(share, "element shares"),
          upload(gradients, "element gradients"),
          upload(cell, "element cell")};
}

template Elements make_elements<2>(const LeafTable<2>&, const BoxParts<2>&, const std::vector<CellCorrection<2>>&,
                                   const std::vector<double>&, const std::vector<unsigned int>&,
                                   const std::vector<int>&);
template Elements make_elements<3>(const LeafTable<3>&, const BoxParts<3>&, const std::vector<CellCorrection<3>>&,
                                   const std::vector<double>&, const std::vector<unsigned int>&,
                                   const std::vector<int>&);
} // namespace kedge
