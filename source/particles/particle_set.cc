#include "array_copies.h"
#include "domain.h"
#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/materials/hencky.h>
#include <kedge/particles/particle_set.h>
#include <limits>
#include <stdexcept>

namespace kedge
{
namespace
{
/// What a particle near a body costs in addition, as a share of another's work: search, evaluation and gaps of its
/// corners, measured on the AC-14 where it digs in.
constexpr double contact_work = 1.4;

/// Number of nodes of the active leaves under a box. The box counts a little smaller, for its face may be a leaf's.
template <int dim>
unsigned int count_nodes(const LeafTable<dim>& table, const dealii::Point<dim>& centre, const double* half_width,
                         std::vector<unsigned int>& workspace)
{
  std::array<double, dim> lower, upper;
  for (unsigned int d = 0; d < dim; ++d)
  {
    lower[d] = std::max(table.lower_end(d), centre[d] - (1. - 1e-6) * half_width[d]);
    upper[d] = std::min(table.upper_end(d), centre[d] + (1. - 1e-6) * half_width[d]);
  }
  workspace.clear();
  table.find_leaves(lower, upper, workspace);
  if (workspace.size() == 1)
    return table.leaves[workspace[0]].n_nodes;
  std::vector<unsigned int> nodes;
  for (const unsigned int leaf : workspace)
    nodes.insert(nodes.end(), table.nodes.begin() + table.leaves[leaf].node_begin,
                 table.nodes.begin() + table.leaves[leaf].node_begin + table.leaves[leaf].n_nodes);
  std::sort(nodes.begin(), nodes.end());
  return std::unique(nodes.begin(), nodes.end()) - nodes.begin();
}
} // namespace

template <int dim>
ParticleSet<dim>::ParticleSet(BackgroundMesh<dim>& mesh_)
    : mesh(mesh_), particles(mesh_.triangulation(), mesh_.mapping(), field::count)
{
}

/// Owned, in the window.
template <int dim> std::vector<typename BackgroundMesh<dim>::Cell> ParticleSet<dim>::active_cells() const
{
  std::vector<typename BackgroundMesh<dim>::Cell> cells;
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
    if (cell->is_locally_owned() && mesh.in_window(cell))
      cells.push_back(cell);
  return cells;
}

template <int dim> std::vector<typename ParticleSet<dim>::Place> ParticleSet<dim>::sort_active() const
{
  std::vector<Place> places;
  for (const auto& cell : active_cells())
  {
    const auto in_cell = particles.particles_in_cell(cell);
    for (auto particle = in_cell.begin(); particle != in_cell.end(); ++particle)
      places.push_back({mesh.leaf_number(cell), particle});
  }
  std::sort(places.begin(), places.end(),
            [](const Place& a, const Place& b)
            { return std::make_pair(a.leaf, a.particle->get_id()) < std::make_pair(b.leaf, b.particle->get_id()); });
  return places;
}

template <int dim> typename ParticleSet<dim>::Handler& ParticleSet<dim>::edit()
{
  ++n_changes;
  return particles;
}

template <int dim> const typename ParticleSet<dim>::Mirror& ParticleSet<dim>::fresh() const
{
  if (!is_fresh())
  {
    fill(mirror);
    mirror.change = n_changes;
    mirror.mesh_version = mesh.version();
  }
  return mirror;
}

template <int dim> void ParticleSet<dim>::fill(Mirror& into) const
{
  into.order = sort_active();
  into.n_cut = 0;
  const std::size_t n = into.order.size();
  ParticleArrays& arrays = into.arrays;
  if (n != arrays.n || arrays.young.extent(0) != n)
    allocate_arrays(arrays, n);
  into.centre.resize(n);
  into.half_width.resize(n);
  into.leaf.resize(n);
  into.id.resize(n);

  const auto copies = host_copies(arrays, false);
  const auto b = make_mirror(arrays.elastic_left_cauchy_green);
  const auto cell_size = make_mirror(arrays.cell_size);
  for (std::size_t p = 0; p < n; ++p)
  {
    const auto& particle = into.order[p].particle;
    const double* data = particle->get_properties().data();
    into.centre[p] = to_array<dim>(particle->get_location());
    into.leaf[p] = into.order[p].leaf;
    std::array<double, dim> half_width;
    std::copy_n(data + field::half_width, dim, half_width.begin());
    into.half_width[p] = mesh.leaves().within_neighbours(into.leaf[p], into.centre[p], half_width);
    into.n_cut += into.half_width[p] != half_width;
    into.id[p] = particle->get_id();
    const SymmetricTensor b_e = left_cauchy_green(Eigen::Map<const SymmetricTensor>(data + field::elastic_strain));
    for (unsigned int i = 0; i < 6; ++i)
      b(p, i) = b_e[i];
    cell_size(p) = mesh.leaves().leaves[into.leaf[p]].size;
    std::apply([&](const auto&... copy) { (copy.take(p, data), ...); }, copies);
  }
  Kokkos::deep_copy(arrays.elastic_left_cauchy_green, b);
  Kokkos::deep_copy(arrays.cell_size, cell_size);
  std::apply([&](const auto&... copy) { (Kokkos::deep_copy(arrays.*copy.field.array, copy.values), ...); }, copies);
}

template <int dim> std::vector<std::array<double, dim>> ParticleSet<dim>::initial_positions() const
{
  std::vector<std::array<double, dim>> result;
  result.reserve(fresh().order.size());
  for (const Place& place : fresh().order)
  {
    const auto properties = place.particle->get_properties();
    result.emplace_back();
    std::copy_n(&properties[field::initial_position], dim, result.back().begin());
  }
  return result;
}

template <int dim> void ParticleSet<dim>::set_contact_gaps(const std::unordered_map<long long, double>& gaps)
{
  for (auto& particle : particles)
  {
    const auto gap = gaps.find(particle.get_id());
    particle.get_properties()[field::contact_gap] =
        gap == gaps.end() ? std::numeric_limits<double>::quiet_NaN() : gap->second;
  }
}

template <int dim> void ParticleSet<dim>::commit(const ParticleIncrements& increments, const DomainUpdate domain_update)
{
  if (!is_fresh())
    throw std::logic_error("particles changed between the solution of a step and its commit");
  const std::vector<Place>& order = mirror.order;
  const auto displacement = copy_to_host(increments.displacement);
  const auto dF = copy_to_host(increments.deformation_gradient);
  const bool moves = increments.motion.has_value(); // also where this rank's particles all wait
  const ParticleMotion motion = increments.motion.value_or(ParticleMotion());
  const auto velocity_change = copy_to_host(motion.velocity_change);
  const auto acceleration = copy_to_host(motion.acceleration);
  const auto copies = host_copies(mirror.arrays, true);

  for (std::size_t p = 0; p < order.size(); ++p)
  {
    typename Handler::particle_iterator particle = order[p].particle;
    double* data = particle->get_properties().data();
    dealii::Point<dim> position = particle->get_location();
    for (unsigned int d = 0; d < dim; ++d)
      position[d] += displacement(p, d);
    particle->set_location(position);

    double* F = data + field::deformation_gradient;
    double updated[9] = {};
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        for (unsigned int k = 0; k < 3; ++k)
          updated[3 * i + j] += dF(p, 3 * i + k) * F[3 * k + j];
    std::copy_n(updated, 9, F);
    bound_volume<dim>(data);
    std::apply([&](const auto&... copy) { (copy.commit(p, data), ...); }, copies);
    if (domain_update == DomainUpdate::stretch)
      stretch_domain<dim>(data);
    if (domain_update == DomainUpdate::flow)
    {
      double change[9];
      for (unsigned int i = 0; i < 9; ++i)
        change[i] = dF(p, i);
      follow_flow<dim>(data, change);
    }

    for (unsigned int i = 0; i < 3; ++i)
    {
      data[field::velocity + i] = moves ? data[field::velocity + i] + velocity_change(p, i) : 0.;
      data[field::acceleration + i] = moves ? acceleration(p, i) : 0.;
    }
  }
  if (!moves && order.size() < particles.n_locally_owned_particles()) // some wait outside the window
    for (auto& particle : particles)
    {
      double* data = particle.get_properties().data();
      std::fill_n(data + field::velocity, 3, 0.);
      std::fill_n(data + field::acceleration, 3, 0.);
    }
  const long long before = particles.n_global_particles();
  const double mass_before = mass();
  const std::optional<std::vector<Stray<dim>>> strays = take_out_strays();
  edit().sort_particles_into_subdomains_and_cells();
  if (strays)
    bring_in(*strays);
  const long long n_lost = before - static_cast<long long>(particles.n_global_particles());
  if (n_lost == 0)
    return;
  gone.number += n_lost;
  gone.mass += sum_over_ranks(mass_before - mass(), mesh.communicator());
}

/// Takes out the particles that have moved into parts of the grid that this rank does not know: the handler looks no
/// farther than the neighbours of the rank's cells. Returns those that have come to this rank's part, or nothing where
/// no rank has any; those off the grid are lost. Collective.
template <int dim> std::optional<std::vector<Stray<dim>>> ParticleSet<dim>::take_out_strays()
{
  const MPI_Comm communicator = mesh.communicator();
  if (size_of(communicator) == 1)
    return {};
  std::vector<std::vector<Stray<dim>>> to_owner(size_of(communicator));
  std::vector<typename Handler::particle_iterator> leaving;
  for (const Place& place : mirror.order)
    if (const auto x = to_array<dim>(place.particle->get_location()); mesh.leaves().find_leaf(x) < 0)
    {
      leaving.push_back(place.particle);
      const int owner = mesh.leaves().find_owner(x);
      if (owner < 0) // it has left the grid
        continue;
      Stray<dim>& stray = to_owner[owner].emplace_back();
      stray.position = x;
      stray.id = place.particle->get_id();
      std::copy_n(place.particle->get_properties().data(), field::count, stray.data.begin());
    }
  if (sum_over_ranks(static_cast<long long>(leaving.size()), communicator) == 0)
    return {};
  edit().remove_particles(leaving);
  std::vector<Stray<dim>> strays;
  for (const auto& part : exchange_between_ranks(to_owner, communicator))
    strays.insert(strays.end(), part.begin(), part.end());
  return strays;
}

/// Collective.
template <int dim> void ParticleSet<dim>::bring_in(const std::vector<Stray<dim>>& strays)
{
  for (const Stray<dim>& stray : strays)
    if (const int number = mesh.leaves().find_leaf(stray.position); number >= 0)
    {
      const auto& leaf = mesh.leaves().leaves[number];
      const typename BackgroundMesh<dim>::Cell cell(&mesh.triangulation(), leaf.tree_level, leaf.tree_index);
      dealii::Point<dim> x;
      for (unsigned int d = 0; d < dim; ++d)
        x[d] = stray.position[d];
      edit().insert_particle(x, mesh.mapping().transform_real_to_unit_cell(cell, x), stray.id, cell,
                             dealii::ArrayView<const double>(stray.data.data(), stray.data.size()));
    }
  edit().update_cached_numbers();
}

template <int dim> void ParticleSet<dim>::carry_through(const std::function<void()>& change)
{
  edit().prepare_for_coarsening_and_refinement();
  change();
  particles.unpack_after_coarsening_and_refinement();
  mesh.update();
}

template <int dim> void ParticleSet<dim>::balance_load(const double cost)
{
  const std::vector<double> work = cell_work(cost);
  carry_through([&] { mesh.repartition(work); });
}

template <int dim> double ParticleSet<dim>::imbalance(const double cost) const
{
  if (size_of(mesh.communicator()) == 1)
    return 1.;
  double mine = 0.;
  const std::vector<double> work = cell_work(cost);
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
    if (cell->is_locally_owned())
      mine += work[cell->active_cell_index()];
  const MPI_Comm communicator = mesh.communicator();
  return max_over_ranks(mine, communicator) * size_of(communicator) / sum_over_ranks(mine, communicator);
}

/// By active cell index, in units of an empty cell's.
template <int dim> std::vector<double> ParticleSet<dim>::cell_work(const double cost) const
{
  std::vector<double> work(mesh.triangulation().n_active_cells(), 1.);
  std::vector<unsigned int> workspace;
  for (const auto& cell : active_cells())
    for (const auto& particle : particles.particles_in_cell(cell))
    {
      const double* data = particle.get_properties().data();
      const double share = std::isfinite(data[field::contact_gap]) ? 1. + contact_work : 1.;
      work[cell->active_cell_index()] +=
          share * cost / LeafTable<dim>::n_vertices *
          count_nodes<dim>(mesh.leaves(), particle.get_location(), data + field::half_width, workspace);
    }
  return work;
}

template <int dim> long long ParticleSet<dim>::remove_if(const std::function<bool(const Accessor&)>& condition)
{
  std::vector<typename Handler::particle_iterator> doomed;
  for (auto particle = particles.begin(); particle != particles.end(); ++particle)
    if (condition(*particle))
      doomed.push_back(particle);
  const long long removed = doomed.size();
  if (removed > 0)
    ++n_changes;
  particles.remove_particles(doomed); // collective
  return sum_over_ranks(removed, mesh.communicator());
}

template <int dim> double ParticleSet<dim>::mass() const
{
  double sum = 0.;
  for (const auto& particle : particles)
    sum += particle.get_properties()[field::mass];
  return sum;
}

template <int dim> double ParticleSet<dim>::bytes() const
{
  const double in_handler = sizeof(double) * (field::count + 2. * dim) + sizeof(dealii::types::particle_index);
  const double in_arrays =
      bytes_per_particle(mirror.arrays) + sizeof(double) * 2. * dim + sizeof(unsigned int) + sizeof(long long);
  return particles.n_locally_owned_particles() * in_handler + fresh().arrays.n * in_arrays;
}

template class ParticleSet<2>;
template class ParticleSet<3>;
} // namespace kedge
