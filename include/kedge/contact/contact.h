// Contact between the corners of the particles' domains and the surfaces of rigid bodies.
#pragma once

#include <cstdint>
#include <functional>
#include <kedge/basis/gimp.h>
#include <kedge/bodies/rigid_systems.h>
#include <kedge/contact/coulomb.h>
#include <kedge/contact/parameters.h>
#include <kedge/contact/point_forces.h>
#include <kedge/particles/splitting.h>
#include <map>
#include <mpi.h>
#include <optional>

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

/// How contact couples soil and bodies at the last evaluation: exact derivatives, where the motion of a rigid point is
/// its velocity and spin in world axes (generalised_map turns increments into them).
struct ContactCoupling
{
  struct Entry
  {
    unsigned int contact_point; ///< of PointForces, on this rank
    unsigned int rigid_point;
    Eigen::Matrix<double, 3, 6> force_by_body; ///< of the force on the soil
    Eigen::Matrix<double, 6, 3> load_by_soil;  ///< of the load on the rigid point, by the soil point's displacement
  };
  std::vector<Entry> entries;
  std::vector<Eigen::Matrix<double, 6, 6>> load_by_body; ///< per rigid point, over all ranks
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
/// starts from the forces that the last one has left. While a body moves, the reference fades.
template <int dim> class Contact
{
public:
  Contact(const ContactParameters& parameters, MPI_Comm communicator);

  /// Finds the corners that could touch a body during the next step and their nodes. `reach` is how far beyond its own
  /// size and travel a particle is looked at, m. Collective. `number` maps leaf-table nodes to active ones.
  void find_pairs(const RigidSystems& bodies, const LeafTable<dim>& table, const ContactParticles<dim>& particles,
                  const std::vector<unsigned int>& number, double reach);

  /// Takes the penetration of every pair as its reference, for bodies that are buried from the start. Bonds pairs of
  /// bonded surfaces that are nearer than half a particle's size where they are.
  void take_reference_gaps(const RigidSystems& bodies);

  /// After that: gives corners nearer than half a particle's size the forces, within what pressure and friction (of
  /// bonded ones: the bond) allow, that come nearest to `missing`: what soil and weight lack for balance at rest, N,
  /// dim per local node and the sum over the ranks. `sum` makes such a sum of what this rank adds. Collective.
  void replace_support(const RigidSystems& bodies, std::vector<double> missing,
                       const std::function<void(std::vector<double>&)>& sum);

  /// Goes back to the multipliers, tangential forces and planes that the step started with.
  void reset_multipliers();
  /// Takes the forces of the last evaluation as multipliers; `factor` times what that changes in the normal ones. From
  /// then on the surface is the plane that touches it where it was closest in that evaluation: the aim is a distance of
  /// zero, where the normal at an edge or a vertex is any.
  void augment(double factor);
  /// Takes the tangential forces of the last evaluation for those from which the next one starts: friction follows the
  /// path within a step.
  void follow_path();
  /// How far corners of the last evaluation that press and are not bonded are from touching, over the tolerance; below
  /// 1 augment() has nothing left to do, as always without multipliers. Collective.
  double excess() const;

  /// Forces for given nodal increments (dim for each of n_nodes, m) and body increments of the step (per point); writes
  /// trial history. `committed` are the bodies at the start of the step.
  const PointForces& evaluate(const RigidSystems& committed, const std::vector<Vector6>& increments,
                              const double* increment, std::size_t n_nodes);

  /// What the last evaluation returned.
  const PointForces& points_of_last_evaluation() const { return points; }

  /// Stiffest spring of every contact point of this rank, touching or not, summed over its surfaces, N/m.
  std::vector<double> point_stiffness() const;

  /// Bound on the squared frequency, 1/s2, of any body that is free on springs to all corners that could touch it, were
  /// these held. Collective.
  double largest_body_frequency(const RigidSystems& bodies) const;

  /// What the soil exerts on the bodies in the last evaluation, summed over all ranks. Collective.
  BodyLoads loads(const RigidSystems& committed, const std::vector<Vector6>& increments) const;

  /// Derivatives of the last evaluation. Collective.
  ContactCoupling coupling(const RigidSystems& committed, const std::vector<Vector6>& increments) const;

  /// Makes the trial history of the last evaluation the committed one, turned with the bodies.
  void commit();

  /// Gives the history of split particles to their children. A child's corner is bonded where all corners of the
  /// parent's edge or face that it lies on are. The normal and tangential force of each of the parent's corners goes
  /// to those of the children's corners around it that can carry it: bonded ones where it is bonded, else those no
  /// farther from the surface than the parent's, in proportion to the multilinear function of the parent's corner. So
  /// the sum of the forces is kept, and on a face that the parent's corners touch the traction is interpolated.
  /// Reference gaps of those are interpolated between the corners that have one. Other corners inside a body push
  /// nothing. Soil does this before particles change ranks: a split is known to the rank that held the parent. `bodies`
  /// as they stand.
  void inherit(const std::vector<Split<dim>>& splits, const RigidSystems& bodies);

  /// Hands the history to the ranks that hold the particles now, `ids` on this one, waiting ones among them; that of
  /// particles which no rank holds is forgotten. Collective.
  void follow_particles(const std::vector<long long>& ids);

  /// The committed history that this rank keeps, by particle, corner and surface.
  std::vector<ContactRecord> export_history() const;
  /// Replaces it. The records may lie on any rank: they go to those that hold their particles, `ids` here. Collective.
  void import_history(const std::vector<ContactRecord>& records, const std::vector<long long>& ids);

  /// Smallest gap of a corner of each particle in the last evaluation (m), `moved` being the bodies at its end;
  /// infinite beyond a particle's size, and missing for particles without pairs.
  std::map<long long, double> smallest_gaps(const RigidSystems& moved) const;
  /// Pairs of the last evaluation that press or are bonded, over all ranks.
  long long n_active() const;
  /// Deepest penetration of the last evaluation, m, over all ranks.
  double deepest_penetration() const;
  /// Force on the soil (N), position (m) and surface of every pair of this rank that pressed or was bonded in the last
  /// evaluation.
  struct Touch
  {
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), force = Eigen::Vector3d::Zero();
    unsigned int surface;
  };
  const std::vector<Touch>& touches() const { return touching; }

private:
  struct Key
  {
    long long particle;
    std::uint32_t corner, surface;
    bool operator<(const Key& other) const
    {
      return std::tie(particle, corner, surface) < std::tie(other.particle, other.corner, other.surface);
    }
  };
  struct History
  {
    Eigen::Vector3d tangential = Eigen::Vector3d::Zero(); ///< N, world axes
    double reference_gap = 0.;                            ///< m
    double multiplier = 0.;                               ///< of the normal force, N
    bool bonded = false;                                  ///< also carries tension
    double pressure = 0.;                                 ///< normal force, N; below 0 only where bonded
  };
  static ContactRecord to_record(const Key& key, const History& state);
  void enter(const ContactRecord& record);

  struct Pair
  {
    Key key;
    unsigned int point;    ///< of PointForces
    Eigen::Vector3d start; ///< corner at the start of the step, m
    ContactStiffness stiffness;
    double size = 0.;   ///< of the particle, m
    bool bonds = false; ///< whether the surface is one that bonds what touches it
    History committed, trial;
    History augmented, proposed; ///< multipliers in use and from the last evaluation, axes as at the start of the step
    double gap = 0.;             ///< signed distance in the last evaluation
    double reference_gap = 0.;   ///< in the last evaluation: faded
    Eigen::Vector3d fading = Eigen::Vector3d::Zero();     ///< d reference gap / d place of the body
    Eigen::Vector3d carried = Eigen::Vector3d::Zero();    ///< the corner's start, moved with the body, m
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();     ///< out of the body, in the last evaluation
    Eigen::Vector3d slip = Eigen::Vector3d::Zero();       ///< in the last evaluation, in the body's frame, m
    Eigen::Vector3d slip_begin = Eigen::Vector3d::Zero(); ///< what the tangential force in use belongs to, so too
    KnownDistance known;                                  ///< in the body's frame
    bool on_plane = false;                                ///< a plane stands for the surface
    ClosestPoint plane; ///< that touches the surface, with the gap of the corner at the start of the step; in the
                        ///< body's frame
    bool active = false;
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), force = Eigen::Vector3d::Zero();
    Eigen::Matrix3d tangent = Eigen::Matrix3d::Zero(); ///< d force / d soil point
  };

  /// What evaluations need of a pair that is far from touching, so that they leave it alone.
  struct Rest
  {
    unsigned int point, surface;
    double lever;          ///< distance of the corner from the body's origin at the start of the step, m
    double clearance = 0.; ///< m that they may go against each other, from the start of the step, without touching
    bool asleep = false;   ///< the last response is that of a pair that touches nothing
  };
  /// Bound on how far a body takes a corner that goes with it: `shift` + `turn` * lever, m.
  struct Approach
  {
    double shift, turn;
  };

  static std::vector<Approach> find_approaches(const RigidSystems& committed, const std::vector<Pose>& moved);
  void wake_all();
  /// Chooses the reference gap with which the pair presses at the start of the step as it did at the end of the last.
  static void settle(Pair& pair, const RigidSystems& bodies);
  /// The history of a parent's corners against one surface goes to its children.
  void inherit(const Split<dim>& split, std::uint32_t surface, const std::map<Key, History>& of_parent,
               const RigidSystems& bodies, const KnownDistance& known);
  Eigen::Vector3d corner_displacement(unsigned int point) const;
  /// The surface as a pair sees it from x, in the body's frame; nothing beyond `distance` (m) from the surface itself.
  static std::optional<ClosestPoint> find_closest(Pair& pair, const Surface& surface, const Pose& before,
                                                  const Eigen::Vector3d& x, double distance);
  static void put_to_rest(const Pair& pair, const Surface& surface, const Pose& now, Rest& rest);
  static void fade(Pair& pair, const Eigen::Vector3d& carried);
  /// Forces and trial history of a pair at its position, its body having moved.
  void respond(Pair& pair, const Surface& surface, const Pose& before, const Pose& now) const;

  ContactParameters parameters;
  MPI_Comm communicator;
  std::vector<Pair> pairs;
  std::vector<Rest> rests;             ///< by pair
  std::vector<double> nodal_increment; ///< of the last evaluation, m
  PointForces points;
  std::vector<unsigned int> acting; ///< points on which the last evaluation has left forces, with repetitions
  std::map<Key, History> history;
  std::vector<long long> known_ids; ///< of the particles that this rank had when it last followed them
  std::map<Key, History> waiting;   ///< that of particles that the last search did not see: outside the window
  std::vector<Touch> touching;
};
} // namespace kedge
