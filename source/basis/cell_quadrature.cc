#include <cmath>
#include <kedge/basis/cell_quadrature.h>

namespace kedge
{
template <int dim>
std::vector<CellCorrection<dim>> find_cell_corrections(const LeafTable<dim>& table,
                                                       const std::vector<LeafContent>& contents)
{
  std::vector<CellCorrection<dim>> corrections(contents.size());
  for (std::size_t i = 0; i < contents.size(); ++i)
  {
    const LeafContent& content = contents[i];
    if (content.full == 0.)
      continue;
    const auto& leaf = table.leaves[i];
    CellCorrection<dim>& correction = corrections[i];
    if (content.full == 1.) // else it holds the end of the soil, whose place its particles tell
      correction.scale = std::pow(leaf.size, dim) / content.volume;
    std::array<double, 3> centroid{}; // from the centre, in sizes of the leaf
    for (unsigned int d = 0; d < dim; ++d)
    {
      centroid[d] = content.moment[d] / content.volume;
      correction.shift[d] = -content.full * centroid[d] * leaf.size;
    }
    if constexpr (dim == 3)
      for (unsigned int d = 0; d < dim; ++d)
      {
        const double mean = content.mixed_moment[d] / content.volume - centroid[(d + 1) % 3] * centroid[(d + 2) % 3];
        correction.twist[d] = -content.full * mean / leaf.size;
      }
  }
  return corrections;
}

template std::vector<CellCorrection<2>> find_cell_corrections<2>(const LeafTable<2>&, const std::vector<LeafContent>&);
template std::vector<CellCorrection<3>> find_cell_corrections<3>(const LeafTable<3>&, const std::vector<LeafContent>&);
} // namespace kedge
