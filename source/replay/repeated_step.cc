#include <kedge/base/exceptions.h>
#include <kedge/replay/saved_step.h>
#include <kedge/replay/tensor_file.h>

namespace kedge
{
namespace
{
/// Entry i of copy k is that of the original plus k times `shift`, unless it is negative.
template <typename Array> struct Repeat
{
  Array from, to;
  std::size_t n, shift;

  KEDGE_FUNCTION void operator()(const std::size_t i) const
  {
    using Number = typename Array::non_const_value_type;
    const auto shifted = [&](Number value)
    {
      if constexpr (std::is_integral<Number>::value)
        if (!(value < 0))
          value += static_cast<Number>(i / n * shift);
      return value;
    };
    if constexpr (Array::rank == 2)
      for (std::size_t j = 0; j < from.extent(1); ++j)
        to(i, j) = shifted(from(i % n, j));
    else
      to(i) = shifted(from(i % n));
  }
};

/// The first n rows (all: at most as many as there are) `copies` times, and room for `idle` more numbers behind them.
template <typename Array>
void repeat_rows(Array& array, const std::size_t copies, const std::size_t shift = 0, const std::size_t idle = 0)
{
  if (array.extent(0) == 0)
    return;
  const std::size_t n = array.extent(0) - idle;
  const Array to(array.label(), copies * n + idle);
  Kokkos::parallel_for("repeat", Kokkos::RangePolicy<ExecutionSpace>(0, copies * n),
                       Repeat<Array>{array, to, n, shift});
  array = to;
}

/// Where lists begin: one number more than there are lists.
template <typename T> void repeat_begin(View<T*>& begin, const std::size_t copies)
{
  if (begin.extent(0) == 0)
    return;
  const std::size_t n = begin.extent(0) - 1;
  const View<T*> from = begin, to(begin.label(), copies * n + 1);
  Kokkos::parallel_for(
      "repeat begin", Kokkos::RangePolicy<ExecutionSpace>(0, copies * n + 1), KOKKOS_LAMBDA(const std::size_t i) {
        to(i) = i < copies * n ? from(i % n) + i / n * from(n) : copies * from(n);
      });
  begin = to;
}

template <typename T> void repeat(std::vector<T>& values, const std::size_t copies, const T shift = T())
{
  const std::size_t n = values.size();
  for (std::size_t i = n; i < copies * n; ++i)
    values.push_back(values[i - n] + shift);
}

/// Every vector of n_vectors, one after the other, becomes `copies` of itself.
void repeat_vectors(std::vector<double>& values, const std::size_t n_vectors, const std::size_t copies)
{
  std::vector<double> repeated;
  for (std::size_t j = 0; j < n_vectors; ++j)
    for (std::size_t k = 0; k < copies; ++k)
      repeated.insert(repeated.end(), values.begin() + j * values.size() / n_vectors,
                      values.begin() + (j + 1) * values.size() / n_vectors);
  values = repeated;
}

void repeat(ParticleArrays& particles, const std::size_t copies)
{
  repeat_rows(particles.elastic_left_cauchy_green, copies);
  repeat_rows(particles.young, copies);
  repeat_rows(particles.initial_volume, copies);
  repeat_rows(particles.mass, copies);
  repeat_rows(particles.layer, copies);
  repeat_rows(particles.cell_size, copies);
  repeat_rows(particles.state, copies);
}

void repeat(StencilSet& stencils, const std::size_t copies, const std::size_t n_nodes, const std::size_t n_particles)
{
  const std::size_t n_patterns = stencils.pattern_node_begin.extent(0) - 1;
  repeat_begin(stencils.pattern_node_begin, copies);
  repeat_rows(stencils.pattern_nodes, copies, n_nodes);
  repeat_begin(stencils.pattern_particle_begin, copies);
  repeat_rows(stencils.pattern_particles, copies, n_particles);
  repeat_rows(stencils.pattern_of_particle, copies, n_patterns);
  repeat_begin(stencils.value_begin, copies);
  repeat_rows(stencils.value, copies);
  repeat_rows(stencils.gradient, copies, 0, 1); // ends with a number for kernels that read whole registers
  repeat_rows(stencils.volume_factor, copies);
}

void repeat(Elements& elements, const std::size_t copies, const std::size_t n_nodes, const std::size_t n_particles,
            const std::size_t n_cells)
{
  repeat_begin(elements.node_begin, copies);
  repeat_rows(elements.nodes, copies, n_nodes);
  repeat_begin(elements.part_begin, copies);
  repeat_rows(elements.particle, copies, n_particles);
  repeat_rows(elements.share, copies);
  repeat_rows(elements.gradient, copies, 0, 1); // so too
  repeat_rows(elements.cell, copies, n_cells);
}

void repeat(GhostFaces& faces, const std::size_t copies, const std::size_t n_nodes)
{
  repeat_begin(faces.node_begin, copies);
  repeat_rows(faces.nodes, copies, n_nodes);
  repeat_begin(faces.value_begin, copies);
  for (View<double*>* const values : {&faces.value, &faces.measure, &faces.stiffness, &faces.mass})
    repeat_rows(*values, copies);
}

/// All but what evaluations write.
void repeat(ContactArrays& contact, const std::size_t copies, const std::size_t n_nodes)
{
  if (contact.pairs.extent(0) == 0)
    return;
  const std::size_t n_points = contact.points.begin.extent(0) - 1, n_pairs = contact.pairs.extent(0);
  repeat_begin(contact.points.begin, copies);
  repeat_rows(contact.points.nodes, copies, n_nodes);
  repeat_rows(contact.points.weights, copies);
  repeat_begin(contact.pair_begin, copies);
  repeat_rows(contact.rests, copies);
  repeat_rows(contact.pairs, copies);
  const View<ContactPair*> pairs = contact.pairs;
  Kokkos::parallel_for(
      "points of pairs", Kokkos::RangePolicy<ExecutionSpace>(0, copies * n_pairs),
      KOKKOS_LAMBDA(const std::size_t k) { pairs(k).point += k / n_pairs * n_points; });
}
} // namespace

void repeat_step(SavedStep& step, const unsigned int copies)
{
  if (step.n_ranks > 1)
    throw InputError("--copies", "several ranks have saved this step", "let one rank save it");
  NodalParts& parts = step.parts;
  const std::size_t n_nodes = parts.numbering.n_owned, n_particles = parts.particles.young.extent(0),
                    n_cells = parts.cells.n_cells(), n_rigid = step.rigid_side.size();
  repeat(parts.particles, copies);
  repeat(parts.stencils, copies, n_nodes, n_particles);
  repeat(parts.elements, copies, n_nodes, n_particles, n_cells);
  repeat_begin(parts.cells.particle_begin, copies);
  repeat_begin(parts.cells.node_begin, copies);
  repeat_rows(parts.cells.nodes, copies, n_nodes);
  repeat(parts.ghost_faces, copies, n_nodes);
  parts.numbering.n_owned *= copies;
  repeat(parts.numbering.global, copies, static_cast<long long>(n_nodes));
  for (unsigned int& begin : parts.numbering.ghost_begin)
    begin *= copies;
  repeat(parts.position, copies);
  repeat(parts.constrained, copies);
  repeat(step.contact.arrays, copies, n_nodes);
  for (NodalVector* const vector :
       {&step.motion.mass, &step.motion.velocity, &step.motion.acceleration, &step.increment, &step.other})
    repeat_rows(*vector, copies);
  for (std::vector<double>* const vectors : {&step.columns, &step.rows})
    repeat_vectors(*vectors, n_rigid, copies);
  for (std::vector<double>* const border : {&step.corner, &step.rigid_side})
    for (double& entry : *border)
      entry *= copies; // the bodies, which all copies share, move as before
  for (std::vector<double>* const answer : {&step.residual, &step.solution, &step.product})
    repeat(*answer, copies);
}
} // namespace kedge
