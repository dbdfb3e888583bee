// The soil of a run, with one owner: mesh, material points, laws of the layers, history of the contacts.
#pragma once

#include <kedge/contact/contact.h>
#include <kedge/materials/material.h>
#include <kedge/particles/cleaning.h>
#include <kedge/soil/prediction.h>

namespace kedge
{
/// What a converged step does to the soil.
struct SoilIncrements
{
  ParticleIncrements particles;
  Prediction prediction; ///< for the next step
};

/// The parts of a soil, for what builds it from outside: restart files and tests.
template <int dim> struct SoilParts
{
  BackgroundMesh<dim>& mesh;
  ParticleSet<dim>& particles;
  Contact<dim>& contact;
  Prediction& prediction;
  long long& n_deleted;
};

/// Mesh, material points and the history of their contacts change together or not at all: every verb leaves cells,
/// partition, particles, contact history and prediction consistent with each other on all ranks. All verbs are
/// collective.
template <int dim> class Soil
{
public:
  /// A mesh of base cells without material points.
  Soil(const GridLayout<dim>& layout, const MaterialPointParameters& parameters, const ContactParameters& contact,
       MPI_Comm communicator);
  Soil(const Soil&) = delete;
  Soil& operator=(const Soil&) = delete;

  const MaterialPointParameters& parameters() const { return given; }
  const BackgroundMesh<dim>& mesh() const { return grid; }
  const ParticleSet<dim>& particles() const { return points; }
  const Materials& materials() const { return laws; }
  /// Steps evaluate trial contacts; only commit() makes them history.
  Contact<dim>& contact() { return contacts; }
  const Contact<dim>& contact() const { return contacts; }
  /// The guess for the next step.
  const Prediction& prediction() const { return guess; }
  MPI_Comm communicator() const { return grid.communicator(); }

  /// Material points deleted or lost since the run began, over all ranks.
  long long n_deleted() const { return deleted + points.lost().number; }
  /// Cells in the window that hold material points, over all ranks.
  long long count_cells() const;

  /// Fills the block with material points and spreads them over the ranks. `gravity` is its magnitude, m/s2.
  void generate(double gravity);

  /// Puts the window around the bodies, whatever it was before, or lets it follow them (see mesh/window.h). Deletes
  /// the material points that it leaves behind for good and wakes those that it reaches.
  void place_window(const RigidSystems& bodies, const BoundaryTrack& track);
  void move_window(const RigidSystems& bodies, const BoundaryTrack& track);

  /// Removes the material points with which no step can be solved, one with inertia (dynamic, explicit) or without
  /// (static).
  HopelessParticles clean(bool has_inertia);

  /// Refines, coarsens, splits and merges until cells and material points have the sizes that the stage asks for at the
  /// bodies' surfaces. Returns whether anything changed, be it the partition alone.
  bool adapt(const RigidSystems& bodies, const Adaptivity& adaptivity);

  /// Splits the material points that have come into cells too small for them. Returns whether there were any.
  bool split(const RigidSystems& bodies);

  /// Removes the material points whose centre or the larger part of whose box lies inside bodies, or that lie in a slit
  /// between two bodies where no two of them fit side by side; returns their number.
  long long remove_buried(const RigidSystems& bodies);

  /// Makes the trial state of a converged step the committed one. `bodies`: as the step leaves them where it had
  /// contact, else null.
  void commit(const SoilIncrements& increments, const RigidSystems* bodies);

  /// The next step starts from rest.
  void forget_prediction() { guess.reset(); }

  /// For restart files and tests. Material points renew their arrays by themselves; whoever sends points to other
  /// ranks or cells sends their history after them.
  SoilParts<dim> parts() { return {grid, points, contacts, guess, deleted}; }

private:
  void set_window(const Window<dim>& window, const BoundaryTrack& track);
  void set_initial_state();
  bool balance_where_it_pays();
  void merge();
  void follow_particles();

  MaterialPointParameters given;
  BackgroundMesh<dim> grid;
  ParticleSet<dim> points;
  Materials laws;
  Contact<dim> contacts;
  Prediction guess;
  long long deleted = 0;                 ///< without those that the particle set lost
  std::optional<double> gravity_at_rest; ///< m/s2, until the first step is committed
};

/// A material point's work in a step relative to that of an empty cell, for the partition.
constexpr double particle_cost = 20.;

/// Numbers of all particles of this rank, those that wait outside the window too.
template <int dim> std::vector<long long> all_ids(const ParticleSet<dim>& particles);

/// Bounds of all surfaces as they stand, along the axes of the mesh.
template <int dim> Extent<dim> extent_of(const RigidSystems& bodies);
} // namespace kedge
