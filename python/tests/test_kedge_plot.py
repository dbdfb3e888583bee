#!/usr/bin/python3
"""Tests of resistance curves and of the command kedge-plot on small synthetic runs."""
import unittest

import numpy as np
from synthetic_run import TemporaryFolder, write_run

from kedge_plot import PlotError
from kedge_plot.choice import Choice
from kedge_plot.resistance import fit_hyperbola, resistance_curve
from kedge_runs.run import Run


class Fit(unittest.TestCase):
    def test_exact_hyperbola_is_recovered(self):
        d = np.linspace(0., 0.05, 20)
        fit = fit_hyperbola(d, d / (1e-5 + d / 500.))
        self.assertAlmostEqual(fit.limit, 500., places=6)
        self.assertAlmostEqual(fit.stiffness, 1e5, places=3)
        self.assertAlmostEqual(float(fit(fit.displacement_at(0.98))), 490., places=6)

    def test_noisy_hyperbola_is_recovered_within_its_standard_error(self):
        d = np.linspace(0.0005, 0.05, 100)
        random = np.random.default_rng(1)
        off = []
        for _ in range(200):
            fit = fit_hyperbola(d, d / (2e-5 + d / 800.) + random.normal(0., 10., d.size))
            off.append((fit.limit - 800.) / fit.limit_error)
        self.assertLess(abs(np.mean(off)), 0.2)
        self.assertAlmostEqual(np.std(off), 1., delta=0.15)

    def test_curve_without_asymptote_is_refused(self):
        d = np.linspace(0., 0.05, 30)
        with self.assertRaisesRegex(PlotError, "does not bend"):
            fit_hyperbola(d, 1000. * d**1.1)

    def test_too_few_points_are_refused(self):
        with self.assertRaisesRegex(PlotError, "three points"):
            fit_hyperbola(np.array([0., 0.1]), np.array([0., 1.]))


class ResistanceCurve(TemporaryFolder):
    def curve(self, choice=Choice(1, None, None), factor=1., zero=False, start=None, **changes):
        columns = {f"body1_{field}_{axis}": np.zeros(4) for field in ("position", "reaction force") for axis in "xyz"}
        columns.update(time=np.arange(4.), stage=np.array([1., 1., 2., 2.]))
        columns.update(changes)
        return resistance_curve(columns, choice, factor, zero, start)

    def test_axis_is_that_of_the_motion_and_signs_follow_it(self):
        curve = self.curve(**{"body1_position_z": np.array([5., 4., 3., 2.]),
                              "body1_reaction force_z": np.array([0., -1., -2., -3.])})
        self.assertEqual(curve.axis, "z")
        np.testing.assert_array_equal(curve.displacement, [0., 1., 2., 3.])
        np.testing.assert_array_equal(curve.force, [0., 1., 2., 3.])

    def test_stage_counts_from_the_end_of_the_one_before(self):
        position = np.array([0., 1., 2., 4.])
        second, placed = Choice(1, None, [2]), Choice(1, None, [2], is_continued=False)
        np.testing.assert_array_equal(self.curve(second, body1_position_x=position).displacement, [1., 3.])
        np.testing.assert_array_equal(self.curve(placed, body1_position_x=position).displacement, [0., 2.])
        started = self.curve(second, start=[1.5, 0., 0.], body1_position_x=position)
        np.testing.assert_array_equal(started.displacement, [0.5, 2.5])

    def test_half_model_and_zero(self):
        columns = {"body1_position_x": np.arange(4.), "body1_reaction force_x": 5. + np.arange(4.)}
        curve = self.curve(factor=2., zero=True, **columns)
        np.testing.assert_array_equal(curve.force, [0., 2., 4., 6.])

    def test_displacement_counts_from_the_start(self):
        curve = self.curve(Choice(1, "x", None), start=[0.5, 0., 0.], body1_position_x=np.array([1., 2., 3., 5.]))
        np.testing.assert_array_equal(curve.displacement, [0.5, 1.5, 2.5, 4.5])

    def test_missing_body_is_named(self):
        with self.assertRaisesRegex(PlotError, "body2_position_x.*bodies in it: body1"):
            self.curve(Choice(2, None, None))

    def test_missing_stage_is_named(self):
        with self.assertRaisesRegex(PlotError, "no rows of stage 3"):
            self.curve(Choice(1, None, [3]))

    def test_row_cut_off_while_written_is_left_out(self):
        write_run(self.folder)
        self.assertEqual(len(Run(self.folder).body("time")), 60)


class Command(TemporaryFolder):
    def test_figures_appear(self):
        write_run(self.folder)
        code, out, error = self.run_command("--fit", "--area", "0.01", "--at", "1.5", "--area-above", "1.9")
        self.assertEqual((code, error), (0, ""))
        names = sorted(path.name for path in (self.folder / "plots").iterdir())
        self.assertEqual(names, ["resistance_body1_x.png", "section_y_displacement_magnitude_00012.png"])
        for name in names:
            self.assertEqual((self.folder / "plots" / name).read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertIn("q_lim = 50 +-", out)  # 500 N on 0.01 m2
        self.assertIn("area with values above 1.9:", out)

    def test_one_figure_only(self):
        write_run(self.folder)
        code, _, _ = self.run_command("--section", "--field", "stress_xx", "--output", str(self.folder / "here"))
        self.assertEqual(code, 0)
        self.assertEqual([path.name for path in (self.folder / "here").iterdir()], ["section_y_stress_xx_00012.png"])

    def test_section_is_drawn_without_a_history(self):
        write_run(self.folder)
        (self.folder / "csv" / "rigid_body.csv").unlink()
        code, out, error = self.run_command()
        self.assertEqual(code, 0)
        self.assertIn("section_y", out)
        self.assertIn("holds no rigid_body.csv", error)

    def test_empty_folder_says_what_is_missing(self):
        code, _, error = self.run_command()
        self.assertEqual(code, 1)
        self.assertIn("holds no rigid_body.csv", error)
        self.assertIn("holds no mps_1_*.vtu", error)

    def test_missing_step_lists_the_steps_there_are(self):
        write_run(self.folder)
        code, _, error = self.run_command("--section", "--step", "5")
        self.assertEqual(code, 1)
        self.assertIn("written: 12", error)

    def test_missing_folder_is_named(self):
        self.folder = self.folder / "nowhere"
        code, _, error = self.run_command()
        self.assertEqual(code, 1)
        self.assertIn("nowhere: no such folder", error)

    def test_damaged_summary_is_named(self):
        write_run(self.folder)
        (self.folder / "summary.json").write_text("{", encoding="utf-8")
        self.assertIn("summary.json: cannot be read", self.run_command()[2])


if __name__ == "__main__":
    unittest.main()
