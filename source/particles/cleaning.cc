#include "domain.h"
#include <Eigen/LU>
#include <algorithm>
#include <deal.II/grid/grid_tools.h>
#include <kedge/base/communication.h>
#include <kedge/particles/cleaning.h>

namespace kedge
{
namespace
{
/// Share of a material's volume that is left.
bool is_sound(const double volume_ratio)
{
  return volume_ratio >= least_volume_ratio &&
         volume_ratio <= (1. + 1e-9) * largest_volume_ratio; // round-off of a bound
}

template <int dim> bool is_distorted(const typename ParticleSet<dim>::Accessor& particle)
{
  const double* data = particle.get_properties().data();
  bool is_finite = true;
  for_each_field(
      [&](const FieldDeclaration& field, const unsigned int at)
      {
        const bool may_be_missing = std::isnan(field.initial);
        for (unsigned int i = at; !may_be_missing && i < at + n_components(field.kind); ++i)
          is_finite = is_finite && std::isfinite(data[i]);
      });
  if (!is_finite)
    return true;
  for (unsigned int d = 0; d < dim; ++d)
    if (!(data[field::half_width + d] > 0.))
      return true;
  const double ratio =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data + field::deformation_gradient).determinant();
  const double* strain = data + field::elastic_strain;
  return !is_sound(ratio) || !is_sound(std::exp(strain[0] + strain[1] + strain[2]));
}

template <int dim> bool is_active(const BackgroundMesh<dim>& mesh, const typename ParticleSet<dim>::Accessor& particle)
{
  return mesh.in_window(particle.get_surrounding_cell());
}

/// For each axis the leaf and those across its two faces.
template <int dim>
std::vector<unsigned int> leaf_and_face_neighbours(const LeafTable<dim>& table, const unsigned int number)
{
  const auto& leaf = table.leaves[number];
  std::vector<unsigned int> found;
  for (unsigned int axis = 0; axis < dim; ++axis)
  {
    std::array<double, dim> lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
    {
      const double out = (d == axis ? 0.25 : -0.25) * leaf.size; // 2:1: a neighbour is at least half as large
      lower[d] = leaf.lower[d] - out;
      upper[d] = leaf.lower[d] + leaf.size + out;
    }
    table.find_leaves(lower, upper, found);
  }
  return found;
}

/// Gives ghost leaves the number of their owner.
template <int dim> void send_to_ghosts(const BackgroundMesh<dim>& mesh, std::vector<long long>& of_leaf)
{
  if (size_of(mesh.communicator()) > 1)
    dealii::GridTools::exchange_cell_data_to_ghosts<long long, dealii::Triangulation<dim>>(
        mesh.triangulation(), [&](const auto& cell) { return of_leaf[mesh.leaf_number(cell)]; },
        [&](const auto& cell, const long long number) { of_leaf[mesh.leaf_number(cell)] = number; });
}

/// Numbers of centres in each owned and ghost leaf. Where there are others, so are their domains: only particles alone
/// may be isolated.
template <int dim> class Centres
{
public:
  Centres(const ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh_)
      : mesh(mesh_), count(mesh.leaves().leaves.size(), 0)
  {
    for (const auto& particle : particles.handler())
      if (is_active(mesh, particle))
        ++count[mesh.leaf_number(particle.get_surrounding_cell())];
    send_to_ghosts(mesh, count);
  }

  bool is_alone(const typename ParticleSet<dim>::Accessor& particle) const
  {
    const unsigned int own = mesh.leaf_number(particle.get_surrounding_cell());
    if (count[own] != 1) // 0: it is not active
      return false;
    const std::vector<unsigned int> around = leaf_and_face_neighbours(mesh.leaves(), own);
    return std::all_of(around.begin(), around.end(),
                       [&](const unsigned int leaf) { return leaf == own || count[leaf] == 0; });
  }

private:
  const BackgroundMesh<dim>& mesh;
  std::vector<long long> count;
};

/// Numbers of domains that reach into each owned and ghost leaf.
template <int dim> class Crowding
{
public:
  using Position = std::array<double, dim>;

  Crowding(const ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh_)
      : mesh(mesh_), table(mesh.leaves()), count(table.leaves.size(), 0)
  {
    for (const auto& particle : particles.handler())
      if (is_active(mesh, particle))
        for (const unsigned int leaf : leaves_of(particle))
          ++count[leaf];
    send_to_owners();
    send_to_ghosts(mesh, count);
  }

  /// Of an active particle.
  bool is_isolated(const typename ParticleSet<dim>::Accessor& particle) const
  {
    const std::vector<unsigned int> own = leaves_of(particle);
    for (const unsigned int leaf : leaf_and_face_neighbours(table, mesh.leaf_number(particle.get_surrounding_cell())))
      if (count[leaf] > std::count(own.begin(), own.end(), leaf))
        return false;
    return true;
  }

private:
  std::vector<unsigned int> leaves_of(const typename ParticleSet<dim>::Accessor& particle) const
  {
    Position x, half, lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
    {
      x[d] = particle.get_location()[d];
      half[d] = particle.get_properties()[field::half_width + d];
    }
    half = table.within_neighbours(mesh.leaf_number(particle.get_surrounding_cell()), x, half);
    for (unsigned int d = 0; d < dim; ++d)
    {
      lower[d] = std::max(table.lower_end(d), x[d] - half[d]);
      upper[d] = std::min(table.upper_end(d), x[d] + half[d]);
    }
    std::vector<unsigned int> found;
    table.find_leaves(lower, upper, found);
    return found;
  }

  void send_to_owners()
  {
    const MPI_Comm communicator = mesh.communicator();
    struct Parcel
    {
      Position centre; ///< of the leaf, m
      long long count;
    };
    std::vector<std::vector<Parcel>> to_owner(size_of(communicator));
    for (std::size_t i = 0; i < table.leaves.size(); ++i)
    {
      const auto& leaf = table.leaves[i];
      if (leaf.owned || count[i] == 0)
        continue;
      Parcel parcel{leaf.lower, count[i]};
      for (double& x : parcel.centre)
        x += 0.5 * leaf.size;
      to_owner[leaf.owner].push_back(parcel);
    }
    for (const auto& parcels : exchange_between_ranks(to_owner, communicator))
      for (const Parcel& parcel : parcels)
        count[table.find_leaf(parcel.centre)] += parcel.count;
  }

  const BackgroundMesh<dim>& mesh;
  const LeafTable<dim>& table;
  std::vector<long long> count;
};

/// Returns their number over all ranks; `weigh` is called for each.
template <int dim, typename Weigh>
long long remove_isolated(ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh, const Weigh& weigh)
{
  const Centres<dim> centres(particles, mesh);
  long long alone = 0;
  for (const auto& particle : particles.handler())
    alone += centres.is_alone(particle);
  if (sum_over_ranks(alone, mesh.communicator()) == 0)
    return 0;
  const Crowding<dim> crowding(particles, mesh);
  return particles.remove_if(
      [&](const auto& particle)
      { return centres.is_alone(particle) && crowding.is_isolated(particle) && weigh(particle); });
}
} // namespace

template <int dim>
HopelessParticles remove_hopeless_particles(ParticleSet<dim>& particles, const BackgroundMesh<dim>& mesh,
                                            const bool has_inertia)
{
  HopelessParticles removed;
  double mass = 0.;
  const auto weigh = [&](const auto& particle)
  {
    const double here = particle.get_properties()[field::mass];
    mass += std::isfinite(here) ? here : 0.;
    return true;
  };
  removed.distorted =
      particles.remove_if([&](const auto& particle) { return is_distorted<dim>(particle) && weigh(particle); });
  if (!has_inertia)
    removed.isolated = remove_isolated(particles, mesh, weigh);
  if (removed.distorted + removed.isolated > 0) // which all ranks know: most steps need no sum
    removed.mass = sum_over_ranks(mass, mesh.communicator());
  return removed;
}

template HopelessParticles remove_hopeless_particles<2>(ParticleSet<2>&, const BackgroundMesh<2>&, bool);
template HopelessParticles remove_hopeless_particles<3>(ParticleSet<3>&, const BackgroundMesh<3>&, bool);
} // namespace kedge
