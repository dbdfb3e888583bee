// What the input says about the steps of one stage.
#pragma once

#include <string>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
enum class StageType
{
  static_,
  dynamic,
  explicit_
};

enum class GravityLoad
{
  ramp,
  full
};

struct SteppingParameters
{
  StageType type = StageType::static_;
  unsigned int load_steps = 1;                       ///< static
  GravityLoad load = GravityLoad::full;              ///< static
  double dt = 0.;                                    ///< dynamic and explicit: s; 0 in explicit stages: "auto"
  double basis_step = 0.;                            ///< explicit: s; 0: a hundredth of the stage
  double final_time = 0.;                            ///< dynamic and explicit: s
  double beta = 0.25, gamma = 0.5;                   ///< Newmark
  bool lumped_mass = false;                          ///< dynamic
  double cfl = 0.8, damping = 0., mass_scaling = 1.; ///< explicit
};

/// The word for it in the input.
std::string name_of(StageType type);

/// Number of requested steps of a stage; the last one is shorter where "final time" is not a multiple of "dt".
double requested_steps(const SteppingParameters& stepping);
/// The same as a whole number: a shorter last step counts as one.
unsigned int count_steps(const SteppingParameters& stepping);
/// Length of a requested step: s, or a fraction of the load in static stages.
double step_length(const SteppingParameters& stepping);

/// Keys of a stage that say how it steps.
schema::Section<SteppingParameters> stepping_section();
} // namespace kedge
