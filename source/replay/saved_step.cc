#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/replay/saved_step.h>
#include <kedge/replay/tensor_file.h>

namespace kedge
{
namespace
{
constexpr unsigned int format_version = 3;

/// What the particles need besides what every stress update writes.
template <typename Archive> void transfer(Archive& archive, ParticleArrays& particles)
{
  archive("particles/elastic left Cauchy-Green", particles.elastic_left_cauchy_green);
  archive("particles/Young's modulus", particles.young);
  archive("particles/initial volume", particles.initial_volume);
  archive("particles/mass", particles.mass);
  archive("particles/layer", particles.layer);
  archive("particles/cell size", particles.cell_size);
  archive("particles/law state", particles.state);
}

template <typename Archive> void transfer(Archive& archive, StencilSet& stencils)
{
  archive("stencils/pattern node begin", stencils.pattern_node_begin);
  archive("stencils/pattern nodes", stencils.pattern_nodes);
  archive("stencils/pattern particle begin", stencils.pattern_particle_begin);
  archive("stencils/pattern particles", stencils.pattern_particles);
  archive("stencils/pattern of particle", stencils.pattern_of_particle);
  archive("stencils/value begin", stencils.value_begin);
  archive("stencils/value", stencils.value);
  archive("stencils/gradient", stencils.gradient);
  archive("stencils/volume factor", stencils.volume_factor);
  archive("stencils/most nodes", stencils.max_nodes);
}

template <typename Archive> void transfer(Archive& archive, Elements& elements)
{
  archive("elements/node begin", elements.node_begin);
  archive("elements/nodes", elements.nodes);
  archive("elements/part begin", elements.part_begin);
  archive("elements/particle", elements.particle);
  archive("elements/share", elements.share);
  archive("elements/gradient", elements.gradient);
  archive("elements/cell", elements.cell);
}

template <typename Archive> void transfer(Archive& archive, CellGroups& cells)
{
  archive("cells/particle begin", cells.particle_begin);
  archive("cells/node begin", cells.node_begin);
  archive("cells/nodes", cells.nodes);
}

template <typename Archive> void transfer(Archive& archive, GhostFaces& faces)
{
  archive("ghost faces/node begin", faces.node_begin);
  archive("ghost faces/nodes", faces.nodes);
  archive("ghost faces/value begin", faces.value_begin);
  archive("ghost faces/value", faces.value);
  archive("ghost faces/measure", faces.measure);
  archive("ghost faces/stiffness", faces.stiffness);
  archive("ghost faces/mass", faces.mass);
}

template <typename Archive> void transfer(Archive& archive, SavedContact& contact)
{
  archive("contact/begin", contact.arrays.points.begin);
  archive("contact/nodes", contact.arrays.points.nodes);
  archive("contact/weights", contact.arrays.points.weights);
  archive("contact/pair begin", contact.arrays.pair_begin);
  archive("contact/pairs", contact.arrays.pairs);
  archive("contact/rests", contact.arrays.rests);
  archive("contact/motions", contact.motions);
  archive("contact/tree nodes", contact.nodes);
  archive("contact/tree facets", contact.facets);
  archive("contact/tree parts", contact.parts);
  archive("contact/tree grids", contact.grids);
  archive("contact/keeps multipliers", contact.keeps_multipliers);
  archive("contact/rate point", contact.rate_point);
  archive("contact/rate direction", contact.rate_direction);
}

/// Every array of the file, for writing as for reading.
template <typename Archive> void transfer(Archive& archive, SavedStep& step)
{
  archive("dim", step.dim);
  archive("ranks", step.n_ranks);
  transfer(archive, step.parts.particles);
  archive("materials", step.parts.materials);
  transfer(archive, step.parts.stencils);
  transfer(archive, step.parts.elements);
  transfer(archive, step.parts.cells);
  transfer(archive, step.parts.ghost_faces);
  archive("nodes/owned", step.parts.numbering.n_owned);
  archive("nodes/global", step.parts.numbering.global);
  archive("nodes/ghost begin", step.parts.numbering.ghost_begin);
  archive("nodes/position", step.parts.position);
  archive("nodes/constrained", step.parts.constrained);
  transfer(archive, step.contact);
  archive("dynamic", step.is_dynamic);
  archive("dynamic/beta", step.newmark.beta);
  archive("dynamic/gamma", step.newmark.gamma);
  archive("dynamic/dt", step.newmark.dt);
  archive("dynamic/mass", step.motion.mass);
  archive("dynamic/velocity", step.motion.velocity);
  archive("dynamic/acceleration", step.motion.acceleration);
  archive("increment", step.increment);
  archive("other forces", step.other);
  archive("border/columns", step.columns);
  archive("border/rows", step.rows);
  archive("border/corner", step.corner);
  archive("border/residual", step.rigid_side);
  archive("elastic share", step.elastic_share);
  archive("tolerance", step.tolerance);
  archive("answer/residual", step.residual);
  archive("answer/solution", step.solution);
  archive("answer/product", step.product);
}

/// What every stress update writes.
void make_room(NodalParts& parts, const unsigned int dim)
{
  ParticleArrays& particles = parts.particles;
  const std::size_t n = particles.n = particles.young.extent(0);
  particles.trial_strain = View<double* [6]>("trial strain", n);
  particles.trial_stress = View<double* [6]>("trial stress", n);
  particles.trial_plastic = View<double*>("trial plastic", n);
  particles.trial_state = StateView("trial state", n);
  Kokkos::deep_copy(particles.trial_state, particles.state);
  particles.trial_deformation = View<double* [9]>("trial deformation", n);
  particles.trial_frame = View<double* [12]>("trial frame", n);
  if (!parts.cells.empty())
  {
    parts.cells.volume_factor = View<double*>("volume factor", n);
    parts.cells.pressure = View<double*>("pressure", n);
    parts.cells.spring = View<double*>("spring", n);
  }
  parts.stencils.dim = parts.elements.dim = dim;
  parts.stencils.n_particles = n;
  parts.stencils.n_patterns = parts.stencils.pattern_node_begin.extent(0) - 1;
}
} // namespace

std::string rank_file(const std::string& path, const MPI_Comm communicator)
{
  return size_of(communicator) == 1 ? path : path + "." + std::to_string(rank_of(communicator));
}

void write_step(SavedStep& step, const std::string& path)
{
  TensorWriter(path).write(
      [&](TensorWriter& file)
      {
        file("format", format_version);
        transfer(file, step);
      });
}

SavedStep read_step(const std::string& path, const unsigned int copies)
{
  TensorReader file(path);
  unsigned int version = 0;
  file("format", version);
  if (version != format_version)
    throw FileError(path, "was written by another version of Kedge");
  SavedStep step;
  transfer(file, step);
  if (copies > 1)
    repeat_step(step, copies);
  make_room(step.parts, step.dim);
  make_room(step.contact.arrays);
  point_into_trees(step.contact);
  return step;
}

std::vector<double> values_of(const TpetraMultiVector& vectors)
{
  const auto view = vectors.getLocalViewHost(Tpetra::Access::ReadOnly);
  std::vector<double> values;
  for (std::size_t j = 0; j < view.extent(1); ++j)
    for (std::size_t i = 0; i < view.extent(0); ++i)
      values.push_back(view(i, j));
  return values;
}

Teuchos::RCP<TpetraMultiVector> vectors_of(const std::vector<double>& values, const Teuchos::RCP<const TpetraMap>& map,
                                           const std::size_t n_vectors)
{
  const auto vectors = Teuchos::rcp(new TpetraMultiVector(map, n_vectors));
  const auto view = vectors->getLocalViewHost(Tpetra::Access::OverwriteAll);
  for (std::size_t j = 0; j < n_vectors; ++j)
    for (std::size_t i = 0; i < view.extent(0); ++i)
      view(i, j) = values.at(j * view.extent(0) + i);
  return vectors;
}
} // namespace kedge
