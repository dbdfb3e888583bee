// What a user sees of a run: the terminal and summary.json.
#pragma once

#include <chrono>
#include <kedge/base/failure.h>
#include <kedge/base/report.h>
#include <kedge/bodies/passage.h>
#include <kedge/output/summary.h>
#include <kedge/particles/cleaning.h>
#include <kedge/simulation/simulation.h>
#include <kedge/solvers/newton.h>
#include <kedge/steps/stable_step.h>
#include <kedge/time/clock.h>

namespace kedge
{
/// What there is at the end of a step, over all ranks.
struct StepSummary
{
  unsigned int step = 1;                ///< global counter
  long long particles = 0, deleted = 0; ///< now; since the run began
  long long dofs = 0;                   ///< of the step just solved
  double penetration = 0.;              ///< deepest, m
  double compression = 0.;              ///< of the contact springs, the largest, in sizes of material points
};

/// "1.20e-01 3.40e-05", the residuals of a step.
std::string format_residuals(const NewtonReport& newton);

/// Speaks on rank 0 only. Collective where it says so.
class RunLog
{
public:
  RunLog(const Input& input, const RunOptions& options);

  Report& report() { return terminal; }
  Timings& timings() { return clock_of_phases; }
  /// Converged steps of the present stage.
  unsigned int steps_in_stage() const { return summary.stages.back().steps; }

  /// Writes a first summary, so that a reader knows where the bodies start. Collective.
  void begin_stage(const SteppingParameters& stepping, const RigidSystems& bodies);
  /// What a restart file keeps of the stages so far, and how a run goes on from it in the stage that it stopped in.
  std::string text_of_stages();
  void resume(const SteppingParameters& stepping, const std::string& text, unsigned int stage_number);
  /// Critical time step of an explicit stage and that of its soil alone, s: told once in a stage, with warnings once a
  /// given time step is longer, and where contact makes it much shorter than the soil does.
  void tell_time_step(const SteppingParameters& stepping, const StableStep& stable);
  /// Counts the mass of what was removed, too.
  void tell_removed(const HopelessParticles& removed, unsigned int step);
  /// What has left the grid so far in this run. Counts its mass; warns at the first time.
  void tell_lost(const LostParticles& lost, unsigned int step);
  /// Counts an attempt at a step, converged or not.
  void count(const NewtonReport& newton, const Clock& clock, unsigned int step);
  /// `share`: of a requested step, what the step just made was; the clock is after it.
  void progress(const NewtonReport& newton, const Clock& clock, double share, const StepSummary& state);
  /// Warns once where domains of this rank, `here`, or another one's are cut as ParticleSet::n_cut says. Collective.
  void warn_of_cut_domains(long long here, unsigned int step);
  /// Warns once where none of all ranks' material points are left.
  void warn_of_no_soil(long long points, unsigned int step);
  /// Warns once where bodies that were apart at the first call pass through each other.
  void warn_of_passage(const RigidSystems& bodies, unsigned int step);
  /// `cells` hold soil; `mass` is that of this rank's particles, kg, `particle_bytes` and `basis_bytes` are
  /// what they and their stencils take. Collective.
  void end_stage(const StepSummary& state, long long cells, double mass, double particle_bytes, double basis_bytes);
  /// Writes summary.json with how the run ends. Collective.
  void finish(const std::string& status);
  /// Writes into summary.json what went wrong. Ends all ranks if the others do not fail too. In a catch block.
  void fail(const Failure& failure);

private:
  std::string path() const;
  /// Warns once where springs give way by more than half a material point.
  void warn_of_soft_contact(const StepSummary& state);
  /// Counts the mass of points that are gone; a warning with advice at the first time.
  void tell_gone(const std::string& sentence, const std::string& advice, double mass, bool& has_warned);
  void take_times();
  void take_stock(const std::string& status);
  void write(const std::string& status);

  const Input& input;
  const RunOptions& options;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  Report terminal;
  Timings clock_of_phases;
  RunSummary summary;
  RunSummary earlier; ///< times of the run that this one goes on from
  bool told_time_step = false, warned_of_time_step = false, warned_of_springs = false; ///< in this stage
  double step_length = 1.; ///< of the stage: s, or a fraction of the load
  LostParticles told_lost;
  std::optional<PassageWatch> passage;
  bool has_warned_of_removed = false, has_warned_of_lost = false, has_warned_of_cut_domains = false,
       has_warned_of_no_soil = false, has_warned_of_soft_contact = false, has_warned_of_passage = false;
};
} // namespace kedge
