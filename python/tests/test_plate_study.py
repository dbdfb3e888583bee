"""Tests of the plate-anchor study: its cases and its records."""
import dataclasses
import json
import math
import pathlib
import sys
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "benchmarks" / "plate-anchors"), str(ROOT / "python")]

from cases import Case, broms_square, limit_strip, rankine_strip, teng_square  # noqa: E402
from records import as_text, mean_between  # noqa: E402


def value_of(case, key):
    found, = [text for text in case.settings("plate.stl") if text.startswith(key + "=")]
    return json.loads(found.split("=", 1)[1])


class Cases(unittest.TestCase):
    def test_folder_says_what_differs(self):
        self.assertEqual(Case().name, "TS")
        self.assertEqual(Case("LFC", base=0.02, friction_angle=41.).name, "LFC-base-0.02-friction-angle-41")
        self.assertEqual(len({Case().name, Case(depth=0.11).name, Case().quick().name}), 3)

    def test_body_moves_a_share_of_a_cell_per_basis_step_at_its_velocity(self):
        case = Case(cell=0.005, velocity=0.2)
        stage = value_of(case, "analysis.0")
        step = stage["rigid body boundary conditions"][0]["boundary conditions"][0]["prescribed"]
        self.assertAlmostEqual(step, 0.05 * case.cell)
        self.assertAlmostEqual(step / stage["basis step"], case.velocity)
        self.assertAlmostEqual(stage["final time"], case.distance / case.velocity)
        implicit = dataclasses.replace(case, analysis="dynamic")
        stage = value_of(implicit, "analysis.0")
        step = stage["rigid body boundary conditions"][0]["boundary conditions"][0]["prescribed"]
        self.assertAlmostEqual(step / stage["dt"], case.velocity)

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
        for case in (Case(), Case(analysis="static")):
            scene = json.loads((ROOT / "prm" / case.scene).read_text(encoding="utf-8"))
            for text in case.settings("plate.stl"):
                at = scene
                for key in text.split("=", 1)[0].split(".")[:-1]:
                    at = at[int(key)] if isinstance(at, list) else at[key]

    def test_static_plate_is_the_scene(self):
        case = Case(ahead=True, analysis="static")
        stage = json.loads((ROOT / "prm" / case.scene).read_text(encoding="utf-8"))["analysis"][0]
        box, = value_of(case, "analysis.0")["adaptivity"]["boxes"]
        scene_box, = stage["adaptivity"]["boxes"]
        for key in ("min", "max"):
            np.testing.assert_allclose(box[key], scene_box[key])
        self.assertEqual(box["element size"], scene_box["element size"])
        rest = [{**each, "adaptivity": {**each["adaptivity"], "boxes": []}}
                for each in (stage, value_of(case, "analysis.0"))]
        self.assertEqual(*rest)
        motion = stage["rigid body boundary conditions"][0]["boundary conditions"][0]["prescribed"]
        self.assertEqual(motion * stage["load steps"], case.distance)

    def test_cells_of_one_size_are_those_of_the_scene(self):
        scene = json.loads((ROOT / "prm" / "plate-anchor-explicit.json").read_text(encoding="utf-8"))
        stage = scene["analysis"][0]
        coarse = Case().with_cells(0.01)
        for key in ("basis step", "final time", "mass scaling", "adaptivity.element size", "adaptivity.region"):
            expected, found = stage, value_of(coarse, "analysis.0")
            for name in key.split("."):
                expected, found = expected[name], found[name]
            self.assertAlmostEqual(expected, found)
        self.assertEqual(scene["rigid bodies"][0]["points"][0]["position"],
                         value_of(Case(), "rigid bodies.0.points.0.position"))


class Results(unittest.TestCase):
    def test_mean_covers_a_part_of_the_way(self):
        displacement = np.linspace(0.001, 0.05, 50)
        force = np.where(displacement > 0.0401, 3., 1.)
        self.assertAlmostEqual(mean_between(displacement, force, 0.0401), 3.)
        self.assertAlmostEqual(mean_between(displacement, force, 0.03, 0.035), 1.)

    def test_records_are_json_with_curves_on_one_line(self):
        record = {"force": [1., 2.5], "cells": 3, "mobilised": {"vertical": [0.1, 0.2]}}
        self.assertEqual(json.loads(as_text(record)), record)
        self.assertIn("1.0, 2.5", as_text(record))


class LimitLoads(unittest.TestCase):
    def test_values_worked_by_hand(self):
        case = Case(friction_angle=30., depth=0.15)  # passive pressure 3, active 1/3
        self.assertAlmostEqual(rankine_strip(case), 0.5 * 1590. * 9.81 * 0.04 * (3. - 1. / 3.) / 0.1)
        self.assertAlmostEqual(broms_square(case), 9. * 1590. * 9.81 * 0.15)
        self.assertAlmostEqual(limit_strip(case), 7.13 * 1590. * 9.81 * 0.2)
        self.assertGreater(teng_square(case), rankine_strip(case))

    def test_layer_is_deep_enough(self):
        self.assertAlmostEqual(Case(depth=0.16).layer, 0.32)
        self.assertAlmostEqual(Case(depth=0.3).layer, 0.48)


if __name__ == "__main__":
    unittest.main()
