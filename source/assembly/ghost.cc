#include <cmath>
#include <kedge/assembly/ghost.h>
#include <kedge/assembly/kernels.h>
#include <kedge/base/groups.h>

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

/// How a face answers to the increments of its nodes: force pull times secant, see the theory.
template <int dim> struct FaceResponse
{
  double pull[max_ghost_face_nodes][dim]; ///< J u of every node, m^4 (2-D: m3)
  double secant;                          ///< of the force, N/m4
  double softening;                       ///< loss of the tangent along the pull, N/m^(6 + dim)
};

template <int dim>
KEDGE_FUNCTION void find_response(const GhostFaces& faces, const std::size_t f, const View<double*>& increment,
                                  FaceResponse<dim>& response)
{
  const auto [n, node, J] = matrix_of(faces, f);
  double energy = 0.;
  for (unsigned int a = 0; a < n; ++a)
    for (int c = 0; c < dim; ++c)
    {
      double pull = 0.;
      for (unsigned int b = 0; b < n; ++b)
        pull += J[a * n + b] * increment(static_cast<std::size_t>(dim) * node[b] + c);
      response.pull[a][c] = pull;
      energy += pull * increment(static_cast<std::size_t>(dim) * node[a] + c);
    }
  const double reference = faces.measure(f) * ghost_yield_jump * ghost_yield_jump;
  const double excess = 1. + energy / reference, yielding = faces.stiffness(f) * (1. - ghost_floor);
  response.secant = faces.stiffness(f) * ghost_floor + yielding / std::sqrt(excess);
  response.softening = yielding / (reference * excess * std::sqrt(excess));
}

template <int dim> struct MatrixKernel
{
  GhostFaces faces;
  LinearisedGhost derivative;
  View<std::size_t*> row_begin;
  View<unsigned int*> column;
  View<double*> values;

  KEDGE_FUNCTION void operator()(const GroupMember& group, const double*, const unsigned int f) const
  {
    const unsigned int n = faces.node_begin(f + 1) - faces.node_begin(f);
    Kokkos::parallel_for(Kokkos::ThreadVectorRange(group, n), [&](const unsigned int a) { add_row(f, a); });
  }

  /// Of the face's node a.
  KEDGE_FUNCTION void add_row(const unsigned int f, const unsigned int a) const
  {
    const auto [n, node, J] = matrix_of(faces, f);
    const double* pull = &derivative.pull(dim * faces.node_begin(f));
    const double secant = derivative.secant(f), softening = derivative.softening(f);
    const std::size_t begin = row_begin(node[a]);
    const unsigned int length = row_begin(node[a] + 1) - begin;
    double* row = &values(static_cast<std::size_t>(dim) * dim * begin);
    for (unsigned int b = 0; b < n; ++b)
    {
      const std::size_t position = find_entry_or_diagonal(row_begin, column, node[a], node[b]) - begin;
      for (int c = 0; c < dim; ++c)
        for (int d = 0; d < dim; ++d)
          add_to(row[dim * (c * length + position) + d],
                 (c == d ? secant * J[a * n + b] : 0.) - softening * pull[dim * a + c] * pull[dim * b + d]);
    }
  }
};
} // namespace

template <int dim>
void add_ghost_force(const GhostFaces& faces, const View<double*>& increment, const View<double*>& force)
{
  Kokkos::parallel_for(
      "ghost force", Kokkos::RangePolicy<ExecutionSpace>(0, faces.n_faces()), KOKKOS_LAMBDA(const std::size_t f) {
        FaceResponse<dim> response;
        find_response(faces, f, increment, response);
        const unsigned int first = faces.node_begin(f), n = faces.node_begin(f + 1) - first;
        for (unsigned int a = 0; a < n; ++a)
          for (int c = 0; c < dim; ++c)
            add_to(force(static_cast<std::size_t>(dim) * faces.nodes(first + a) + c),
                   response.secant * response.pull[a][c]);
      });
}

template <int dim>
void add_ghost_matrix(const GhostFaces& faces, const LinearisedGhost& derivative, const NodeGraph& graph,
                      const View<double*>& values)
{
  for_each_in_groups("ghost matrix", faces.n_faces(), 0,
                     MatrixKernel<dim>{faces, derivative, graph.row_begin, graph.column, values});
}

template <int dim> LinearisedGhost linearise_ghost(const GhostFaces& faces, const View<double*>& increment)
{
  const LinearisedGhost derivative{View<double*>("pull", dim * faces.nodes.extent(0)),
                                   View<double*>("secant", faces.n_faces()),
                                   View<double*>("softening", faces.n_faces())};
  Kokkos::parallel_for(
      "linearise ghost", Kokkos::RangePolicy<ExecutionSpace>(0, faces.n_faces()), KOKKOS_LAMBDA(const std::size_t f) {
        FaceResponse<dim> response;
        find_response(faces, f, increment, response);
        derivative.secant(f) = response.secant;
        derivative.softening(f) = response.softening;
        const unsigned int first = faces.node_begin(f), n = faces.node_begin(f + 1) - first;
        for (unsigned int a = 0; a < n; ++a)
          for (int c = 0; c < dim; ++c)
            derivative.pull(dim * (first + a) + c) = response.pull[a][c];
      });
  return derivative;
}

template <int dim>
void add_linearised_ghost(const GhostFaces& faces, const LinearisedGhost& derivative, const View<double*>& direction,
                          const View<double*>& force)
{
  Kokkos::parallel_for(
      "ghost product", Kokkos::RangePolicy<ExecutionSpace>(0, faces.n_faces()), KOKKOS_LAMBDA(const std::size_t f) {
        const auto [n, node, J] = matrix_of(faces, f);
        const double* pull = &derivative.pull(dim * faces.node_begin(f));
        double along = 0.;
        for (unsigned int a = 0; a < n; ++a)
          for (int c = 0; c < dim; ++c)
            along += pull[dim * a + c] * direction(static_cast<std::size_t>(dim) * node[a] + c);
        along *= derivative.softening(f);
        for (unsigned int a = 0; a < n; ++a)
        {
          double sum[dim] = {};
          for (unsigned int b = 0; b < n; ++b)
            for (int c = 0; c < dim; ++c)
              sum[c] += J[a * n + b] * direction(static_cast<std::size_t>(dim) * node[b] + c);
          for (int c = 0; c < dim; ++c)
            add_to(force(static_cast<std::size_t>(dim) * node[a] + c),
                   derivative.secant(f) * sum[c] - along * pull[dim * a + c]);
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

template void add_ghost_force<2>(const GhostFaces&, const View<double*>&, const View<double*>&);
template void add_ghost_force<3>(const GhostFaces&, const View<double*>&, const View<double*>&);
template void add_ghost_matrix<2>(const GhostFaces&, const LinearisedGhost&, const NodeGraph&, const View<double*>&);
template void add_ghost_matrix<3>(const GhostFaces&, const LinearisedGhost&, const NodeGraph&, const View<double*>&);
template LinearisedGhost linearise_ghost<2>(const GhostFaces&, const View<double*>&);
template LinearisedGhost linearise_ghost<3>(const GhostFaces&, const View<double*>&);
template void add_linearised_ghost<2>(const GhostFaces&, const LinearisedGhost&, const View<double*>&,
                                      const View<double*>&);
template void add_linearised_ghost<3>(const GhostFaces&, const LinearisedGhost&, const View<double*>&,
                                      const View<double*>&);
} // namespace kedge
