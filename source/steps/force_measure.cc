#include <algorithm>
#include <cmath>
#include <kedge/assembly/force_sizes.h>
#include <kedge/base/communication.h>
#include <kedge/steps/force_measure.h>

namespace kedge
{
namespace
{
/// Largest share of a node over the measure.
constexpr double most_at_a_node = 50.;

auto read(const TpetraVector& vector)
{
  return Kokkos::subview(vector.getLocalViewDevice(Tpetra::Access::ReadOnly), Kokkos::ALL(), 0);
}

/// Of every owned node; `residual` has dim entries per node.
View<double*> shares(const unsigned int dim, const TpetraVector& residual, const View<double*>& scale)
{
  const auto r = read(residual);
  const View<double*> share("shares", scale.extent(0));
  Kokkos::parallel_for(
      "unbalanced shares", Kokkos::RangePolicy<ExecutionSpace>(0, scale.extent(0)),
      KOKKOS_LAMBDA(const std::size_t v) { share(v) = size_at(dim, r, v) / scale(v); });
  return share;
}
} // namespace

void find_shares(const unsigned int dim, const TpetraVector& residual, TpetraVector& sizes)
{
  const auto r = read(residual);
  const auto s = Kokkos::subview(sizes.getLocalViewDevice(Tpetra::Access::ReadWrite), Kokkos::ALL(), 0);
  Kokkos::parallel_for(
      "shares of forces", Kokkos::RangePolicy<ExecutionSpace>(0, s.extent(0) / dim),
      KOKKOS_LAMBDA(const std::size_t v) { s(dim * v) = s(dim * v) > 0. ? size_at(dim, r, v) / s(dim * v) : 0.; });
}

ForceMeasure::ForceMeasure(const unsigned int dim_, const MPI_Comm communicator_, const std::vector<double>& cell_sizes)
    : dim(dim_),
      communicator(communicator_),
      n_nodes(std::max(1ll, sum_over_ranks(static_cast<long long>(cell_sizes.size()), communicator_))),
      area("area of nodes", cell_sizes.size()),
      scale("scale of forces", cell_sizes.size())
{
  const auto host = make_mirror(area);
  for (std::size_t v = 0; v < cell_sizes.size(); ++v)
    host(v) = std::pow(cell_sizes[v], dim - 1.);
  Kokkos::deep_copy(area, host);
}

void ForceMeasure::renew(const TpetraVector& sizes)
{
  const auto s = read(sizes);
  const auto a = area, into = scale;
  const unsigned int n = dim;
  double sum = 0.;
  Kokkos::parallel_reduce(
      "mean stress", Kokkos::RangePolicy<ExecutionSpace>(0, a.extent(0)),
      KOKKOS_LAMBDA(const std::size_t v, double& squares) { squares += std::pow(s(n * v) / a(v), 2); }, sum);
  floor = std::sqrt(sum_over_ranks(sum, communicator) / n_nodes);
  const double least = floor;
  Kokkos::parallel_for(
      "scale of forces", Kokkos::RangePolicy<ExecutionSpace>(0, a.extent(0)),
      KOKKOS_LAMBDA(const std::size_t v) { into(v) = s(n * v) + least * a(v); });
}

double ForceMeasure::of(const TpetraVector& residual) const
{
  if (is_zero())
    return residual.norm2() > 0. ? INFINITY : 0.;
  const View<double*> share = shares(dim, residual, scale);
  double sum = 0., largest = 0.;
  Kokkos::parallel_reduce(
      "mean and largest share", Kokkos::RangePolicy<ExecutionSpace>(0, share.extent(0)),
      KOKKOS_LAMBDA(const std::size_t v, double& squares, double& most) {
        squares += share(v) * share(v);
        most = share(v) > most ? share(v) : most;
      },
      sum, Kokkos::Max<double>(largest));
  const double mean = std::sqrt(sum_over_ranks(sum, communicator) / n_nodes);
  return std::isfinite(mean) ? std::max(mean, max_over_ranks(largest, communicator) / most_at_a_node) : mean;
}

WorstNode ForceMeasure::worst(const TpetraVector& residual) const
{
  WorstNode here;
  here.share = -1.;
  if (!is_zero())
  {
    const auto share = copy_to_host(shares(dim, residual, scale));
    for (std::size_t v = 0; v < share.extent(0); ++v)
      if (share(v) > here.share)
      {
        here.share = share(v);
        here.node = v;
      }
  }
  const double largest = max_over_ranks(here.share, communicator);
  const double first = here.share == largest ? rank_of(communicator) : size_of(communicator);
  return {largest, here.node, static_cast<int>(min_over_ranks(first, communicator))};
}
} // namespace kedge
