"""The runs of the plate-anchor study: one case is one run, and parts of the study share them."""
import dataclasses
import json
import math
import pathlib

import numpy as np

WIDTH = 0.1  # m, B of all plates
STATIC_STEP, DYNAMIC_STEP = 0.00025, 0.0001  # m
STEP_IN_CELLS = 0.05  # the body moves by this share of a cell at the plate between two bases
FRUSTA = {"SFC": (0.08, 0.02), "MFC": (0.025, 0.075), "LFC": (0.025, 0.15)}  # minor diameter and length, m
PRM = pathlib.Path(__file__).resolve().parents[2] / "prm"
BASE_AT = 0.4  # m: x of the plates' back faces
PULL = 0.05  # m: distance over which the tests pull
LAYER, BELOW = 0.32, 0.16  # m: thickness of the tests' sand, and its least thickness below a plate's axis
WHOLE = 0.04  # m: the thickness of a layer is a multiple
WEIGHT = 1590. * 9.81  # N/m3


@dataclasses.dataclass(frozen=True)
class Case:
    """One run; SI units, angles in degrees. The defaults are the study's own values."""
    shape: str = "TS"
    cell: float = 0.005  # at the plate's surface
    around: float = 0.01  # up to `reach` from it
    reach: float = 0.04
    base: float = 0.04  # beyond
    depth: float = 0.16  # of the plate's axis below the surface
    friction_angle: float = 35.5
    dilation_angle: float = 0.
    roughness: float = 1.  # friction of plate and sand over tan(friction angle)
    young: float = 12e6
    edge_radius: float = 0.0025
    K0: float = 0.426
    half_width: float = 0.2
    box_length: float = 1.1
    velocity: float = 0.02
    mass_scaling: float = 64.
    distance: float = PULL
    uniform: bool = False  # cells of the size `around` everywhere
    ahead: bool = False  # cells of the size `around` along the plate's whole path, not up to `reach`
    tolerance: float = 0.003  # of the residuals in implicit steps
    analysis: str = "explicit"  # "static": steps of STATIC_STEP; "dynamic": implicit, steps of DYNAMIC_STEP

    @property
    def name(self):
        """Name of the run's folder: everything that differs from the defaults."""
        parts = [self.shape]
        for field in dataclasses.fields(self)[1:]:
            value = getattr(self, field.name)
            if value != field.default:
                text = value if isinstance(value, str) else format(value, "g")
                parts.append(f"{field.name.replace('_', '-')}-{text}")
        return "-".join(parts)

    def with_cells(self, cell):
        """The same case with cells of one size at and around the plate, and with time steps as long as by default."""
        return dataclasses.replace(self, cell=cell, around=cell, mass_scaling=64. * min(1., (0.005 / cell)**2))

    def quick(self):
        """The same case with coarse cells, a short distance and the default tolerance. If the case scales inertia, then
        by the default factor, which gives the longest time steps."""
        return dataclasses.replace(self.with_cells(max(self.cell, 0.02)), tolerance=Case.tolerance,
                                   distance=0.02 if self.analysis == "explicit" else 0.01,
                                   mass_scaling=1. if self.mass_scaling == 1. else Case.mass_scaling)

    @property
    def layer(self):
        """Thickness of the sand in whole cells, m."""
        return max(LAYER, math.ceil((self.depth + BELOW) / WHOLE - 1e-9) * WHOLE)

    @property
    def height(self):
        """Height of the plate's axis above the base, m."""
        return self.layer - self.depth

    @property
    def area(self):
        """Area across the pull of the whole plate, or of the part of it that the box holds, m2."""
        return WIDTH * min(WIDTH, 2. * self.half_width) if self.shape == "TS" else math.pi * WIDTH**2 / 4.

    def geometry(self, path):
        """Arguments of `kedge geometry` that write the plate's surface."""
        where = ["--edge-radius", f"{self.edge_radius:g}", "--output", str(path)]
        if self.shape == "TS":
            return ["plate", "--translate", f"{BASE_AT + 0.005:g}", "0", f"{self.height:g}", *where]
        minor, length = FRUSTA[self.shape]
        return ["frustum", "--minor-diameter", f"{minor:g}", "--length", f"{length:g}",
                "--translate", f"{BASE_AT:g}", "0", f"{self.height:g}", *where]

    @property
    def scene(self):
        """Name of the scene in prm/."""
        return "plate-anchor-explicit.json" if self.analysis == "explicit" else "plate-anchor-ts.json"

    @property
    def stage(self):
        """The stage that pulls, derived from that of the scene."""
        stage = json.loads((PRM / self.scene).read_text(encoding="utf-8"))["analysis"][0]
        step = {"explicit": STEP_IN_CELLS * self.cell, "static": STATIC_STEP, "dynamic": DYNAMIC_STEP}[self.analysis]
        stage["rigid body boundary conditions"][0]["boundary conditions"][0] = {"prescribed": step}
        if self.analysis == "static":
            stage["load steps"] = round(self.distance / step)
        else:
            stage["final time"] = self.distance / self.velocity
        if self.analysis == "explicit":
            stage |= {"basis step": step / self.velocity, "mass scaling": self.mass_scaling}
        if self.analysis == "dynamic":
            del stage["load steps"], stage["load"]
            stage |= {"type": "dynamic", "dt": step / self.velocity, "beta": 0.25, "gamma": 0.5}
        stage["adaptivity"] = {"type": "none"} if self.uniform else {
            "type": "rigid body surface", "element size": self.cell,
            **({"boxes": self.boxes} if self.ahead else {"region": self.reach, "element size in region": self.around})}
        return stage

    @property
    def boxes(self):
        """Box around the plate's path in the tests, however far this run goes."""
        front = BASE_AT + (0.01 if self.shape == "TS" else FRUSTA[self.shape][1]) + PULL
        half = WIDTH / 2. + 0.04
        return [{"min": [BASE_AT - 0.04, 0., self.height - half], "max": [front + 0.06, half, self.height + half],
                 "element size": self.around}]

    def settings(self, surface):
        """Arguments of --set for this run. surface: the file that the command of `geometry` writes."""
        implicit = [] if self.analysis == "explicit" else [f"solver.tolerance={self.tolerance:g}"]
        return [*implicit, f"rigid bodies.0.stl files.0.stl={surface}",
                f"rigid bodies.0.points.0.position=[{BASE_AT + 0.005:g}, 0, {self.height:g}]",
                f"material points.element size={self.around if self.uniform else self.base:g}",
                f"material points.layers.0.thickness={self.layer:g}",
                f"material points.layers.0.material.friction angle={self.friction_angle:g}",
                f"material points.layers.0.material.dilation angle={self.dilation_angle:g}",
                f"material points.layers.0.material.E={self.young:g}",
                f"material points.initial stress.K0={self.K0:g}",
                f"domain.size={self.box_length:g}",
                f"material points.material size.max=[{self.box_length:g}, {self.half_width:g}]",
                f"contact.friction coefficient={self.roughness * math.tan(math.radians(self.friction_angle)):.6g}",
                f"analysis.0={json.dumps(self.stage)}",
                "output.vtk percent=100", "output.csv percent=0", "output.checkpoint every=10"]


def limit_strip(case):
    """Limit load of a rough vertical strip anchor that cannot rise, φ = ψ = 35°, Pa. It lies between the lower and the
    upper bound of finite-element limit analysis (Sloan 1988), 8 % from either. N = q / (γ H) with H down to the lower
    edge, the convention of Merifield & Sloan (2006, Can. Geotech. J. 43)."""
    depth = case.depth + WIDTH / 2.
    return np.interp(depth / WIDTH, [1., 2., 3., 5.], [4.18, 7.13, 9.04, 12.2]) * WEIGHT * depth


def rankine_strip(case):
    """Resistance of a vertical strip anchor near the surface (Teng 1962, Foundation Design), Pa: passive less active
    Rankine pressure on an infinitely wide wall from the surface to the plate's lower edge, over the plate's height."""
    passive, active = _earth_pressures(case)
    return 0.5 * WEIGHT * (case.depth + WIDTH / 2.)**2 * (passive - active) / WIDTH


def teng_square(case):
    """The same wedge, as wide as the plate, with friction on its two sides (Teng 1962), Pa."""
    passive, active = _earth_pressures(case)
    deep = case.depth + WIDTH / 2.
    friction = math.tan(math.radians(case.friction_angle))
    sides = case.K0 * WEIGHT / 3. * (math.sqrt(passive) + math.sqrt(active)) * deep**3 * friction
    return rankine_strip(case) + sides / WIDTH**2


def broms_square(case):
    """Resistance of narrow bodies by Broms (1964, J. Soil Mech. Found. Div. 90(3)), Pa: three times Rankine's passive
    pressure at the depth of the axis."""
    return 3. * _earth_pressures(case)[0] * WEIGHT * case.depth


def _earth_pressures(case):
    """Rankine's passive and active coefficients."""
    passive = math.tan(math.radians(45. + case.friction_angle / 2.))**2
    return passive, 1. / passive
