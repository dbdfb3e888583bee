#include <algorithm>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/linearised_points.h>

namespace kedge
{
LinearisedPoints linearise_points(const PointForces& points)
{
  std::vector<unsigned int> begin{0}, nodes;
  std::vector<double> weights, tangent;
  for (std::size_t i = 0; i < points.n_points(); ++i)
  {
    const double* first = &points.tangent[9 * i];
    if (std::all_of(first, first + 9, [](const double entry) { return entry == 0.; })) // most points touch nothing
      continue;
    nodes.insert(nodes.end(), points.nodes.begin() + points.begin[i], points.nodes.begin() + points.begin[i + 1]);
    weights.insert(weights.end(), points.weights.begin() + points.begin[i],
                   points.weights.begin() + points.begin[i + 1]);
    begin.push_back(nodes.size());
    tangent.insert(tangent.end(), first, first + 9);
  }
  return {upload(begin, "point begin"), upload(nodes, "point nodes"), upload(weights, "point weights"),
          upload(tangent, "point tangents")};
}

void add_linearised_points(const unsigned int dim, const LinearisedPoints& points, const double sign,
                           const NodalVector& direction, const NodalVector& force)
{
  Kokkos::parallel_for(
      "point product", Kokkos::RangePolicy<ExecutionSpace>(0, points.n()), KOKKOS_LAMBDA(const std::size_t i) {
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
} // namespace kedge
