"""Draws curves and sections to PNG files."""
import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the back end)
import numpy as np  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection, TriMesh  # noqa: E402
from matplotlib.tri import Triangulation  # noqa: E402
from mpl_toolkits.axes_grid1 import make_axes_locatable  # noqa: E402

from . import PlotError  # noqa: E402
from .filling import triangles_between  # noqa: E402
from .section import Backdrop  # noqa: E402
from .smoothing import edge_places, edge_values, rectangle_corners  # noqa: E402

_STYLE = {"font.size": 9, "axes.labelsize": 9, "axes.linewidth": 0.8, "figure.dpi": 200, "savefig.dpi": 200,
          "legend.frameon": False, "xtick.direction": "in", "ytick.direction": "in", "mathtext.default": "regular"}

# By the start of a field's name: unit and the factor that turns SI into it.
_UNITS = {"stress": ("kPa", 1e-3), "mean stress": ("kPa", 1e-3), "deviatoric stress": ("kPa", 1e-3),
          "displacement": ("mm", 1e3), "position": ("m", 1.), "initial position": ("m", 1.), "velocity": ("m/s", 1.),
          "acceleration": ("m/s²", 1.), "lp": ("m", 1.), "volume": ("m³", 1.), "initial volume": ("m³", 1.),
          "young modulus": ("MPa", 1e-6), "contact gap": ("mm", 1e3), "intact strength": ("kPa", 1e-3)}
_LOW = 2.4  # inches
_COLOURS = matplotlib.colormaps["viridis"].with_extremes(bad="0.8")  # grey: soil without a value


def unit_of(field, is_flat=False):
    """Unit in which a figure draws a field, and its factor from SI; an empty unit for numbers without dimension.
    is_flat: of a run in plane strain, whose volumes are per metre."""
    for name in sorted(_UNITS, key=len, reverse=True):
        if field.startswith(name):
            unit, factor = _UNITS[name]
            return unit.replace("m³", "m²") if is_flat else unit, factor
    return "", 1.


def draw_resistance(curve, path, area=None, fit=None, title="", caption="", per_metre=""):
    """Draws force (kN) or, with an area (m2), pressure (kPa) over displacement (mm), and the hyperbola if any.
    per_metre: "/m" in plane strain, where forces are per metre and the area is a width."""
    scale, name, unit = (1e-3 / area, "Resistance", "kPa") if area else (1e-3, "Reaction force", "kN" + per_metre)
    with plt.rc_context(_STYLE):
        figure, axes = plt.subplots(figsize=(4.5, 3.2), layout="constrained")
        axes.plot(1e3 * curve.displacement, scale * curve.force, "o" if fit else "-", ms=2.5, lw=1.2, color="C0",
                  label="computed", mfc="none" if fit else None)
        if fit:
            end = 1e3 * curve.displacement.max()
            d = np.linspace(0., end, 400)
            axes.plot(d, scale * fit(d / 1e3), color="C3", lw=1.2, label="hyperbola")
            axes.axhline(scale * fit.limit, color="0.4", lw=0.8, ls="--",
                         label=f"asymptote {scale * fit.limit:.4g} ± {scale * fit.limit_error:.2g} {unit}")
        axes.set_xlabel(f"Displacement along {curve.axis} [mm]")
        axes.set_ylabel(f"{name} [{unit}]")
        axes.set_xlim(left=min(0., 1e3 * curve.displacement.min()))
        if 0. <= curve.force.min() < curve.force.max():
            axes.set_ylim(bottom=0.)
        axes.grid(True, lw=0.3, alpha=0.6)
        if fit:
            axes.legend(loc="lower right")
        axes.set_title(title, loc="left", fontsize=9)
        _finish(figure, axes, caption, path)


def draw_section(section, path, field, title="", limits=None, window=None, caption="", blocks=False):
    """Draws the soil with the bodies' outline. limits: range of the colours, in the drawn unit; window: part of the
    plane (left, right, bottom, top), m; blocks: one colour per material point."""
    unit, factor = unit_of(field, section.is_flat)
    if np.isnan(section.values).all():
        raise PlotError(f"no material point in the section has a value of \"{field}\"")
    has_gaps = np.isnan(np.concatenate([section.values, section.backdrop.values])).any()
    blocks = blocks or has_gaps  # no colours run smoothly where some have none
    left, right, bottom, top = window or _extent(section)
    with plt.rc_context(_STYLE):
        width = 6.3
        height = np.clip(width * (top - bottom) / (right - left), 1.2, 8.) + 0.8
        figure, axes = plt.subplots(figsize=(width, height), layout="constrained")
        soil = add_soil(axes, section, factor, limits, blocks)
        if len(section.cells):
            frames = rectangle_corners(section.cells[:, 0], section.cells[:, 1])
            axes.add_collection(PolyCollection(frames, facecolors="none", edgecolors="0.6", linewidths=0.4))
        if len(section.outline):
            axes.add_collection(LineCollection(section.outline, colors="k", linewidths=1., capstyle="round"))
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel=f"{section.axes[0]} [m]",
                 ylabel=f"{section.axes[1]} [m]")
        axes.set_title(title, loc="left", fontsize=9)
        # beside a low section there is no room for the label
        side, pad, lies = ("bottom", 0.45, "horizontal") if height - 0.8 < _LOW else ("right", 0.1, "vertical")
        bar = make_axes_locatable(axes).append_axes(side, size=0.12, pad=pad)
        label = _label(field) + (f" [{unit}]" if unit else "") + ("; grey: no value" if has_gaps else "")
        figure.colorbar(soil, cax=bar, orientation=lies, label=label,
                        extend=_beyond(factor * section.values, *soil.get_clim()))
        _finish(figure, axes, caption, path)


def add_soil(axes, section, factor, limits=None, blocks=False):
    """Draws the section's boxes over triangles that fill the cracks between them, and these over the backdrop. Colours
    run smoothly from one material point to the next, up to the outer edges of the boxes; with `blocks`, every box has
    one colour. Returns the collection that a colour bar needs."""
    behind = Backdrop(*(np.concatenate([getattr(section.backdrop, name), getattr(section, name)])
                        for name in ("lower", "upper", "values")))
    draw = _add_blocks if blocks else _add_smooth
    drawn = [collection for collection in (_add_filling(axes, behind, factor, section.outline),
                                           draw(axes, section.backdrop, factor, section.outline),
                                           _add_filling(axes, section, factor, section.outline),
                                           draw(axes, section, factor, section.outline)) if collection]
    if limits is None:
        limits = factor * np.nanmin(section.values), factor * np.nanmax(section.values)
    for collection in drawn:
        collection.set_clim(*limits)
    return drawn[-1]


def _add_filling(axes, boxes, factor, outline):
    triangles = triangles_between(boxes.lower, boxes.upper, outline)
    if triangles is None or triangles.mask.all():
        return None
    return _add_shaded(axes, triangles, factor * boxes.values)


def _add_blocks(axes, boxes, factor, _):
    # Lines or smoothing would let the background show between boxes that touch.
    blocks = PolyCollection(rectangle_corners(boxes.lower, boxes.upper), array=factor * boxes.values, cmap=_COLOURS,
                            linewidths=0., antialiased=False, rasterized=True)
    return axes.add_collection(blocks)


def _add_smooth(axes, boxes, factor, outline):
    """Eight triangles per box, from its centre to its edges."""
    n = len(boxes.values)
    if n == 0:
        return None
    places = np.concatenate([edge_places(boxes.lower, boxes.upper).reshape(-1, 2), (boxes.lower + boxes.upper) / 2.])
    values = np.concatenate([edge_values(boxes.lower, boxes.upper, boxes.values, outline).ravel(), boxes.values])
    first, centre = 8 * np.arange(n), 8 * n + np.arange(n)
    triangles = np.concatenate([np.column_stack([first + i, first + (i + 1) % 8, centre]) for i in range(8)])
    return _add_shaded(axes, Triangulation(*places.T, triangles), factor * values)


def _add_shaded(axes, triangulation, values):
    """Like tripcolor, without its search for the limits of the axes, which takes longer than the drawing."""
    mesh = TriMesh(triangulation, array=values, cmap=_COLOURS, rasterized=True)
    return axes.add_collection(mesh, autolim=False)


def _beyond(values, lowest, highest):
    """At which ends of a colour bar some values lie beyond it, in matplotlib's words."""
    below, above = np.nanmin(values) < lowest, np.nanmax(values) > highest
    return "both" if below and above else "min" if below else "max" if above else "neither"


def _extent(section):
    """Bounds of all rectangles and outlines with a small margin."""
    points = np.concatenate([section.lower, section.upper, section.outline.reshape(-1, 2)])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.02 * (high - low).max()
    return low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin


def _label(field):
    text = field[:1].upper() + field[1:]
    base, _, component = text.rpartition("_")
    return f"{base}$_{{{component}}}$" if base else text


def _finish(figure, axes, caption, path):
    if caption:
        axes.annotate(caption, (1., 1.), (0., 3.), xycoords="axes fraction", textcoords="offset points", ha="right",
                      va="bottom", fontsize=6, color="0.45")
    try:
        figure.savefig(path, bbox_inches="tight", pad_inches=0.04)
    except OSError as error:
        raise PlotError(f"{path}: cannot be written ({error.strerror})") from error
    finally:
        plt.close(figure)
