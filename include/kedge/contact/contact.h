// Contact between the corners of the particles' domains and the surfaces of rigid bodies.
#pragma once

#include <cstdint>
#include <functional>
#include <kedge/base/shared_array.h>
#include <kedge/basis/gimp.h>
#include <kedge/bodies/rigid_systems.h>
#include <kedge/contact/parameters.h>
#include <kedge/contact/surface_areas.h>
#include <kedge/contact_forces/evaluation.h>
#include <kedge/particles/splitting.h>
#include <map>
#include <mpi.h>
#include <unordered_map>

namespace kedge
{
/// What one rank knows of its particles, in the order of their arrays; lengths in m.
template <int dim> struct ContactParticles
{
  const std::vector<std::array<double, dim>>&centre, &half_width;
  const std::vector<long long>& id;
  const std::vector<double>&initial_volume, &young; ///< m3 (2-D: m2), Pa
  const std::vector<double>& travel;                ///< how far it may move in the step, m
};

/// Committed history of one corner of a particle against one surface, as plain data.
struct ContactRecord
{
  std::int64_t particle;
  std::uint32_t corner, surface;
  double tangential[3]; ///< N, world axes
  double reference_gap; ///< m
  double multiplier;    ///< of the normal force, N; 0 with penalties alone
  std::uint64_t bonded; ///< 1: also carries tension, 0: does not
  double pressure = 0.; ///< normal force on the soil, N; below 0 only where bonded
  ReferenceMemory memory;
};

/// Point-to-surface contact (Bird et al. 2025, arXiv:2412.01565): each corner of each GIMP domain against each surface,
/// by penalties in the normal and tangential direction. On a bonded surface a pair that has touched does not open;
/// springs alone hold it. With multipliers the forces that a solution has found are where the springs of the next one
/// start, until corners neither penetrate nor hold off (Uzawa's iteration; Simo & Laursen 1992,
/// doi 10.1016/0045-7949(92)90540-G). Within a step the pairs are fixed; their committed history is kept per (particle,
/// corner, surface) and follows particles from rank to rank.
///
/// Boxes do not deform as the soil does: after a step a corner of the box is not where the soil's motion has taken it.
/// The gap that a spring refers to makes up for this, and for the stiffness of a child's springs after a split: a step
/// starts from the forces that the last one has left. While a body moves across its surface, the reference fades.
template <int dim> class Contact
{
public:
  Contact(const ContactParameters& parameters, MPI_Comm communicator);

  /// Finds the corners that could touch a body during the next step and their nodes. `reach` is how far beyond its own
  /// size and travel a particle is looked at, m, by surface. Collective. `number` maps leaf-table nodes to active ones.
  void find_pairs(const RigidSystems& bodies, const LeafTable<dim>& table, const ContactParticles<dim>& particles,
                  const std::vector<unsigned int>& number, const std::vector<double>& reach);

  /// Takes the penetration of every pair as its reference, for bodies that are buried from the start. Bonds pairs of
  /// bonded surfaces that are nearer than half a particle's size where they are.
  void take_reference_gaps(const RigidSystems& bodies);

  /// After that: gives corners nearer than half a particle's size the forces, within what pressure and friction (of
  /// bonded ones: the bond) allow, that come nearest to `missing`: what soil and weight lack for balance at rest, N,
  /// dim per local node and the sum over the ranks. `sum` makes such a sum of what this rank adds. Collective.
  void replace_support(const RigidSystems& bodies, std::vector<double> missing,
                       const std::function<void(std::vector<double>&)>& sum);

  /// Goes back to the multipliers, tangential forces and patches that the step started with.
  void reset_multipliers();
  /// Takes the forces of the last evaluation as multipliers; `factor` times what that changes in the normal ones. From
  /// then on the surface is the patch that touches it where it was closest in that evaluation: the aim is a distance of
  /// zero, where the normal at an edge or a vertex is any.
  void augment(double factor);
  /// Takes the tangential forces of the last evaluation for those from which the next one starts: friction follows the
  /// path within a step.
  void follow_path();
  bool keeps_multipliers() const { return parameters.method == ContactMethod::augmented_lagrangian; }
  /// How far corners of the last evaluation that press and are not bonded are from touching, over the tolerance; below
  /// 1 augment() has nothing left to do, as always without multipliers. Collective.
  double excess() const;

  /// Forces for given nodal increments (dim for each node, m) and body increments of the step (per point); writes trial
  /// history. `committed` are the bodies at the start of the step. Nothing but the bodies' motion and what the caller
  /// copies crosses between host and device.
  const PointForces& evaluate(const RigidSystems& committed, const std::vector<Vector6>& increments,
                              const View<double*>& increment);

  /// What the last evaluation returned.
  const PointForces& points_of_last_evaluation() const { return arrays.points; }
  /// Pairs and motions of the last evaluation, to be read.
  ContactArrays arrays_of_last_evaluation() const;
  const SurfaceMotions& motions_of_last_evaluation() const { return motions; }

  /// Stiffest spring of every contact point of this rank, touching or not, summed over its surfaces, N/m.
  View<double*> point_stiffness() const;

  /// Bound on the squared frequency, 1/s2, of any body that is free on springs to all corners that could touch it, were
  /// these held. Collective.
  double largest_body_frequency(const RigidSystems& bodies) const;

  /// What the soil exerts on the bodies in the last evaluation, summed over all ranks. Collective.
  BodyLoads loads() const;
  /// Adds the sizes of the contact forces in the last evaluation (N) to entry dim * v of `sizes`. Local.
  void add_sizes(const View<double*>& sizes) const;
  /// Largest part of the contact forces on any rigid point that the soil leaves unbalanced, in the last evaluation.
  /// Entry dim * v of `share`: unbalanced force at a node over the sizes of the contact forces there. Collective.
  double unbalanced_share(const View<double*>& share) const;
  /// Their derivatives by the motion of each rigid point itself, summed over all ranks. Collective.
  BodyTangents load_tangents() const;
  /// By rigid point: whether soil pressed on its surfaces, or was bonded to them, at the end of the last step.
  /// Collective.
  std::vector<bool> points_that_press(const RigidSystems& bodies) const;
  /// Makes the trial history of the last evaluation the committed one, turned with the bodies.
  void commit();

  /// Gives the history of split particles to their children. A child's corner is bonded where all corners of the
  /// parent's edge or face that it lies on are. The normal and tangential force of each of the parent's corners goes
  /// to those of the children's corners around it that can carry it: bonded ones where it is bonded, else those no
  /// farther from the surface than the parent's, in proportion to the multilinear function of the parent's corner. So
  /// the sum of the forces is kept, and on a face that the parent's corners touch the traction is interpolated.
  /// Reference gaps of those are interpolated between the corners that have one. Other corners inside a body push
  /// nothing, except before the first search, when nothing is handed on. Soil does this before particles change ranks:
  /// a split is known to the rank that held the parent. `bodies` as they stand. Collective.
  void inherit(const std::vector<Split<dim>>& splits, const RigidSystems& bodies);

  /// Hands the history to the ranks that hold the particles now, `ids` on this one, waiting ones among them; that of
  /// particles which no rank holds is forgotten. Collective.
  void follow_particles(const std::vector<long long>& ids);

  /// The committed history that this rank keeps, by particle, corner and surface.
  std::vector<ContactRecord> export_history() const;
  /// Replaces it. The records may lie on any rank: they go to those that hold their particles, `ids` here. Collective.
  void import_history(const std::vector<ContactRecord>& records, const std::vector<long long>& ids);
  /// For a run that goes on: it has searched for pairs before, whether it found any or none.
  void remember_search() { has_searched = true; }

  /// Smallest gap of a corner of each particle in the last evaluation (m), `moved` being the bodies at its end;
  /// infinite beyond a particle's size, and missing for particles without pairs.
  std::unordered_map<long long, double> smallest_gaps(const RigidSystems& moved) const;
  /// Pairs of the last evaluation that press or are bonded, over all ranks.
  long long n_active() const;
  /// Deepest penetration of the last evaluation, m, over all ranks.
  double deepest_penetration() const;
  /// How far its spring is pressed in, in sizes of its particle; of those that are not bonded. Collective.
  double largest_compression() const;
  /// Force on the soil (N), position (m) and surface of every pair of this rank that pressed or was bonded in the last
  /// evaluation.
  struct Touch
  {
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), force = Eigen::Vector3d::Zero();
    unsigned int surface;
  };
  std::vector<Touch> touches() const;

private:
  static ContactRecord to_record(const ContactKey& key, const ContactHistory& state);
  void enter(const ContactRecord& record);
  /// Every pair responds to the next evaluation.
  void wake_all();
  /// Where the bodies' surfaces are before and after increments.
  SurfaceMotions find_motions(const RigidSystems& committed, const std::vector<Vector6>& increments) const;
  /// Pairs and rests, to be changed there.
  ContactArrays& on_device();
  void make_room_for_pairs(std::size_t most);
  /// Gives corners that carry surfaces with adhesion the area that they stand for. Collective.
  void share_adhesion(const RigidSystems& bodies, const std::function<bool(const ContactPair&)>& carries);
  /// The same for those that pressed or were bonded at the end of the last step. Collective.
  void share_adhesion(const RigidSystems& bodies);
  /// Gives a pair what it remembers.
  void remember(ContactPair& pair, const RigidSystems& bodies, bool contact_goes_on) const;
  /// Chooses the reference gap with which the pair presses at the start of the step as it did at the end of the last.
  static void settle(ContactPair& pair, const RigidSystems& bodies);
  /// The history of a parent's corners against one surface goes to its children.
  void inherit(const Split<dim>& split, std::uint32_t surface, const std::map<ContactKey, ContactHistory>& of_parent,
               const RigidSystems& bodies, const KnownDistance& known);

  ContactParameters parameters;
  MPI_Comm communicator;
  std::vector<SoilBox> boxes; ///< that the last search has found near bodies
  std::size_t n_pairs = 0;
  SharedArray<ContactPair> pairs; ///< the first n_pairs
  SharedArray<ContactRest> rests; ///< by pair
  ContactArrays arrays;           ///< their pairs and rests are set by on_device()
  SurfaceMotions motions;         ///< of the last evaluation
  View<double*> nodal_increment;  ///< of the last evaluation, m
  std::size_t n_rigid_points = 0;
  bool has_searched = false; ///< for pairs
  std::map<ContactKey, ContactHistory> history;
  std::vector<long long> known_ids; ///< of the particles that this rank had when it last followed them
  /// That of particles that the last search did not see: outside the window.
  std::map<ContactKey, ContactHistory> waiting;
};
} // namespace kedge
