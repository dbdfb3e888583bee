"""The plate-anchor study: its cases, and how it reads their results."""
import json
import math
import pathlib
import sys
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "benchmarks" / "plate-anchors"), str(ROOT / "python")]

from cases import Case, mean_at_end  # noqa: E402
from kedge_plot.resistance import Curve  # noqa: E402


def value_of(case, key):
    found, = [text for text in case.settings("plate.stl") if text.startswith(key + "=")]
    return json.loads(found.split("=", 1)[1])


class Cases(unittest.TestCase):
    def test_folder_says_what_differs(self):
        self.assertEqual(Case().name, "TS")
        self.assertEqual(Case("LFC", cell=0.02, friction_angle=41.).name, "LFC-cell-0.02-friction-angle-41")
        self.assertEqual(len({Case().name, Case(depth=0.11).name, Case().quick().name}), 3)

    def test_body_moves_a_share_of_a_cell_per_basis_step_at_its_velocity(self):
        case = Case(cell=0.005, velocity=0.2)
        step = value_of(case, "analysis.0.rigid body boundary conditions.0.boundary conditions.0.prescribed")
        self.assertAlmostEqual(step, 0.05 * case.cell)
        self.assertAlmostEqual(step / value_of(case, "analysis.0.basis step"), case.velocity)
        self.assertAlmostEqual(value_of(case, "analysis.0.final time"), case.distance / case.velocity)

    def test_plate_is_as_rough_as_the_sand(self):
        self.assertAlmostEqual(value_of(Case(friction_angle=30.), "contact.friction coefficient"),
                               math.tan(math.radians(30.)), places=5)

    def test_surface_and_point_lie_at_the_same_depth(self):
        for shape in ("TS", "MFC"):
            case = Case(shape, depth=0.11)
            arguments = case.geometry("plate.stl")
            height = float(arguments[arguments.index("--translate") + 3])
            self.assertAlmostEqual(height, 0.32 - 0.11)
            self.assertAlmostEqual(value_of(case, "rigid bodies.0.points.0.position")[2], height)

    def test_settings_name_keys_of_the_scene(self):
        scene = json.loads((ROOT / "prm" / "plate-anchor-explicit.json").read_text(encoding="utf-8"))
        for text in Case().settings("plate.stl"):
            at = scene
            for key in text.split("=", 1)[0].split(".")[:-1]:
                at = at[int(key)] if isinstance(at, list) else at[key]

    def test_defaults_are_those_of_the_scene(self):
        scene = json.loads((ROOT / "prm" / "plate-anchor-explicit.json").read_text(encoding="utf-8"))
        stage = scene["analysis"][0]
        self.assertAlmostEqual(stage["basis step"], value_of(Case(), "analysis.0.basis step"))
        self.assertAlmostEqual(stage["final time"], value_of(Case(), "analysis.0.final time"))
        self.assertEqual(scene["rigid bodies"][0]["points"][0]["position"],
                         value_of(Case(), "rigid bodies.0.points.0.position"))


class Results(unittest.TestCase):
    def test_mean_covers_the_last_part_of_the_way(self):
        displacement = np.linspace(0.001, 0.05, 50)
        force = np.where(displacement > 0.0401, 3., 1.)
        self.assertAlmostEqual(mean_at_end(Curve(displacement, force, "x", 1)), 3.)


if __name__ == "__main__":
    unittest.main()
