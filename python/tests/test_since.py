#!/usr/bin/python3
"""Tests of displacement and shear strain since the start of a stage."""
import json
import unittest

import numpy as np
from synthetic_run import TemporaryFolder, VtuWriter, boxes

from kedge_plot import PlotError
from kedge_plot.fields import evaluate, shear_strain
from kedge_plot.since import output_before, subtract
from kedge_runs import RunError
from kedge_runs.run import Run

SETTLING = np.diag([1., 1., 0.9])
SHEAR = np.array([[1., 0., 0.2], [0., 1., 0.], [0., 0., 1.]])


def write_state(path, start, half, gradient, shift=(0., 0., 0.)):
    """A file of boxes with these centres at the start and half-widths, after a uniform deformation and a shift."""
    corners, cells, lower = boxes(1)
    centre = start @ gradient.T + shift
    points = centre[:, None] + half * (2. * corners - 1.)
    fields = {"displacement": (centre - start).astype(np.float32),
              "deformation gradient": np.tile(gradient.ravel(), (len(start), 1)),
              "stress": np.zeros((len(start), 6))}
    VtuWriter("raw").write(path, points.reshape(-1, 3), np.arange(8 * len(start)).reshape(-1, 8), 12, fields)


class Since(TemporaryFolder):
    def setUp(self):
        super().setUp()
        coarse = boxes(4)[2] + 0.5
        octants = (coarse[:, None] + 0.5 * (boxes(2)[2] - 0.5)).reshape(-1, 3)
        mixed = np.concatenate([coarse[::2], octants[8 * 7:]])  # some of them split since
        write_state(self.folder / "mps_1_00004.vtu", coarse, 0.5, np.eye(3))
        write_state(self.folder / "mps_1_00006.vtu", coarse, 0.5, SETTLING)
        write_state(self.folder / "mps_1_00009.vtu", mixed, 0.25, SHEAR @ SETTLING, (0.5, 0., 0.))
        self.write_stages(5, 3)

    def write_stages(self, *steps):
        summary = {"stages": [{"steps": number} for number in steps]}
        (self.folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")

    def test_split_points_move_by_what_the_stage_moves_them(self):
        run = Run(self.folder)
        self.assertEqual(output_before(run, 2, 9), (6, 6))
        grids = run.soil(9)[0]
        total = grids[0].cell_data["displacement"].copy()
        start = grids[0].points[grids[0].cells(12)].mean(axis=1) - total
        subtract(grids, run.soil(6)[0])
        data = grids[0].cell_data
        np.testing.assert_allclose(data["displacement"], start @ (SHEAR @ SETTLING - SETTLING).T + [0.5, 0., 0.],
                                   atol=1e-5)
        np.testing.assert_allclose(evaluate(data, "shear strain"), shear_strain(SHEAR[None])[0], atol=1e-5)

    def test_figure_has_a_name_of_its_own_and_no_note(self):
        code, out, error = self.run_command("--section", "--at", "1.1", "--since", "2", "--field", "shear strain")
        self.assertEqual((code, error), (0, ""))
        self.assertTrue(out.strip().endswith("section_y_shear_strain_since_stage_2_00009.png"), out)

    def test_nearest_earlier_output_is_taken_and_named(self):
        (self.folder / "mps_1_00006.vtu").unlink()
        code, out, _ = self.run_command("--section", "--at", "1.1", "--since", "2")
        self.assertEqual(code, 0)
        self.assertIn("counts from step 4: the state at step 6, at which stage 2 starts, was not written", out)

    def test_without_an_earlier_output_the_command_says_so(self):
        (self.folder / "mps_1_00004.vtu").unlink()
        (self.folder / "mps_1_00006.vtu").unlink()
        code, _, error = self.run_command("--section", "--at", "1.1", "--since", "2")
        self.assertEqual(code, 1)
        self.assertIn("no material points were written up to step 6, at which stage 2 starts, but only from step 9 on",
                      error)

    def test_first_stage_counts_from_the_start_of_the_run(self):
        (self.folder / "mps_1_00004.vtu").unlink()
        code, out, error = self.run_command("--section", "--at", "1.1", "--since", "1")
        self.assertEqual((code, error), (0, ""))
        self.assertIn("since_stage_1_00009.png", out)

    def test_a_state_before_the_stage_is_refused(self):
        code, _, error = self.run_command("--section", "--at", "1.1", "--since", "2", "--step", "6")
        self.assertEqual(code, 1)
        self.assertIn("step 6 is not later than step 6, at which stage 2 starts", error)

    def test_missing_stages_are_refused(self):
        for stage in (0, 3):
            with self.subTest(stage=stage), self.assertRaisesRegex(RunError, f"no stage {stage}; .* stages 1 to 2"):
                Run(self.folder).step_before(stage)

    def test_fields_that_do_not_add_up_are_refused(self):
        code, _, error = self.run_command("--section", "--since", "2", "--field", "stress_zz")
        self.assertEqual(code, 1)
        self.assertIn("shows displacement or shear strain, not \"stress_zz\"", error)

    def test_a_run_without_displacement_is_refused(self):
        run = Run(self.folder)
        grids = run.soil(9)[0]
        del grids[0].cell_data["displacement"]
        with self.assertRaisesRegex(PlotError, "needs the field \"displacement\""):
            subtract(grids, run.soil(6)[0])


class ShearStrain(unittest.TestCase):
    def test_pure_modes(self):
        turn = np.array([[0., -1., 0.], [1., 0., 0.], [0., 0., 1.]])
        stretch = np.exp(0.3)
        gradients = np.array([1.7 * turn, turn @ np.diag([stretch, stretch**-0.5, stretch**-0.5]),
                              np.eye(3) + 1e-4 * np.eye(3, k=2)])
        np.testing.assert_allclose(shear_strain(gradients), [0., 0.3, 1e-4 / np.sqrt(3.)], atol=1e-9)

    def test_missing_gradient_is_named_with_the_remedy(self):
        with self.assertRaisesRegex(PlotError, "\"deformation gradient\".*add it to \"vtk material point fields\""):
            evaluate({"stress": np.zeros((1, 6))}, "shear strain")


if __name__ == "__main__":
    unittest.main()
