#include <cmath>
#include <cstdlib>
#include <kedge/basis/cell_quadrature.h>

namespace kedge
{
namespace
{
/// Share of what gradients differ by within a full leaf. With 1 the leaf bends as stiffly as the bilinear element with a
/// mean dilation, with 0 not at all. The smaller it is, the lower are limit loads on coarse cells.
const double hourglass_share = std::getenv("KEDGE_FLUCT") ? std::atof(std::getenv("KEDGE_FLUCT")) : 0.5;
} // namespace

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
    correction.scale = std::pow(leaf.size, dim) / content.volume;
    correction.share = hourglass_share;
    std::array<double, 3> centroid{}; // from the centre, in sizes of the leaf
    for (unsigned int d = 0; d < dim; ++d)
    {
      centroid[d] = content.moment[d] / content.volume;
      correction.offset[d] =
          (1. - hourglass_share) * (leaf.lower[d] + 0.5 * leaf.size) - hourglass_share * centroid[d] * leaf.size;
    }
    if constexpr (dim == 3)
      for (unsigned int d = 0; d < dim; ++d)
      {
        const double mean =
            content.mixed_moment[d] / content.volume - centroid[(d + 1) % 3] * centroid[(d + 2) % 3];
        correction.twist[d] = -hourglass_share * hourglass_share * mean / leaf.size;
      }
  }
  return corrections;
}

template std::vector<CellCorrection<2>> find_cell_corrections<2>(const LeafTable<2>&,
                                                                 const std::vector<LeafContent>&);
template std::vector<CellCorrection<3>> find_cell_corrections<3>(const LeafTable<3>&,
                                                                 const std::vector<LeafContent>&);
} // namespace kedge
