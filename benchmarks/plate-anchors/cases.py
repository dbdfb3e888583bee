"""The runs of the plate-anchor study: one case is one run, and parts of the study share them."""
import dataclasses
import math

import numpy as np

BOX_LENGTH = 1.1  # m, of the half model
STEP_IN_CELLS = 0.05  # of a cell: what a body moves between two bases
FRUSTA = {"SFC": (0.08, 0.02), "MFC": (0.025, 0.075), "LFC": (0.025, 0.15)}  # minor diameter and length, m
BASE_AT = 0.4  # m, where the plates' back faces stand
SAND = 0.32  # m, thickness of the layer


@dataclasses.dataclass(frozen=True)
class Case:
    """One run; SI units, angles in degrees. The defaults are the study's own values."""
    shape: str = "TS"
    cell: float = 0.01  # at the plate and up to four of the default cells around it
    depth: float = 0.16  # of the plate's axis below the surface
    friction_angle: float = 35.5
    young: float = 12e6
    half_width: float = 0.2
    velocity: float = 0.02
    mass_scaling: float = 16.
    distance: float = 0.05
    uniform: bool = False  # cells of that size everywhere

    @property
    def name(self):
        """Of its folder: what differs from the defaults."""
        parts = [self.shape]
        for field in dataclasses.fields(self)[1:]:
            value = getattr(self, field.name)
            if value != field.default:
                parts.append(f"{field.name.replace('_', '-')}-{value:g}")
        return "-".join(parts)

    def quick(self):
        """The same with coarse cells and a short way."""
        return dataclasses.replace(self, cell=max(self.cell, 0.02), distance=0.02)

    @property
    def area(self):
        """Across the pull, of the whole plate, m2."""
        return 0.01 if self.shape == "TS" else math.pi * 0.1**2 / 4.

    def geometry(self, path):
        """Arguments of `kedge geometry` that write the plate's surface."""
        where = ["--edge-radius", "0.0025", "--output", str(path)]
        if self.shape == "TS":
            return ["plate", "--translate", f"{BASE_AT + 0.005:g}", "0", f"{SAND - self.depth:g}", *where]
        minor, length = FRUSTA[self.shape]
        return ["frustum", "--minor-diameter", f"{minor:g}", "--length", f"{length:g}", "--translate", f"{BASE_AT:g}", "0",
                f"{SAND - self.depth:g}", *where]

    def settings(self, surface):
        """What --set says of it; `surface` is the file that `geometry` wrote."""
        step = STEP_IN_CELLS * self.cell
        motion = "analysis.0.rigid body boundary conditions.0.boundary conditions.0.prescribed"
        mesh = [f"analysis.0.adaptivity.element size={self.cell:g}",
                f"analysis.0.adaptivity.element size in region={self.cell:g}"]
        if self.uniform:
            mesh = [f"material points.element size={self.cell:g}", 'analysis.0.adaptivity={"type": "none"}']
        return [f"rigid bodies.0.stl files.0.stl={surface}",
                f"rigid bodies.0.points.0.position=[{BASE_AT + 0.005:g}, 0, {SAND - self.depth:g}]",
                f"material points.layers.0.material.friction angle={self.friction_angle:g}",
                f"material points.layers.0.material.E={self.young:g}",
                f"material points.material size.max=[{BOX_LENGTH:g}, {self.half_width:g}]",
                f"contact.friction coefficient={math.tan(math.radians(self.friction_angle)):.6g}",
                *mesh,
                f"analysis.0.basis step={step / self.velocity:g}",
                f"analysis.0.final time={self.distance / self.velocity:g}",
                f"analysis.0.mass scaling={self.mass_scaling:g}",
                f"{motion}={step:g}",
                "output.vtk percent=100", "output.csv percent=0", "output.checkpoint every=10"]


def mean_at_end(curve, way=0.01):
    """Mean force over the last part of the way, N."""
    late = curve.displacement > curve.displacement.max() - way
    return np.mean(curve.force[late])
