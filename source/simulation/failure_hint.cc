#include <cmath>
#include <fmt/format.h>
#include <kedge/simulation/failure_hint.h>
#include <kedge/simulation/run_log.h>

namespace kedge
{
namespace
{
constexpr double most = 0.5;          // of the points around, to say that they are so
constexpr double full = 0.75;         // share of its neighbourhood that soil takes inside a block
constexpr double near_in_cells = 1.5; // a body's own row of cells

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

bool is_at_body(const ResidualPlace& place) { return place.gap <= near_in_cells * place.cell_size; }

std::string text_of(const std::vector<double>& position)
{
  std::string text;
  for (const double x : position)
    text += fmt::format("{}{:.4g}", text.empty() ? "(" : ", ", x);
  return text + ")";
}

std::string hint_by_place(const ResidualPlace& place, const Stage& stage, const Input& input)
{
  const bool is_static = stage.stepping.type == StageType::static_;
  if (place.bodies_dominate)
    return "A free body finds no balance: shorter steps, softer contact springs (\"normal penalty factor\") or a stage "
           "that is \"dynamic\" may help; a body that nothing holds has none in a \"static\" one, and one that must "
           "swing far to its balance needs more \"max newton iterations\".";
  if (is_at_body(place))
    return "It sits at a body: shorter steps, finer cells there, softer contact springs (\"normal penalty factor\") or "
           "rounder edges may help.";
  if (place.unstressed > most || place.filled < full)
    return "It sits where soil comes apart or ends: a little cohesion, a larger \"ghost factor\" or a larger \"poor "
           "factor\" may help.";
  if (place.yielding > most && is_static)
    return std::string("It sits in soil that yields, away from bodies and edges: shorter steps") +
           (input.material_points.f_bar ? "" : ", \"F-bar\"") +
           " or a larger \"ghost factor\" may help; where the load is more than the soil can bear there is no balance, "
           "and the stage must be \"dynamic\".";
  return "It sits in soil that does not yield: the tolerance may be finer than round-off allows, or boundary "
         "conditions "
         "may leave the soil free to move.";
}
} // namespace

std::string describe_place(const ResidualPlace& place)
{
  if (place.position.empty())
    return "";
  std::string where = place.gap <= 0.            ? "inside a body's surface"
                      : is_at_body(place)        ? "at a body"
                      : std::isfinite(place.gap) ? fmt::format("{:.3g} m from a body", place.gap)
                                                 : "away from all bodies";
  where += place.unstressed > most ? ", in soil that carries next to no stress"
           : place.filled < full   ? ", at the edge of the soil"
           : place.yielding > most ? ", in soil that yields"
                                   : ", in soil that does not yield";
  return fmt::format(
      "The largest residual, {:.2g} of the forces at its node, is at {} m, where cells have {:.3g} m: {}.", place.share,
      text_of(place.position), place.cell_size, where);
}

std::string hint_for(const NewtonReport& newton, const ResidualPlace& place, const Stage& stage, const Input& input)
{
  const std::string& failure = newton.failure;
  if (stage.stepping.type == StageType::explicit_)
    return stage.stepping.dt > 0. ? "A shorter \"dt\", or \"auto\", or a shorter \"basis step\" may help."
           : input.contact.normal_penalty_factor > explicit_normal_penalty_factor
               ? "A shorter \"basis step\", a smaller \"cfl\" or softer contact springs (\"normal penalty factor\" "
                 "0.25) may help."
               : "A shorter \"basis step\" or a smaller \"cfl\" may help.";
  if (contains(failure, "penetrate"))
    return "Stiffer springs (\"normal penalty factor\"), a larger \"penetration tolerance\", or \"method\": "
           "\"penalty\" may help.";
  if (contains(failure, "linear system"))
    return fmt::format(
        "The system is close to singular: {} \"ghost factor\"{} may help, and conditions that hold every "
        "body and the soil; a body that is free to turn needs \"rotational inertia\".",
        input.solver.ghost_factor.value_or(1.) > 0. ? "a larger" : "a",
        input.solver.linear_solver == LinearSolverChoice::direct
            ? " or a little cohesion"
            : ", a little cohesion, or \"linear solver\": \"direct\"");
  if (contains(failure, "moved by"))
    return "A free body leaps to another place where forces balance, as one that is caught or comes loose: shorter "
           "steps, rounder edges, finer cells or a stage that is \"dynamic\" may help.";
  if (contains(failure, "not finite"))
    return newton.iterations == 0
               ? "Soil turns inside out before the first iteration: prescribed motion or what already presses is too "
                 "large for the cells; shorter steps or coarser cells may help."
               : "Soil turns inside out: shorter steps, \"line search\": \"on\" or a little cohesion may help.";
  if (place.position.empty())
    return "Shorter steps may help.";
  return hint_by_place(place, stage, input);
}

std::string describe_failure(const Input& input, const unsigned int stage_number, const Clock& clock,
                             const NewtonReport& newton, const ResidualPlace& place)
{
  const std::string which = fmt::format("stage {}, step {} of {}", stage_number + 1,
                                        std::floor(clock.steps_done()) + 1., clock.requested_steps());
  if (newton.residuals.empty() && newton.iterations == 0)
    return fmt::format("{}: {}", which, newton.failure);
  std::string text = fmt::format("{}: {} even with a step cut to {:.3g} of the requested one.\n", which, newton.failure,
                                 clock.step_fraction());
  if (!newton.residuals.empty())
    text +=
        fmt::format("Residual over the {}: {}\n", input.solver.measures_by_weight() ? "soil's weight" : "acting forces",
                    format_residuals(newton));
  const std::string where = describe_place(place);
  return text + where + (where.empty() ? "" : "\n") + hint_for(newton, place, input.stages[stage_number], input);
}
} // namespace kedge
