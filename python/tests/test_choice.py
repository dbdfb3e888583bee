#!/usr/bin/python3
"""Tests of what kedge-plot draws of a run's resistance where the user leaves it open."""
import json
import pathlib
import unittest

from synthetic_run import TemporaryFolder, write_run

from kedge_plot import PlotError
from kedge_plot.choice import Choice, choose

SCENES = pathlib.Path(__file__).resolve().parents[2] / "prm"


def scene(*stages, conditions=("free", "free", "free")):
    """An input with two points, one in each system, and these stages."""
    system = {"points": [{"boundary conditions": list(conditions)}]}
    return {"rigid bodies": [system, system], "analysis": list(stages)}


def driven(system, *conditions, **keys):
    """A stage with conditions of its own for a system's point; numbers are prescribed movements."""
    conditions = [{"prescribed": entry} if isinstance(entry, float) else entry for entry in conditions]
    return {"rigid bodies": "on", "rigid body boundary conditions": [
        {"system": system, "point": 1, "boundary conditions": conditions}]} | keys


OFF = {"rigid bodies": "off"}
FREE = {"rigid bodies": "on"}
PLACED = {"rigid bodies": "on", "rigid body surface placement": "on"}


class Choose(unittest.TestCase):
    def test_scenes_of_the_repository(self):
        for name, reached, expected in (("drag-anchor-quick", {1, 2, 3}, Choice(3, "x", [3])),
                                        ("drag-anchor-quick", {1, 2}, Choice(1, None, [2], False)),
                                        ("plate-anchor-quick", {1}, Choice(1, "x", [1])),
                                        ("strip-footing", {1}, Choice(1, "z", [1]))):
            with self.subTest(name, reached=reached):
                content = json.loads((SCENES / f"{name}.json").read_text(encoding="utf-8"))
                self.assertEqual(choose(content, reached), expected)

    def test_the_last_stage_with_a_prescribed_motion(self):
        content = scene(OFF, driven(1, -0.1, 0.3, "free"), driven(2, "free", "fixed", 0.2), FREE)
        self.assertEqual(choose(content, {1, 2, 3, 4}), Choice(2, "z", [3]))
        self.assertEqual(choose(content, {1, 2}), Choice(1, "y", [2], False))
        self.assertEqual(choose(content, {1, 2, 3}, body=1), Choice(1, "y", [2], False))
        self.assertEqual(choose(content, {1, 2, 3}, body=1, axis="x"), Choice(1, "x", [2], False))

    def test_another_body_is_shown_while_the_prescribed_one_moves(self):
        content = scene(PLACED, driven(2, 0.1, "free", "free"))
        self.assertEqual(choose(content, {1, 2}, body=1), Choice(1, None, [2]))

    def test_conditions_of_the_points_hold_in_all_stages(self):
        content = scene(OFF, FREE, FREE, conditions=("free", {"prescribed": 0.}, {"prescribed": -1.}))
        self.assertEqual(choose(content, {1, 2, 3}), Choice(1, "z", [3]))
        self.assertEqual(choose(content | {"dimension": 2}, {1}), Choice(1, None, None))

    def test_without_a_prescribed_motion_rows_begin_with_the_placement(self):
        self.assertEqual(choose(scene(OFF, FREE, OFF, FREE), {1, 2, 3, 4}), Choice(1, None, [2, 4], False))
        self.assertEqual(choose(scene(FREE, PLACED, FREE), {1, 2, 3}), Choice(1, None, [2, 3], False))

    def test_unknown_input_shows_all_rows(self):
        self.assertEqual(choose({}, {1, 2}), Choice(1, None, None))
        self.assertEqual(choose({}, {1, 2}, 2, "x", [2]), Choice(2, "x", [2]))

    def test_stages_that_no_curve_joins_are_refused(self):
        content = scene(OFF, FREE, PLACED, FREE)
        self.assertEqual(choose(content, {1, 2, 3, 4}, stages=[4, 3]), Choice(1, None, [3, 4], False))
        with self.assertRaisesRegex(PlotError, "--stage 1: the bodies are \"off\""):
            choose(content, {1, 2, 3, 4}, stages=[1])
        with self.assertRaisesRegex(PlotError, "--stage 3: the bodies are placed anew"):
            choose(content, {1, 2, 3, 4}, stages=[2, 3])


class Command(TemporaryFolder):
    def setUp(self):
        super().setUp()
        write_run(self.folder)
        self.output = {"csv": "on", "csv directory": "csv", "vtk": "on", "vtk directory": "vtk"}

    def write_input(self, **content):
        (self.folder / "input.json").write_text(json.dumps(content | {"output": self.output}), encoding="utf-8")

    def test_the_prescribed_axis_is_drawn(self):
        self.write_input(**scene(driven(1, "free", "free", 0.1)))
        code, out, error = self.run_command("--resistance")
        self.assertEqual((code, error), (0, ""))
        self.assertIn("resistance_body1_z.png", out)

    def test_forces_in_plane_strain_are_per_metre(self):
        for dimension, unit in ((2, " N/m, k"), (3, " N, k")):
            self.write_input(dimension=dimension)
            self.assertIn(unit, self.run_command("--resistance", "--fit")[1])

    def test_wrong_options_end_with_2(self):
        self.write_input()
        for options in (("--area", "0"), ("--limits", "2", "1"), ("--window", "0", "1", "3", "2")):
            with self.subTest(options):
                self.assertEqual(self.run_command(*options)[0], 2)


if __name__ == "__main__":
    unittest.main()
