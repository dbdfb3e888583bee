#include <cmath>
#include <kedge/assembly/acting_points.h>
#include <kedge/assembly/kernels.h>
#include <kedge/base/groups.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;
} // namespace

PointForces gather_acting(const PointForces& points)
{
  const std::size_t n = points.n_acting;
  const auto uninitialised = [](const std::string& label)
  { return Kokkos::view_alloc(label, Kokkos::WithoutInitializing); };
  const PointForces all = points;
  PointForces gathered;
  gathered.n_acting = n;
  gathered.begin = View<unsigned int*>(uninitialised("point begin"), n + 1);
  unsigned int n_nodes = 0;
  const View<unsigned int*> begin = gathered.begin;
  Kokkos::parallel_scan(
      "nodes of acting points", Policy(0, n + 1),
      KOKKOS_LAMBDA(const std::size_t k, unsigned int& sum, const bool is_last) {
        if (is_last)
          begin(k) = sum;
        if (k < n)
          sum += all.begin(all.acting(k) + 1) - all.begin(all.acting(k));
      },
      n_nodes);
  gathered.nodes = View<unsigned int*>(uninitialised("point nodes"), n_nodes);
  gathered.weights = View<double*>(uninitialised("point weights"), n_nodes);
  gathered.force = View<double*>(uninitialised("point forces"), 3 * n);
  gathered.tangent = View<double*>(uninitialised("point tangents"), 9 * n);
  gathered.acting = View<unsigned int*>(uninitialised("acting points"), n);
  const PointForces to = gathered;
  Kokkos::parallel_for(
      "gather acting points", Policy(0, n), KOKKOS_LAMBDA(const std::size_t k) {
        const unsigned int i = all.acting(k), from = all.begin(i);
        for (unsigned int v = to.begin(k); v < to.begin(k + 1); ++v)
        {
          to.nodes(v) = all.nodes(from + v - to.begin(k));
          to.weights(v) = all.weights(from + v - to.begin(k));
        }
        for (unsigned int c = 0; c < 3; ++c)
          to.force(3 * k + c) = all.force(3 * i + c);
        for (unsigned int c = 0; c < 9; ++c)
          to.tangent(9 * k + c) = all.tangent(9 * i + c);
        to.acting(k) = k;
      });
  return gathered;
}

void add_point_forces(const unsigned int dim, const PointForces& points, const double sign, const NodalVector& force)
{
  Kokkos::parallel_for(
      "point forces", Policy(0, points.n_acting), KOKKOS_LAMBDA(const std::size_t k) {
        const unsigned int i = points.acting(k);
        for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
          for (unsigned int d = 0; d < dim; ++d)
            add_to(force(static_cast<std::size_t>(dim) * points.nodes(v) + d),
                   sign * points.weights(v) * points.force(3 * i + d));
      });
}

void add_point_force_sizes(const unsigned int dim, const PointForces& points, const NodalVector& size)
{
  Kokkos::parallel_for(
      "sizes of point forces", Policy(0, points.n_acting), KOKKOS_LAMBDA(const std::size_t k) {
        const unsigned int i = points.acting(k);
        double square = 0.;
        for (unsigned int d = 0; d < dim; ++d)
          square += points.force(3 * i + d) * points.force(3 * i + d);
        for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
          add_to(size(static_cast<std::size_t>(dim) * points.nodes(v)), points.weights(v) * std::sqrt(square));
      });
}

void add_point_products(const unsigned int dim, const PointForces& points, const double sign,
                        const NodalVector& direction, const NodalVector& force)
{
  Kokkos::parallel_for(
      "point products", Policy(0, points.n_acting), KOKKOS_LAMBDA(const std::size_t k) {
        const unsigned int i = points.acting(k);
        double u[3] = {0., 0., 0.};
        for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
          for (unsigned int d = 0; d < dim; ++d)
            u[d] += points.weights(v) * direction(static_cast<std::size_t>(dim) * points.nodes(v) + d);
        for (unsigned int d = 0; d < dim; ++d)
        {
          double f = 0.;
          for (unsigned int e = 0; e < dim; ++e)
            f += points.tangent(9 * i + 3 * d + e) * u[e];
          for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
            add_to(force(static_cast<std::size_t>(dim) * points.nodes(v) + d), sign * points.weights(v) * f);
        }
      });
}

namespace
{
/// Of one point: its nodes' rows are shared by the threads of a group.
struct PointTangent
{
  PointForces points;
  double sign;
  unsigned int dim;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;

  KEDGE_FUNCTION void operator()(const GroupMember& group, double*, const unsigned int k) const
  {
    const unsigned int i = points.acting(k), first = points.begin(i), n = points.begin(i + 1) - first;
    Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, n),
                         [&](const unsigned int a)
                         {
                           for (unsigned int b = 0; b < n; ++b)
                             add(&points.tangent(9 * i), first + a, first + b);
                         });
  }

  /// The block of two of its nodes, by their places in the list.
  KEDGE_FUNCTION void add(const double* tangent, const unsigned int a, const unsigned int b) const
  {
    const unsigned int row_node = points.nodes(a);
    const std::size_t begin = row_begin(row_node), length = row_begin(row_node + 1) - begin;
    const std::size_t position = find_entry_or_diagonal(row_begin, column, row_node, points.nodes(b)) - begin;
    double* const row = &values(std::size_t(dim) * dim * begin);
    const double factor = sign * points.weights(a) * points.weights(b);
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int e = 0; e < dim; ++e)
        add_to(row[dim * (c * length + position) + e], factor * tangent[3 * c + e]);
  }
};
} // namespace

void add_point_tangents(const PointForces& points, const double sign, const NodeGraph& graph,
                        const View<double*>& values)
{
  for_each_in_groups("point tangents", points.n_acting, 0,
                     PointTangent{points, sign, graph.dim, graph.row_begin, graph.column, values});
}
} // namespace kedge
