#include <cmath>
#include <kedge/assembly/ghost.h>
#include <kedge/assembly/kernels.h>

namespace kedge
{
namespace
{
/// The nodes of a face and its matrix J: entry (a, b) is J[a n + b].
struct FaceMatrix
{
  unsigned int n;
  const unsigned int* node;
  const double* J;
};

KEDGE_FUNCTION FaceMatrix matrix_of(const GhostFaces& faces, const std::size_t f)
{
  const unsigned int first = faces.node_begin(f);
  return {faces.node_begin(f + 1) - first, &faces.nodes(first), &faces.value(faces.value_begin(f))};
}
/// (J d)_a of one component.
template <int dim>
KEDGE_FUNCTION double product(const FaceMatrix& face, const unsigned int a, const View<double*>& nodal, const int c)
{
  double sum = 0.;
  for (unsigned int b = 0; b < face.n; ++b)
    sum += face.J[a * face.n + b] * nodal(static_cast<std::size_t>(dim) * face.node[b] + c);
  return sum;
}

/// w(s) and the factor of (J d) (x) (J d) in the derivative of w(s) J d.
struct Limit
{
  double w, slope;
};

template <int dim>
KEDGE_FUNCTION Limit limit_of(const FaceMatrix& face, const View<double*>& nodal, const double extent,
                              const double limit)
{
  constexpr double least = 1e-3;
  double energy = 0.;
  for (unsigned int a = 0; a < face.n; ++a)
    for (int c = 0; c < dim; ++c)
      energy += nodal(static_cast<std::size_t>(dim) * face.node[a] + c) * product<dim>(face, a, nodal, c);
  const double jump = std::sqrt(std::fmax(0., energy) / extent);
  if (jump <= limit)
    return {1., 0.};
  if (limit <= least * jump)
    return {least, 0.};
  return {limit / jump, -limit / (jump * jump * jump * extent)};
}
} // namespace

template <int dim>
void add_ghost_force(const GhostFaces& faces, const View<double*>& weight, const View<double*>& nodal,
                     const View<double*>& force, const bool limited)
{
  Kokkos::parallel_for(
      "ghost force", Kokkos::RangePolicy<ExecutionSpace>(0, faces.n_faces()), KOKKOS_LAMBDA(const std::size_t f) {
        const FaceMatrix face = matrix_of(faces, f);
        const double w = limited ? limit_of<dim>(face, nodal, faces.extent(f), faces.limit(f)).w : 1.;
        for (unsigned int a = 0; a < face.n; ++a)
          for (int c = 0; c < dim; ++c)
            add_to(force(static_cast<std::size_t>(dim) * face.node[a] + c),
                   weight(f) * w * product<dim>(face, a, nodal, c));
      });
}

template <int dim>
void add_ghost_matrix(const GhostFaces& faces, const View<double*>& weight, const NodeGraph& graph,
                      const View<double*>& values, const View<double*>& nodal, const bool limited)
{
  const auto row_begin = graph.row_begin;
  const auto column = graph.column;
  Kokkos::parallel_for(
      "ghost matrix", Kokkos::RangePolicy<ExecutionSpace>(0, faces.n_faces()), KOKKOS_LAMBDA(const std::size_t f) {
        const FaceMatrix face = matrix_of(faces, f);
        const Limit limit =
            limited ? limit_of<dim>(face, nodal, faces.extent(f), faces.limit(f)) : Limit{1., 0.};
        for (unsigned int a = 0; a < face.n; ++a)
        {
          const std::size_t begin = row_begin(face.node[a]);
          const unsigned int length = row_begin(face.node[a] + 1) - begin;
          double* row = &values(static_cast<std::size_t>(dim) * dim * begin);
          for (unsigned int b = 0; b < face.n; ++b)
          {
            const std::size_t position = find_entry(row_begin, column, face.node[a], face.node[b]) - begin;
            for (int c = 0; c < dim; ++c)
            {
              add_to(row[dim * (c * length + position) + c], weight(f) * limit.w * face.J[a * face.n + b]);
              if (limit.slope != 0.)
                for (int k = 0; k < dim; ++k)
                  add_to(row[dim * (c * length + position) + k], weight(f) * limit.slope *
                                                                     product<dim>(face, a, nodal, c) *
                                                                     product<dim>(face, b, nodal, k));
            }
          }
        }
      });
}

void add_ghost_mass(const GhostFaces& faces, const NodeGraph& graph, const NodalMass& mass)
{
  const auto row_begin = graph.row_begin;
  const auto column = graph.column;
  Kokkos::parallel_for(
      "ghost mass", Kokkos::RangePolicy<ExecutionSpace>(0, faces.n_faces()), KOKKOS_LAMBDA(const std::size_t f) {
        const auto [n, node, J] = matrix_of(faces, f);
        for (unsigned int a = 0; a < n; ++a)
          for (unsigned int b = 0; b < n; ++b)
            add_to(mass(find_entry(row_begin, column, node[a], node[b])), faces.mass(f) * J[a * n + b]);
      });
}

template void add_ghost_force<2>(const GhostFaces&, const View<double*>&, const View<double*>&, const View<double*>&,
                                 bool);
template void add_ghost_force<3>(const GhostFaces&, const View<double*>&, const View<double*>&, const View<double*>&,
                                 bool);
template void add_ghost_matrix<2>(const GhostFaces&, const View<double*>&, const NodeGraph&, const View<double*>&,
                                  const View<double*>&, bool);
template void add_ghost_matrix<3>(const GhostFaces&, const View<double*>&, const NodeGraph&, const View<double*>&,
                                  const View<double*>&, bool);
} // namespace kedge
