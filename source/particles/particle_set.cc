#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/materials/hencky.h>
#include <kedge/particles/particle_set.h>
#include <limits>

namespace kedge
{
namespace
{
template <int dim> std::array<double, dim> to_array(const dealii::Point<dim>& point)
{
  std::array<double, dim> x;
  for (unsigned int d = 0; d < dim; ++d)
    x[d] = point[d];
  return x;
}

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

ParticleArrays allocate_arrays(const std::size_t n)
{
  using Kokkos::view_alloc;
  using Kokkos::WithoutInitializing;
  ParticleArrays arrays;
  arrays.n = n;
  arrays.elastic_left_cauchy_green =
      decltype(arrays.elastic_left_cauchy_green)(view_alloc("left Cauchy-Green", WithoutInitializing), n);
  arrays.young = View<double*>(view_alloc("young", WithoutInitializing), n);
  arrays.initial_volume = View<double*>(view_alloc("volume", WithoutInitializing), n);
  arrays.mass = View<double*>(view_alloc("mass", WithoutInitializing), n);
  arrays.layer = View<unsigned int*>(view_alloc("layer", WithoutInitializing), n);
  arrays.cell_size = View<double*>(view_alloc("cell size", WithoutInitializing), n);
  arrays.velocity = View<double* [3]>(view_alloc("velocity", WithoutInitializing), n);
  arrays.acceleration = View<double* [3]>(view_alloc("acceleration", WithoutInitializing), n);
  arrays.trial_strain = decltype(arrays.trial_strain)(view_alloc("trial strain", WithoutInitializing), n);
  arrays.trial_stress = decltype(arrays.trial_stress)(view_alloc("trial stress", WithoutInitializing), n);
  arrays.trial_plastic = View<double*>(view_alloc("trial plastic", WithoutInitializing), n);
  arrays.state = decltype(arrays.state)("state", n);
  arrays.trial_state = decltype(arrays.trial_state)("trial state", n);
  return arrays;
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

template <int dim> void ParticleSet<dim>::load()
{
  order = sort_active();
  const std::size_t n = order.size();
  if (n != mirror.n || mirror.young.extent(0) != n)
    mirror = allocate_arrays(n);
  centre.resize(n);
  half_width.resize(n);
  leaf.resize(n);
  id.resize(n);

  auto b = Kokkos::create_mirror_view(mirror.elastic_left_cauchy_green);
  auto young = Kokkos::create_mirror_view(mirror.young);
  auto volume = Kokkos::create_mirror_view(mirror.initial_volume);
  auto mass = Kokkos::create_mirror_view(mirror.mass);
  auto layer = Kokkos::create_mirror_view(mirror.layer);
  auto cell_size = Kokkos::create_mirror_view(mirror.cell_size);
  auto velocity = Kokkos::create_mirror_view(mirror.velocity);
  auto acceleration = Kokkos::create_mirror_view(mirror.acceleration);
  auto strain = Kokkos::create_mirror_view(mirror.trial_strain);
  auto stress = Kokkos::create_mirror_view(mirror.trial_stress);

  for (std::size_t p = 0; p < n; ++p)
  {
    const auto& particle = order[p].particle;
    const double* data = particle->get_properties().data();
    centre[p] = to_array<dim>(particle->get_location());
    std::copy_n(data + field::half_width, dim, half_width[p].begin());
    leaf[p] = order[p].leaf;
    id[p] = particle->get_id();
    const SymmetricTensor b_e = left_cauchy_green(Eigen::Map<const SymmetricTensor>(data + field::elastic_strain));
    for (unsigned int i = 0; i < 6; ++i)
    {
      b(p, i) = b_e[i];
      strain(p, i) = data[field::elastic_strain + i];
      stress(p, i) = data[field::stress + i];
    }
    for (unsigned int i = 0; i < 3; ++i)
    {
      velocity(p, i) = data[field::velocity + i];
      acceleration(p, i) = data[field::acceleration + i];
    }
    young(p) = data[field::young];
    volume(p) = data[field::initial_volume];
    mass(p) = data[field::mass];
    layer(p) = static_cast<unsigned int>(data[field::layer]);
    cell_size(p) = mesh.leaves().leaves[leaf[p]].size;
  }

  Kokkos::deep_copy(mirror.elastic_left_cauchy_green, b);
  Kokkos::deep_copy(mirror.young, young);
  Kokkos::deep_copy(mirror.initial_volume, volume);
  Kokkos::deep_copy(mirror.mass, mass);
  Kokkos::deep_copy(mirror.layer, layer);
  Kokkos::deep_copy(mirror.cell_size, cell_size);
  Kokkos::deep_copy(mirror.velocity, velocity);
  Kokkos::deep_copy(mirror.acceleration, acceleration);
  Kokkos::deep_copy(mirror.trial_strain, strain);
  Kokkos::deep_copy(mirror.trial_stress, stress);
  Kokkos::deep_copy(mirror.trial_plastic, 0.);
}

template <int dim> void ParticleSet<dim>::set_contact_gaps(const std::map<long long, double>& gaps)
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
  const auto displacement = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), increments.displacement);
  const auto dF = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), increments.deformation_gradient);
  const auto velocity_change =
      Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), increments.motion.velocity_change);
  const auto acceleration = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), increments.motion.acceleration);
  const bool moves = increments.motion.acceleration.extent(0) > 0;
  const auto strain = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), mirror.trial_strain);
  const auto stress = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), mirror.trial_stress);
  const auto plastic = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), mirror.trial_plastic);

  for (std::size_t p = 0; p < order.size(); ++p)
  {
    auto& particle = order[p].particle;
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
    if (domain_update == DomainUpdate::stretch)
      for (unsigned int d = 0; d < dim; ++d)
        data[field::half_width + d] = data[field::initial_half_width + d] * std::min(1.99, F[4 * d]);

    for (unsigned int i = 0; i < 6; ++i)
    {
      data[field::elastic_strain + i] = strain(p, i);
      data[field::stress + i] = stress(p, i);
    }
    data[field::plastic_strain] += plastic(p);
    for (unsigned int i = 0; i < 3; ++i)
    {
      data[field::velocity + i] = moves ? data[field::velocity + i] + velocity_change(p, i) : 0.;
      data[field::acceleration + i] = moves ? acceleration(p, i) : 0.;
    }
  }
  const long long before = particles.n_global_particles();
  particles.sort_particles_into_subdomains_and_cells();
  lost += before - static_cast<long long>(particles.n_global_particles());
}

template <int dim> void ParticleSet<dim>::carry_through(const std::function<void()>& change)
{
  particles.prepare_for_coarsening_and_refinement();
  change();
  particles.unpack_after_coarsening_and_refinement();
  mesh.update();
}

template <int dim> void ParticleSet<dim>::balance_load(BackgroundMesh<dim>& mesh_, const double cost)
{
  const std::vector<double> work = cell_work(cost);
  carry_through([&] { mesh_.repartition(work); });
}

template <int dim> double ParticleSet<dim>::imbalance(const double cost) const
{
  double mine = 0.;
  const std::vector<double> work = cell_work(cost);
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
    if (cell->is_locally_owned())
      mine += work[cell->active_cell_index()];
  const MPI_Comm communicator = mesh.triangulation().get_communicator();
  return max_over_ranks(mine, communicator) * size_of(communicator) / sum_over_ranks(mine, communicator);
}

/// By active cell index, in units of an empty cell's.
template <int dim> std::vector<double> ParticleSet<dim>::cell_work(const double cost) const
{
  std::vector<double> work(mesh.triangulation().n_active_cells(), 1.);
  std::vector<unsigned int> workspace;
  for (const auto& cell : active_cells())
    for (const auto& particle : particles.particles_in_cell(cell))
      work[cell->active_cell_index()] +=
          cost / LeafTable<dim>::n_vertices *
          count_nodes<dim>(mesh.leaves(), particle.get_location(), particle.get_properties().data() + field::half_width,
                           workspace);
  return work;
}

template <int dim> long long ParticleSet<dim>::remove_if(const std::function<bool(const Accessor&)>& condition)
{
  std::vector<typename Handler::particle_iterator> doomed;
  for (auto particle = particles.begin(); particle != particles.end(); ++particle)
    if (condition(*particle))
      doomed.push_back(particle);
  const long long removed = doomed.size();
  particles.remove_particles(doomed);
  return sum_over_ranks(removed, mesh.triangulation().get_communicator());
}

template <int dim> double ParticleSet<dim>::bytes() const
{
  const double in_handler = sizeof(double) * (field::count + 2. * dim) + sizeof(dealii::types::particle_index);
  const double in_arrays =
      sizeof(double) * (6. + 3. + 6. + 6. + 6. + 1. + 2. * dim) + 2. * sizeof(unsigned int) + sizeof(long long);
  return particles.n_locally_owned_particles() * in_handler + mirror.n * in_arrays;
}

template class ParticleSet<2>;
template class ParticleSet<3>;
} // namespace kedge
