// The run of a scene: its state, and the steps of its time loop.
#pragma once

#include <functional>
#include <kedge/output/snapshots.h>
#include <kedge/particles/expressions.h>
#include <kedge/simulation/checkpoints.h>
#include <kedge/simulation/run_log.h>
#include <kedge/simulation/simulation.h>
#include <kedge/steps/trial_step.h>
#include <memory>
#include <optional>

namespace kedge
{
template <int dim> class Simulation
{
public:
  /// start: what the run goes on from; without a path it begins anew.
  Simulation(const Input& input, const RunOptions& options, FoundRestartFile start);
  ExitCode run();

private:
  void copy_input();
  void generate();
  void resume();
  ExitCode run_stages();
  void enter_stage(unsigned int number);
  void begin_stage(unsigned int number);
  void forget_motion();
  void bury_bodies();
  bool run_stage();
  bool save_if_due(const Clock& clock);
  bool dumps_now() const;
  bool has_dumped(const NewtonReport& report) const;
  void limit_steps(Clock& clock);
  NewtonReport attempt_step(const Clock& clock);
  bool bring_into_balance(const Clock& clock);
  void prepare_step();
  void move_window();
  void clean();
  void adapt();
  std::unique_ptr<TrialStep<dim>> make_step();
  StepLoad load_at(const Clock& clock) const;
  void commit_step();
  StepSummary summarise_step() const;
  void write_output(const Clock& clock, double steps_before, bool even_if_not_due);
  void finish_output();
  void pass_on(const std::vector<std::string>& warnings);
  void write_restart_file(const Clock& clock, const std::string& path);
  void save_failed_state(const Clock& clock);
  void write_or_warn(const std::string& place, const std::function<void()>& write);
  void save_what_is_there(const Clock& clock);
  [[noreturn]] void give_up(const Clock& clock, const NewtonReport& newton);
  void end_stage();

  const Input& input;
  const RunOptions& options;
  const FoundRestartFile start;
  const Stage* stage = nullptr;
  unsigned int stage_number = 0; ///< from 0
  double finished_time = 0.;     ///< of the stages before: s, a static one counts 1
  RunLog log;

  Soil<dim> soil;
  RigidSystems bodies;
  OutputWriter<dim> writer;
  CheckpointSchedule checkpoints;
  MissedFiles missed_restart_files{"restart files"};
  std::optional<ClockState> resumed; ///< clock of the interrupted stage, on restart

  SystemToSave saved_system;            ///< where the run dumps one
  std::unique_ptr<TrialStep<dim>> step; ///< the current one; survives a cut
  std::optional<BodyForce<dim>> body_force;
  std::vector<Vector6> reactions; ///< of the last converged step, as the next
  std::vector<typename Contact<dim>::Touch> touches;
  NewtonHistory newton; ///< of the steps so far
  bool has_warned_of_window = false;
  unsigned int balanced_step = 0; ///< before which the soil was brought into balance last
  bool replaces_soil = false;     ///< before the first step of a stage whose bodies are wished in place
  long long dofs = 0;
  double basis_bytes = 0.;
  unsigned int step_number = 1; ///< global counter; the first converged step is number 2, as the file names have it
};

/// Throws InputError where the copy of the effective input would replace the input file with another content.
void refuse_to_replace_input(const Input& input, const RunOptions& options);
} // namespace kedge
