#include <algorithm>
#include <kedge/base/communication.h>
#include <kedge/mesh/partition.h>

namespace kedge
{
template <int dim>
std::size_t Partition<dim>::Trees::find(const std::array<double, dim>& x, std::array<double, dim>& corner) const
{
  std::size_t number = 0, stride = 1;
  for (unsigned int d = 0; d < dim; ++d)
  {
    const unsigned int along = std::min(static_cast<unsigned int>(x[d] / size), n[d] - 1);
    corner[d] = size * along;
    number += stride * along;
    stride *= n[d];
  }
  return number;
}

template <int dim>
Partition<dim>::Partition(const Trees& trees_, std::vector<std::uint64_t> number_in_forest_, const ForestPlace& first,
                          const MPI_Comm communicator)
    : brick(trees_),
      number_in_forest(std::move(number_in_forest_)),
      begin(gather_everywhere(std::vector<ForestPlace>{first}, communicator))
{
  for (std::size_t rank = begin.size() - 1; rank-- > 0;)
    begin[rank] = std::min(begin[rank], begin[rank + 1]);
}

template <int dim> int Partition<dim>::find_owner(const std::array<double, dim>& x) const
{
  std::array<double, dim> corner;
  ForestPlace place{number_in_forest[brick.find(x, corner)], 0};
  double half = 0.5 * brick.size;
  for (unsigned int level = 0; level < ForestPlace::depth; ++level, half *= 0.5)
    place.child = place.child << 3 | find_child<dim>(x, half, corner);
  return static_cast<int>(std::upper_bound(begin.begin(), begin.end(), place) - begin.begin()) - 1;
}

template class Partition<2>;
template class Partition<3>;
} // namespace kedge
