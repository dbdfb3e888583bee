#!/usr/bin/python3
"""Tests of the scene runner: exact solutions, measures of made-up results, and detection of wrong results."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

SCENES = pathlib.Path(__file__).resolve().parents[2] / "tests" / "scenes"
sys.path[:0] = [str(SCENES), str(SCENES.parents[1] / "python")]

from expectations import ExpectationError, judge, load  # noqa: E402  (found only after the line above)
from kedge_runs import RunError  # noqa: E402
from kedge_runs.run import Run  # noqa: E402
from measures import bar, column, course, cube, footing, plate, slope  # noqa: E402


class RunCase(unittest.TestCase):
    """Makes output folders."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def make_run(self, points=None, body=None, scene=None, stages=(), log="", name="run"):
        folder = self.folder / name
        (folder / "csv").mkdir(parents=True)
        for path, columns, first in (("mps_1_00002.csv", points, "time,1\n"), ("rigid_body.csv", body, "")):
            if columns:
                rows = [",".join(map(repr, map(float, row))) for row in zip(*columns.values())]
                (folder / "csv" / path).write_text(first + "\n".join([",".join(columns), *rows]) + "\n",
                                                   encoding="utf-8")
        scene = {"output": {"csv": "on", "csv directory": "csv"}} | (scene or {})
        (folder / "input.json").write_text(json.dumps(scene), encoding="utf-8")
        (folder / "summary.json").write_text(json.dumps({"stages": list(stages)}), encoding="utf-8")
        return Run(folder, log)


def soil(thickness, young, density):
    return {"domain": {"gravity": [0, 0, -10]},
            "material points": {"material size": {"max": [2, 3]},
                                "layers": [{"thickness": thickness,
                                            "material": {"E": young, "density": density}}]}}


class Column(RunCase):
    def exact_run(self, n, stress_error=0., name="run"):
        start = (np.arange(n) + 0.5) / n
        x = column.exact_height(start, 1., 50., 200.)
        return self.make_run({"initial position_z": start, "position_z": x,
                              "stress_zz": -50. * (1. - start) + stress_error, "lp_z": np.zeros(n),
                              "initial volume": np.ones(n)},
                             scene={**soil(1., 200., 5.), "analysis": [{"load steps": 1}]}, name=name)

    def test_exact_height_agrees_with_summed_slices(self):
        middle = (np.arange(20000) + 0.5) / 20000
        stretch = column._stretch(-50. * (1. - middle) / 200.)
        np.testing.assert_allclose(np.log(stretch) / stretch, -0.25 * (1. - middle), rtol=1e-12, atol=1e-15)
        self.assertAlmostEqual(column.exact_height(1., 1., 50., 200.), np.mean(stretch), delta=1e-9)

    def test_exact_results_have_no_error(self):
        run = self.exact_run(8)
        self.assertLess(column.largest_stress_error(run), 1e-14)
        self.assertLess(column.largest_height_error(run), 1e-14)

    def test_errors_are_relative_to_the_base_stress(self):
        run = self.exact_run(8, stress_error=0.5)
        self.assertAlmostEqual(column.largest_stress_error(run), 0.01)
        self.assertAlmostEqual(column.mean_stress_error(run), 0.01)

    def test_order_is_that_of_the_errors(self):
        runs = [self.exact_run(8, error, str(error)) for error in (0.8, 0.2, 0.1)]
        self.assertAlmostEqual(column.lowest_order(*runs), 1.)

    def test_mean_error_weighs_by_volume(self):
        run = self.make_run({"initial position_z": [0.5, 1.], "stress_zz": [-25., 0.5], "initial volume": [3., 1.]},
                            scene=soil(1., 200., 5.))
        self.assertAlmostEqual(column.mean_stress_error(run), 0.0025)

    def test_jump_is_the_largest_difference_near_the_interface(self):
        # rows at the final heights 0.10, 0.31, 0.53, 0.79
        runs = [self.exact_run(4, np.array(error), str(error)) for error in ([9., 0., 2., 0.], [0., 0., 4., 0.])]
        self.assertAlmostEqual(column.jump_ratio(*runs, interface=0.42, distance=0.1), 0.5)

    def test_difference_to_given_stresses(self):
        run = self.make_run({"initial position_z": [0.1, 0.1, 0.3], "stress_zz": [-100., -101., -50.]})
        self.assertAlmostEqual(column.stress_difference(run, [0.1, 0.3], [100., 50.]), 0.01)


class Cube(RunCase):
    def test_weightless_uniform_compression_is_exact(self):
        stress = -1e4 * np.log(0.5) / 0.5  # E ln(l) / l, compressive
        scene = soil(1., 1e4, 0.)
        scene["rigid bodies"] = [{"points": [{"position": [0, 0, 3.], "mass": 2.}]}]
        run = self.make_run({"initial position_z": [0.25, 0.75], "position_z": [0.125, 0.375], "lp_z": [0.125, 0.125],
                             "stress_zz": [-stress, -stress], "contact gap": [np.nan, -0.002],
                             "initial volume": [0.5, 0.5]},
                            {"body1_position_z": [2.5], "body1_reaction force_z": [20. - 6. * stress]}, scene)
        self.assertLess(cube.hencky_error(run), 1e-12)
        self.assertLess(cube.balance_error(run), 1e-12)
        self.assertEqual(cube.spread(run), 0.)
        self.assertAlmostEqual(cube.penetration(run), 0.002)


class Footing(RunCase):
    def test_excess_compares_the_forces_over_the_thickness(self):
        runs = []
        for thickness, force in ((3., 36.), (2., 20.)):
            scene = soil(1., 1e4, 0.)
            scene["material points"]["material size"]["max"] = [2, thickness]
            scene["rigid bodies"] = [{"points": [{"position": [0, 0, 3.], "mass": 2.}]}]
            runs.append(self.make_run(body={"body1_reaction force_z": [0., 20. - force]}, scene=scene,
                                      name=str(thickness)))
        self.assertAlmostEqual(footing.excess(*runs), 0.2)

    def make_strip(self, *load):
        """A run of half a strip of 2 m on clay of 5 kPa: Prandtl's limit is (2 + pi) 5 kN."""
        scene = {"material points": {"layers": [{"material": {"yield stress": 5e3 * np.sqrt(3.)}}]},
                 "rigid bodies": [{"outline": [{"polygon": [[-0.1, 0.], [1., 0.], [1., 1.], [-0.1, 1.]]}]}]}
        return self.make_run(body={"body1_reaction force_z": [-x for x in load]}, scene=scene)

    def test_strip_is_compared_with_prandtl(self):
        self.assertAlmostEqual(footing.prandtl_excess(self.make_strip(0., 1.1 * (2. + np.pi) * 5e3)), 0.1)

    def test_a_load_that_still_rises_is_detected(self):
        self.assertAlmostEqual(footing.last_rise(self.make_strip(*np.arange(1., 21.))), 0.1)


class Plate(RunCase):
    def make_plate(self, direction):
        travel = np.linspace(0.01, 0.05, 5)
        force = 0.5 * 1e4 * travel / (0.01 + travel)
        scene = {"rigid bodies": [{"points": [{"position": [1., 0., 0.], "mass": 1.}]}]}
        return self.make_run({"initial position_x": 1. + direction * np.array([0.1, -0.1, 0.1]),
                              "initial position_y": [0., 0., 0.], "initial position_z": [1., 1., 0.5],
                              "displacement_z": [0.02, -0.01, 5.]},
                             {"body1_position_x": 1. + direction * travel,
                              "body1_reaction force_x": direction * force}, scene, name=str(direction))

    def test_measures_follow_the_motion(self):
        for direction in (1., -1.):
            run = self.make_plate(direction)
            self.assertAlmostEqual(plate.limit(run, 0.1), 1e5, delta=1.)
            self.assertGreater(plate.smallest_growth(run, 0.1), 0.)
            self.assertLess(plate.flattening(run, 0.1), 0.2)
            self.assertEqual(plate.rise_in_front(run), 0.02)
            self.assertEqual(plate.rise_behind(run), -0.01)


class BarVibration(RunCase):
    LENGTH, YOUNG, DENSITY, DT = 1., 160., 10., 0.01  # period 1 s

    def make_bar(self, periods=2., stretch=1., energy=1., name="run"):
        """A run with the exact sum of modes at points along the bar. energy: factor on the squares of velocity and
        strain."""
        scene = {**soil(self.LENGTH, self.YOUNG, self.DENSITY),
                 "analysis": [{"dt": self.DT, "final time": periods, "beta": 0.25, "gamma": 0.5}]}
        run = self.make_run(scene=scene, stages=[{"cuts": 0}], name=name)
        z = (np.arange(100) + 0.5) / 100
        odd = np.arange(1, 200, 2)[:, None]
        k, phase = 0.5 * np.pi * odd, 2. * np.pi * odd / stretch
        amplitude = 160. * self.DENSITY / self.YOUNG / (np.pi * odd)**3  # of gravity 10 in u'' = -rho g / E
        for step in range(1, round(periods / self.DT) + 1):
            time, scale = step * self.DT, np.sqrt(energy)
            columns = {axes: 0. * z for axes in ("velocity_x", "velocity_y", "strain_xx", "strain_yy", "strain_xy",
                                                 "strain_yz", "strain_xz")}
            columns["initial position_z"], columns["initial volume"] = z, 0.06 + 0. * z
            columns["displacement_z"] = -np.sum(amplitude * np.sin(k * z) * (1. - np.cos(phase * time)), axis=0)
            columns["velocity_z"] = -scale * np.sum(amplitude * phase * np.sin(k * z) * np.sin(phase * time), axis=0)
            columns["strain_zz"] = -scale * np.sum(amplitude * k * np.cos(k * z) * (1. - np.cos(phase * time)), axis=0)
            rows = [",".join(map(repr, map(float, row))) for row in zip(*columns.values())]
            (run.folder / "csv" / f"mps_1_{step + 1:05d}.csv").write_text(
                "\n".join([f"time,{time}", ",".join(columns), *rows]) + "\n", encoding="utf-8")
        return run

    def test_exact_motion_has_no_error(self):
        run = self.make_bar()
        self.assertAlmostEqual(bar.Bar.of(run).period, 1.)
        self.assertLess(bar.period_error(run), 1e-5)
        self.assertLess(bar.end_error(run), 1e-3)  # the uppermost points lie below the end
        self.assertLess(bar.energy_drift(run), 2e-3)
        self.assertAlmostEqual(bar.energy_left(run), 1., delta=2e-3)

    def test_a_long_period_is_detected(self):
        self.assertAlmostEqual(bar.period_error(self.make_bar(stretch=1.02)), 0.02, delta=1e-4)

    def test_energy_that_grows_is_detected(self):
        self.assertGreater(bar.energy_growth(self.make_bar(periods=0.5, energy=1.1)), 0.05)

    def test_modes_keep_energy_or_lose_it(self):
        run = self.make_bar(periods=0.02)
        stage = {"dt": 0.0125, "final time": 10., "beta": 0.25, "gamma": 0.5}
        for changes, left in (({}, 1.), ({"beta": 0.5, "gamma": 1.}, np.exp(-0.5 * 0.0125 * (2. * np.pi)**2 * 10.))):
            (run.folder / "input.json").write_text(json.dumps({**run.input, "analysis": [{**stage, **changes}]}),
                                                   encoding="utf-8")
            self.assertAlmostEqual(bar.expected_energy_left(Run(run.folder)), left, delta=0.02)


class Slope(RunCase):
    def make_slide(self, friction, acceleration, turning=0., settled=False):
        """A run of a body with 5 kg and I = 2 kg m2 that starts at x = 3 m (settled: 3.5 m) under gravity of 8 and
        6 m/s2."""
        time = np.linspace(0., 2., 5)
        x = (3.5 if settled else 3.) + 0.5 * acceleration * time**2
        columns = {"time": time, "body1_position_x": x, "body1_velocity_x": acceleration * time,
                   "body1_rotation_y": 0.5 * turning * time**2, "stage": [1., 2., 2., 2., 2.] if settled else 5 * [1.]}
        if not settled:  # the start is not written
            columns = {name: values[1:] for name, values in columns.items()}
        scene = {"domain": {"gravity": [8., 0., -6.]}, "contact": {"friction coefficient": friction},
                 "rigid bodies": [{"offset": [2., 0., 0.], "points": [
                     {"position": [1., 0., 0.], "mass": 5., "rotational inertia": [9., 2., 9.]}]}]}
        return self.make_run(body=columns, scene=scene, name=f"{friction} {acceleration} {settled}")

    def test_block_slides_from_the_end_of_the_stage_before(self):
        run = self.make_slide(0.5, 8. - 0.5 * 6., settled=True)
        self.assertLess(slope.distance_error(run), 1e-12)
        self.assertLess(slope.speed_error(run), 1e-12)
        self.assertAlmostEqual(slope.largest_distance(run), 10.)

    def test_ball_slides(self):
        run = self.make_slide(0.1, 8. - 0.1 * 6., turning=0.1 * 6. * 5. / 2.)  # moment mu N r over I
        self.assertLess(slope.distance_error(run, radius=1.), 1e-12)
        self.assertLess(slope.turn_error(run, radius=1.), 1e-12)

    def test_ball_rolls(self):
        run = self.make_slide(0.6, 8. * 5. / 7., turning=8. * 5. / 7.)
        self.assertLess(slope.distance_error(run, radius=1.), 1e-12)
        self.assertLess(slope.turn_error(run, radius=1.), 1e-12)

    def test_a_wrong_distance_is_detected(self):
        self.assertAlmostEqual(slope.distance_error(self.make_slide(0.5, 5.5)), 0.1)


class Course(RunCase):
    def test_iterations_and_cuts(self):
        log = "stage 1/1 step 2 NR 3 cuts 0 del 0\nstage 1/1 step 3 NR 5 cuts 1 del 0\n"
        run = self.make_run(log=log, stages=[{"steps": 2, "cuts": 1, "newton iterations": 8}])
        self.assertEqual(course.most_iterations(run), 5)
        self.assertEqual(course.mean_iterations(run), 4.)
        self.assertEqual(course.cuts(run), 1)

    def test_difference_of_two_runs(self):
        runs = [self.make_run({"a": [1., 2.], "b": [0., 1e-3 * i]}, name=str(i)) for i in (1, 2)]
        self.assertAlmostEqual(course.largest_difference(*runs, columns=["a"]), 0.)
        self.assertAlmostEqual(course.largest_difference(*runs, columns=["a", "b"]), 1.)

    def test_a_missing_column_is_named(self):
        with self.assertRaisesRegex(RunError, "no column \"b\""):
            self.make_run({"a": [1.]}).points("b")


class Expectations(RunCase):
    def judge(self, **expectation):
        run = self.make_run(stages=[{"steps": 1, "cuts": 2}], name=str(expectation))
        return judge({"statement": "cuts", "measure": "course.cuts", **expectation}, {"run": run}).holds

    def test_bounds(self):
        self.assertTrue(self.judge(**{"at most": 2, "at least": 2}))
        self.assertFalse(self.judge(**{"at most": 1}))
        self.assertFalse(self.judge(**{"at least": 3}))

    def test_nan_fulfils_no_bound(self):
        run = self.make_run({"a": [np.nan]})
        expectation = {"statement": "", "measure": "course.largest_difference", "with": {"columns": ["a"]},
                       "at most": 1e300}
        self.assertFalse(judge(expectation, {"1": run, "2": run}).holds)

    def test_unknown_names_are_refused(self):
        good = {"statement": "s", "measure": "course.cuts", "at most": 0}
        path = self.folder / "x.json"
        for change, message in (({"at most": None}, "no bound"), ({"almost": 1}, "unknown \"almost\""),
                                ({"of": ["b"]}, "unknown run \"b\"")):
            expectation = {key: value for key, value in {**good, **change}.items() if value is not None}
            path.write_text(json.dumps({"runs": {"a": {"scene": "s"}}, "expect": [expectation]}), encoding="utf-8")
            with self.assertRaisesRegex(ExpectationError, message):
                load(path)
        with self.assertRaisesRegex(ExpectationError, "no measure"):
            judge({**good, "measure": "course.unknown"}, {})

    def test_every_file_of_expectations_is_well_formed(self):
        for path in SCENES.glob("*.json"):
            with self.subTest(path.name):
                content = load(path)
                for run in content["runs"].values():
                    self.assertTrue((SCENES.parents[1] / run["scene"]).is_file(), run["scene"])


class Command(RunCase):
    def run_scene(self, program):
        (self.folder / "kedge").write_text(program, encoding="utf-8")
        (self.folder / "kedge").chmod(0o755)
        (self.folder / "x.json").write_text(json.dumps({
            "runs": {"a": {"scene": "prm/column.json"}},
            "expect": [{"statement": "cuts", "measure": "course.cuts", "at most": 0}]}), encoding="utf-8")
        return subprocess.run([sys.executable, str(SCENES / "run-scene"), str(self.folder / "x.json"), "--program",
                               str(self.folder / "kedge")], capture_output=True, text=True, check=False)

    def test_passes_and_fails(self):
        program = "#!/bin/bash\nmkdir -p $4\necho '{{\"stages\": [{{\"cuts\": {}}}]}}' >$4/summary.json\n"
        for cuts, code, words in ((0, 0, "1 passed, 0 failed"), (1, 1, "0 passed, 1 failed")):
            result = self.run_scene(program.format(cuts))
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(words, result.stdout)

    def test_a_failing_program_is_reported(self):
        result = self.run_scene("#!/bin/bash\necho too bad >&2\nexit 3\n")
        self.assertEqual(result.returncode, 2)
        self.assertIn("exit code 3", result.stderr)
        self.assertIn("too bad", result.stderr)


if __name__ == "__main__":
    unittest.main()
