#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/parameters/section.h>
#include <kedge/time/parameters.h>

namespace kedge
{
using namespace schema;

namespace
{
const std::vector<std::string> in_time = {"dynamic", "explicit"};
const std::vector<std::pair<std::string, StageType>> names = {
    {"static", StageType::static_}, {"dynamic", StageType::dynamic}, {"explicit", StageType::explicit_}};

/// More than any run makes; their number times the smallest parts of a step still fits into the clock.
constexpr double most_steps = 1e9;

void check_step(const SteppingParameters& stepping, const Place& place)
{
  if (stepping.type == StageType::dynamic && stepping.dt == 0.)
    place.key("dt").fail("expected a number above 0 (s), found \"auto\"",
                         "give the time step; only explicit stages can determine it");
  if (const double steps = requested_steps(stepping); steps > most_steps)
    place
        .key(stepping.type == StageType::static_   ? "load steps"
             : stepping.type == StageType::dynamic ? "dt"
                                                   : "basis step")
        .fail(fmt::format("the stage has {:.4g} steps", steps), fmt::format("use at most {:.0e} of them", most_steps));
  if (stepping.type == StageType::explicit_ && stepping.dt > 0. && step_length(stepping) / stepping.dt > most_steps)
    place.key("dt").fail(fmt::format("a basis step has {:.4g} time steps", step_length(stepping) / stepping.dt),
                         fmt::format("use at most {:.0e} of them, or \"auto\"", most_steps));
  if (stepping.type != StageType::static_ && stepping.dt > stepping.final_time * (1. + 1e-12))
    place.key("dt").fail("the time step " + shown(stepping.dt) + " s is longer than the stage",
                         "keep \"dt\" at or below \"final time\", " + shown(stepping.final_time) + " s");
  if (stepping.type == StageType::explicit_ && stepping.basis_step > stepping.final_time * (1. + 1e-12))
    place.key("basis step")
        .fail("the basis step " + shown(stepping.basis_step) + " s is longer than the stage",
              "keep it at or below \"final time\", " + shown(stepping.final_time) + " s");
}
} // namespace

std::string name_of(const StageType type)
{
  return std::find_if(names.begin(), names.end(), [&](const auto& entry) { return entry.second == type; })->first;
}

double requested_steps(const SteppingParameters& stepping)
{
  return stepping.type == StageType::static_ ? stepping.load_steps : stepping.final_time / step_length(stepping);
}

unsigned int count_steps(const SteppingParameters& stepping)
{
  return static_cast<unsigned int>(std::ceil(requested_steps(stepping) - 1e-6));
}

double step_length(const SteppingParameters& stepping)
{
  switch (stepping.type)
  {
    case StageType::static_:
      return 1. / stepping.load_steps;
    case StageType::dynamic:
      return stepping.dt;
    case StageType::explicit_:
      break;
  }
  return stepping.basis_step > 0. ? stepping.basis_step : 0.01 * stepping.final_time;
}

Section<SteppingParameters> stepping_section()
{
  using P = SteppingParameters;
  Section<P> section("Steps of a stage");
  section.required("type", &P::type, choice<StageType>(names),
                   "Equilibrium without inertia, implicit dynamics (Newmark), or explicit dynamics");
  section.required("load steps", &P::load_steps, count(Bounds().at_least(1)), "Number of equal steps of the stage")
      .only_for("type", {"static"});
  section
      .required("load", &P::load,
                choice<GravityLoad>({{"gravity ramp", GravityLoad::ramp}, {"full", GravityLoad::full}}),
                "Gravity grows from 0 to its full value over the stage, or acts in full from its first step")
      .only_for("type", {"static"});
  section
      .required("dt", &P::dt, number_or("auto", 0., number("s", positive())),
                "Time step; \"auto\", in explicit stages: from the stability limit, which no step there exceeds")
      .only_for("type", in_time);
  section
      .optional(
          "basis step", &P::basis_step, number_or("auto", 0., number("s", positive())),
          "Time, many time steps long, for which the overlap of material points and cells is kept; it is the step of "
          "a body's \"prescribed\" motion and of the outputs; \"auto\": a hundredth of the stage")
      .only_for("type", {"explicit"});
  section.required("final time", &P::final_time, number("s", positive()), "Duration of the stage")
      .only_for("type", in_time);
  section
      .required(
          "beta", &P::beta, number("-", positive()),
          "Newmark's beta; with (gamma + 1/2)^2 / 4 stiff joints and contacts come to rest, with less their forces "
          "swing from step to step, and with less than gamma / 2 they grow")
      .only_for("type", {"dynamic"});
  section
      .required(
          "gamma", &P::gamma, number("-", Bounds().at_least(0.5)),
          "Newmark's gamma; values above 0.5 damp, values below would add energy. Where bodies hit the soil or "
          "roll on it, contacts that open and close add energy with 0.5, until the soil flies apart, and with 0.6 "
          "in long steps: a disc that hits a bed with 52 J had up to 126 J; 0.75 and above have added none")
      .only_for("type", {"dynamic"});
  section
      .optional("mass", &P::lumped_mass, choice<bool>({{"consistent", false}, {"lumped", true}}),
                "Mass matrix of the soil: it couples the nodes that a material point sees, or has its row sums on the "
                "diagonal")
      .only_for("type", {"dynamic"});
  section
      .optional("cfl", &P::cfl, number("-", positive().at_most(1.)), "Share of the stability limit taken as the step")
      .only_for("dt", {"auto"});
  section
      .optional("damping", &P::damping, number("-", not_negative().below(1.)),
                "Local damping: share of the out-of-balance force that opposes the velocity")
      .only_for("type", {"explicit"});
  section
      .optional("mass scaling", &P::mass_scaling, number("-", Bounds().at_least(1.)),
                "Factor on the inertial mass of the soil, which lengthens the stable step by its square root")
      .only_for("type", {"explicit"});
  section.check(check_step);
  return section;
}
} // namespace kedge
