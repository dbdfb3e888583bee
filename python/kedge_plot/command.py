"""The command kedge-plot."""
import argparse
import pathlib
import sys

import numpy as np

from kedge_runs import RunError
from kedge_runs.run import Run

from . import OptionError, PlotError
from .choice import choose
from .resistance import fit_hyperbola, resistance_curve
from .section import cut


def parser():
    """The options."""
    options = argparse.ArgumentParser(
        prog="kedge-plot",
        description="Draws the results of a Kedge run as PNG files: the resistance of a body over its displacement "
                    "and a section through the soil. Without --resistance or --section it draws what the folder holds.",
        epilog="Example: kedge-plot cube-output --section --field stress_zz --mesh. Exit codes: 0 done, 1 something to "
               "draw is missing, 2 wrong options.")
    options.add_argument("folder", metavar="DIR", help="output folder of the run")
    options.add_argument("--output", metavar="DIR", help="folder for the PNG files (default: DIR/plots)")
    options.add_argument("--resistance", action="store_true", help="draw only the resistance")
    options.add_argument("--section", action="store_true", help="draw only the section")

    curve = options.add_argument_group("resistance")
    curve.add_argument("--body", type=int, help="number of the rigid point, from 1 (default: the one that is "
                                                "prescribed to move, else 1)")
    curve.add_argument("--axis", choices="xyz", help="axis of force and displacement (default: that of the prescribed "
                                                     "motion, else the one along which the body moves most)")
    curve.add_argument("--stage", type=int, action="append",
                       help="draw only this stage, from 1; repeat it for several (default: the last one with a "
                            "prescribed motion, else those since the bodies were placed)")
    curve.add_argument("--area", type=float, help="projected area [m2], in plane strain the width [m]: draw the "
                                                  "pressure instead of the force")
    curve.add_argument("--factor", type=float, default=1.,
                       help="factor on the force, such as 2 for a half model (default: 1)")
    curve.add_argument("--zero", action="store_true", help="subtract the first value of the force")
    curve.add_argument("--fit", action="store_true", help="fit the hyperbola q = d / (a + b d) and print its asymptote")

    section = options.add_argument_group("section")
    section.add_argument("--plane", choices="xyz", default="y", help="axis normal to the section (default: y)")
    section.add_argument("--at", type=float, default=0.,
                         help="position of the section along that axis [m] (default: 0)")
    section.add_argument("--field", default="displacement magnitude",
                         help="what to draw, such as stress_xx, mean stress, volume (default: displacement magnitude); "
                              "\"shear strain\" is the equivalent shear strain sqrt(2/3 e:e), where e is the deviator "
                              "of the total logarithmic strain; the run must have written the deformation gradient")
    section.add_argument("--since", type=int, metavar="STAGE",
                         help="draw displacement or shear strain since the start of this stage, from 1 (default: since "
                              "the start of the run)")
    section.add_argument("--blocks", action="store_true",
                         help="give every material point one colour, instead of smooth colours between them")
    section.add_argument("--step", type=int, help="number in the names of the files (default: the last)")
    section.add_argument("--limits", type=float, nargs=2, metavar=("MIN", "MAX"),
                         help="range of the colours, in drawn units")
    section.add_argument("--window", type=float, nargs=4, metavar=("LEFT", "RIGHT", "BOTTOM", "TOP"),
                         help="part of the plane to draw [m]")
    section.add_argument("--mesh", action="store_true", help="draw the cells of the mesh, too")
    section.add_argument("--area-above", type=float, metavar="VALUE",
                         help="print the area where the field exceeds VALUE (SI), before and beyond the body's middle")
    return options


def main(arguments=None):
    """Runs the command; returns its exit code."""
    options = parser().parse_args(arguments)
    try:
        run = Run(options.folder)
        target = pathlib.Path(options.output or run.folder / "plots")
        try:
            target.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PlotError(f"{target}: cannot be created ({error.strerror})") from error
        caption = _caption(run)
        both = not options.resistance and not options.section
        drawn = [_attempt(plot, both, run, target, options, caption)
                 for plot, asked in ((_plot_resistance, options.resistance), (_plot_section, options.section))
                 if asked or both]
    except RunError as error:
        print(f"kedge-plot: {error}", file=sys.stderr)
        return 2 if isinstance(error, OptionError) else 1
    return 0 if True in drawn and False not in drawn else 1


def _attempt(plot, may_fail, run, target, options, caption):
    """Draws one figure and returns True. If it may fail, prints why and returns None where the run has not written what
    it needs, else False."""
    try:
        print(plot(run, target, options, caption))
        return True
    except RunError as error:
        if not may_fail or isinstance(error, OptionError):
            raise
        print(f"kedge-plot: {error}", file=sys.stderr)
        return False if isinstance(error, PlotError) else None


def _caption(run):
    """Version and input of the run, for the figure's corner."""
    summary = run.summary
    parts = [f"Kedge {summary['version']}"] if summary.get("version") else []
    parts += [pathlib.Path(summary["input"]).name] if summary.get("input") else []
    return ", ".join(parts)


def _plot_resistance(run, target, options, caption):
    from .figures import draw_resistance  # loaded only here: matplotlib takes a second

    if options.area is not None and not options.area > 0.:
        raise OptionError(f"--area {options.area:g}: the area must be positive")
    columns = run.bodies()
    reached = {int(stage) for stage in columns.get("stage", [])}
    choice = choose(run.scene, reached, options.body, options.axis, options.stage)
    start = run.start_of(choice.body, choice.stages[0] if choice.stages else 1)
    curve = resistance_curve(columns, choice, options.factor, options.zero, start)
    fit = fit_hyperbola(curve.displacement, curve.force) if options.fit else None
    path = target / f"resistance_body{curve.body}_{curve.axis}.png"
    title = f"Body {curve.body}"
    if choice.stages and len(reached) > 1:
        title += f", stage{'s' * (len(choice.stages) > 1)} {', '.join(map(str, choice.stages))}"
    per_metre = "/m" if run.scene.get("dimension") == 2 else ""
    draw_resistance(curve, path, options.area, fit, title, caption, per_metre)
    text = str(path)
    if fit:
        scale, unit = (1e-3 / options.area, "kPa") if options.area else (1., "N" + per_metre)
        slope = f"{unit}/m".replace("/m/m", "/m2")
        text += (f"\n  q = d / (1/k + d/q_lim): q_lim = {scale * fit.limit:.6g} +- {scale * fit.limit_error:.2g} {unit}"
                 f", k = {scale * fit.stiffness:.6g} +- {scale * fit.stiffness_error:.2g} {slope}"
                 f"\n  98 % of q_lim at {1e3 * fit.displacement_at(0.98):.4g} mm; "
                 f"computed up to {1e3 * curve.displacement.max():.4g} mm")
    return text


def _require_ranges(option, numbers):
    for low, high in zip(numbers[::2], numbers[1::2]):
        if not low < high:
            raise OptionError(f"{option}: {low:g} is not less than {high:g}")


def _plot_section(run, target, options, caption):
    from .figures import draw_section

    _require_ranges("--limits", options.limits or [])
    _require_ranges("--window", options.window or [])

    grids, step = run.soil(options.step)
    since, note = _subtract_start(run, grids, step, options)
    mesh = run.mesh(step) if options.mesh else None
    section = cut(grids, run.surface(step), options.plane, options.at, options.field, mesh)
    parts = ["section", options.plane, options.field.replace(" ", "_")]
    parts += [f"since_stage_{options.since}"] if options.since else []
    path = target / ("_".join(parts) + f"_{step:05d}.png")
    title = (f"Since {since}\n" if since else "") + moment(run, step)
    if not section.is_flat:
        title += f", {options.plane} = {options.at:g} m"
    draw_section(section, path, options.field, title, options.limits, options.window, caption, options.blocks)
    text = str(path) + note
    if options.area_above is not None:
        text += "\n  " + _area_above(section, options.area_above)
    return text


def moment(run, step):
    """Step, stage and time as a text, as far as the run says."""
    stage, time = run.stage_of(step), run.time_of(step)
    text = f"Step {step}" + (f", stage {stage}" if stage else "")
    if time is None:
        return text
    return text + (f", load {time:.4g}" if run.stages[stage - 1].get("type") == "static" else f", {time:.4g} s")


def _subtract_start(run, grids, step, options):
    """Makes the fields those since the start of the stage of --since. Returns from when on they count, and a note if
    that is not the start of the stage."""
    from .since import FIELDS, output_before, subtract

    if options.since is None:
        return "", ""
    if not options.field.startswith(FIELDS):
        raise PlotError(f"--since: a section since a stage shows {' or '.join(FIELDS)}, not \"{options.field}\"")
    if options.since == 1:
        return "stage 1 began", ""
    reference, start = output_before(run, options.since, step)
    subtract(grids, run.soil(reference)[0])
    if reference == start:
        return f"stage {options.since} began", ""
    return f"step {reference}", (f"\n  counts from step {reference}: the state at step {start}, at which stage "
                                 f"{options.since} starts, was not written")


def _area_above(section, threshold):
    above = section.values > threshold
    areas, centres = section.areas(), (section.lower[:, 0] + section.upper[:, 0]) / 2.
    text = f"area with values above {threshold:g}: {areas[above].sum():.6g} m2"
    if len(section.outline):
        ends = section.outline[:, :, 0]
        middle = (ends.min() + ends.max()) / 2.
        before = np.sum(areas[above & (centres < middle)])
        beyond = np.sum(areas[above & (centres >= middle)])
        axis = section.axes[0]
        text += f": {before:.6g} at {axis} < {middle:.4g} m and {beyond:.6g} at {axis} > {middle:.4g} m"
    return text
