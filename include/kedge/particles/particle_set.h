// The material points: deal.II's ParticleHandler keeps the committed state, plain arrays serve the kernels.
#pragma once

#include <deal.II/particles/particle_handler.h>
#include <functional>
#include <kedge/mesh/background_mesh.h>
#include <kedge/particles/arrays.h>
#include <kedge/particles/fields.h>
#include <kedge/particles/parameters.h>
#include <optional>
#include <unordered_map>

namespace kedge
{
/// A particle on its way to a rank that is not a neighbour.
template <int dim> struct Stray
{
  std::array<double, dim> position; ///< m
  long long id;
  std::array<double, field::count> data;
};

/// Particles that left the grid and were dropped, over all ranks.
struct LostParticles
{
  long long number = 0;
  double mass = 0.; ///< kg (2-D: per metre)
};

/// Particles in cells outside the mesh's window wait: the handler keeps them as they are, the arrays do not know them.
///
/// The arrays follow the handler and the mesh by themselves: what is read after a change is filled anew first, which
/// drops trial data.
template <int dim> class ParticleSet
{
public:
  using Handler = dealii::Particles::ParticleHandler<dim>;
  using Accessor = dealii::Particles::ParticleAccessor<dim>;

  explicit ParticleSet(BackgroundMesh<dim>& mesh);

  const Handler& handler() const { return particles; }
  /// The same for a change of the particles.
  Handler& edit();

  /// Per particle of this rank: what the kernels know of it, centre and half-widths of its domain (m), number, leaf.
  const ParticleArrays& arrays() const { return fresh().arrays; }
  const std::vector<std::array<double, dim>>& positions() const { return fresh().centre; }
  /// No domain reaches beyond the neighbours of its cell: LeafTable::within_neighbours.
  const std::vector<std::array<double, dim>>& half_widths() const { return fresh().half_width; }
  /// Particles of this rank whose domain would reach beyond, and is cut.
  long long n_cut() const { return fresh().n_cut; }
  const std::vector<unsigned int>& leaves() const { return fresh().leaf; }
  const std::vector<long long>& ids() const { return fresh().id; }
  /// In the same order: centres at the start of the run (m), taken from the handler.
  std::vector<std::array<double, dim>> initial_positions() const;

  /// Notes the smallest gap (m) of each particle that is near a body; the others get NaN.
  void set_contact_gaps(const std::unordered_map<long long, double>& gaps);

  /// Makes the trial state of a converged step the committed one and re-sorts the particles into cells and ranks.
  /// Collective.
  void commit(const ParticleIncrements& increments, DomainUpdate domain_update);

  /// Carries the particles through a change of the forest's cells and updates the mesh. Collective.
  void carry_through(const std::function<void()>& change);

  /// Spreads cells with their particles anew over the ranks. `cost` is the work of a particle that sees the nodes of
  /// one regular cell, relative to an empty cell's work; that of others grows with the nodes they see, and where the
  /// last step had them near a body; waiting particles cost nothing. Collective.
  void balance_load(double cost);
  /// Work of the busiest rank over the mean, at least 1. Collective.
  double imbalance(double cost) const;

  /// Removes the particles for which a condition on position and properties holds; returns their number over all ranks.
  long long remove_if(const std::function<bool(const Accessor&)>& condition);

  long long n_global() const { return particles.n_global_particles(); }
  /// Since the set was made.
  const LostParticles& lost() const { return gone; }

  /// Of this rank's particles, kg (2-D: per metre).
  double mass() const;

  /// Bytes that the particles of this rank take, in deal.II's handler and in the arrays.
  double bytes() const;

private:
  struct Place
  {
    unsigned int leaf;
    typename Handler::particle_iterator particle;
  };
  /// What is filled from the handler, with the change of the particles and of the mesh that it belongs to.
  struct Mirror
  {
    std::vector<Place> order;
    ParticleArrays arrays;
    std::vector<std::array<double, dim>> centre, half_width;
    std::vector<unsigned int> leaf;
    std::vector<long long> id;
    long long n_cut = 0;
    unsigned long change = 0, mesh_version = 0;
  };

  bool is_fresh() const { return mirror.change == n_changes && mirror.mesh_version == mesh.version(); }
  const Mirror& fresh() const;
  void fill(Mirror& into) const;
  std::vector<typename BackgroundMesh<dim>::Cell> active_cells() const;
  /// By leaf and number: how cells were refined and in which order particles came does not show in any sum over them,
  /// so that a run that was restarted goes on bit for bit.
  std::vector<Place> sort_active() const;
  std::vector<double> cell_work(double cost) const;
  std::optional<std::vector<Stray<dim>>> take_out_strays();
  void bring_in(const std::vector<Stray<dim>>& strays);

  BackgroundMesh<dim>& mesh;
  Handler particles;
  mutable Mirror mirror;       ///< filled when it is read
  unsigned long n_changes = 1; ///< of the particles
  LostParticles gone;
};
} // namespace kedge
