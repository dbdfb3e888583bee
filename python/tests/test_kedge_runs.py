#!/usr/bin/python3
"""Tests of kedge_runs: commands, and tables of small synthetic runs. test_kedge_plot.py tests the VTK files."""
import json
import pathlib
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from kedge_runs import RunError  # noqa: E402  (found only after the line above)
from kedge_runs.program import command  # noqa: E402
from kedge_runs.run import Run  # noqa: E402


class Tables(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def test_points_of_all_layers_come_in_the_order_of_the_layers(self):
        for layer in (2, 10, 1, 3, 11, 4):
            self.write(f"csv/mps_{layer}_00003.csv", f"time,1\nvolume,lp_x\n{layer},0\n")
        self.write("csv/mps_1_00002.csv", "time,1\nvolume,lp_x\n7,0\n")
        run = Run(self.folder)
        self.assertEqual(run.csv_steps(), [2, 3])
        np.testing.assert_array_equal(run.points("volume"), [1., 2., 3., 4., 10., 11.])
        np.testing.assert_array_equal(run.points("volume", 2), [7.])

    def test_a_row_that_is_not_complete_is_left_out(self):
        self.write("csv/rigid_body.csv", "time,step\n1,2\n2")
        np.testing.assert_array_equal(Run(self.folder).body("step"), [2.])

    def test_a_number_that_may_go_on_is_left_out(self):
        self.write("csv/rigid_body.csv", "time,step\n1,2\n2,3\n3,1")
        np.testing.assert_array_equal(Run(self.folder).body("step"), [2., 3.])

    def test_every_number_that_the_program_writes_is_read_back(self):
        values = [0.1, -1.2345678901234567e-300, 5e-324, -0., np.inf, -np.inf, np.nan]
        self.write("mps_1_00002.csv", "time,1\ngap,x\n" + "".join(f"{value!r},1\n" for value in values))
        read = Run(self.folder).points("gap")
        np.testing.assert_array_equal(read, values)
        np.testing.assert_array_equal(np.signbit(read)[:-1], np.signbit(values)[:-1])

    def test_a_word_among_the_numbers_is_named(self):
        self.write("csv/rigid_body.csv", "time,step\n1,2\nlate,3\n")
        with self.assertRaisesRegex(RunError, "rigid_body.csv: could not convert string 'late'"):
            Run(self.folder).bodies()

    def test_a_table_that_is_not_text_is_named(self):
        (self.folder / "rigid_body.csv").write_bytes(b"time\xff\n1\n")
        with self.assertRaisesRegex(RunError, "rigid_body.csv: is not text"):
            Run(self.folder).bodies()

    def test_a_table_without_rows_is_named(self):
        self.write("csv/rigid_body.csv", "time,step\n")
        with self.assertRaisesRegex(RunError, "rigid_body.csv: holds no rows yet"):
            Run(self.folder).bodies()

    def test_a_folder_with_several_runs_is_refused(self):
        for name in ("a", "b"):
            self.write(f"{name}/rigid_body.csv", "time,step\n1,2\n")
        with self.assertRaisesRegex(RunError, "several runs"):
            Run(self.folder).bodies()

    def test_a_folder_with_the_vtk_files_of_several_runs_is_refused(self):
        for name in ("a/vtk", "b/vtk"):
            self.write(f"{name}/mps_1_00002.vtu", "")
        with self.assertRaisesRegex(RunError, "several runs \\(.*a/vtk, .*b/vtk\\); name one"):
            Run(self.folder).soil()
        for name in ("a", "b"):
            self.write(f"{name}/input.json", "{}")
        with self.assertRaisesRegex(RunError, "several runs \\(.*/a, .*/b\\); name one"):
            Run(self.folder).soil()

    def test_the_input_names_the_folders_and_others_are_of_an_earlier_run(self):
        for name, value in (("old", 1), ("new", 2)):
            self.write(f"{name}/rigid_body.csv", f"time,step\n1,{value}\n")
            self.write(f"{name}/mps_1_0000{value}.csv", "time,1\nvolume\n1\n")
            self.write(f"{name}/mps_1_0000{value}.vtu", "")
        output = {"csv": "on", "csv directory": "new", "vtk": "on", "vtk directory": "new"}
        self.write("input.json", json.dumps({"output": output}))
        run = Run(self.folder)
        self.assertEqual((run.csv_steps(), run.vtk_steps(), list(run.body("step"))), ([2], [2], [2.]))
        self.write("input.json", json.dumps({"output": output | {"csv": "off", "vtk": "off"}}))
        run = Run(self.folder)
        self.assertEqual((run.csv_steps(), run.vtk_steps()), ([], []))
        with self.assertRaisesRegex(RunError, "holds no rigid_body.csv"):
            run.bodies()

    def test_rows_from_before_a_restart_with_other_columns_come_first(self):
        self.write("rigid_body-10.csv", "time,b,c,stage,step\n4,40,0,1,5\n5,50,0,1,6\n")
        self.write("rigid_body-2.csv", "time,a,b,stage,step\n2,0,20,1,3\n3,0,30,1,4\n")
        self.write("rigid_body-1.csv", "time,b,stage,step\n1,10,1,2\n2,21,1,3\n")  # its last step was made again
        self.write("rigid_body-old.csv", "time\n1\n")
        self.write("rigid_body.csv", "time,b,d,stage,step\n5,51,0,1,6\n")
        columns = Run(self.folder).bodies()
        self.assertEqual(list(columns), ["time", "b", "stage", "step"])
        np.testing.assert_array_equal(columns["step"], [2., 3., 4., 5., 6.])
        np.testing.assert_array_equal(columns["b"], [10., 20., 30., 40., 51.])

    def test_steps_have_stages_and_times_within_them(self):
        self.write("summary.json", json.dumps({"stages": [{"steps": 2}, {"steps": 3}, {"steps": 0}]}))
        entries = "".join(f'<DataSet timestep="{time}" part="0" file="mps_1_{step:05d}.pvtu"/>\n'
                          for step, time in ((2, 0.5), (3, 1), (5, 1.5), (7, 2.25)))
        self.write("mps_1.pvd", entries)
        self.write("mps_1_00003.vtu", "")
        run = Run(self.folder)
        self.assertEqual([run.stage_of(step) for step in (1, 2, 3, 4, 6, 7)], [1, 1, 1, 2, 2, 3])
        self.assertEqual([run.time_of(step) for step in (2, 3, 4, 5, 7)], [0.5, 1., None, 0.5, None])
        (self.folder / "summary.json").unlink()
        self.assertEqual((Run(self.folder).stage_of(3), Run(self.folder).time_of(3)), (None, None))

    def test_a_missing_column_is_named_beside_those_that_are_there(self):
        self.write("csv/rigid_body.csv", "time,step\n1,2\n")
        with self.assertRaisesRegex(RunError, "no column \"stage\"; it has time, step"):
            Run(self.folder).body("stage")

    def test_summary_may_be_missing_but_not_its_stages(self):
        run = Run(self.folder)
        self.assertEqual((run.summary, run.is_finished, run.start_of(1)), ({}, False, None))
        with self.assertRaisesRegex(RunError, "no summary.json that lists stages"):
            print(run.stages)

    def test_summary_says_where_a_body_starts_and_where_the_time_goes(self):
        self.write("summary.json", json.dumps({
            "status": "finished", "stages": [{"rigid points at start": [[1., 2., 3.]]}],
            "wall time": {"total": 10., "phases": {"residual": 6., "output": 2.}}}))
        run = Run(self.folder)
        self.assertTrue(run.is_finished)
        self.assertEqual(run.start_of(1), [1., 2., 3.])
        self.assertIsNone(run.start_of(2))
        self.assertAlmostEqual(run.share_outside_newton(), 0.2)


class Command(unittest.TestCase):
    def test_settings_and_options_follow_the_folder(self):
        self.assertEqual(command("kedge", "a.json", "out", ["x=1", "y=2"], options=["--quiet"]),
                         ["kedge", "run", "a.json", "--output", "out", "--quiet", "--set", "x=1", "--set", "y=2"])

    def test_several_ranks_need_mpirun(self):
        words = command("kedge", "a.json", "out", ranks=2)
        self.assertEqual(pathlib.Path(words[0]).name, "mpirun")
        self.assertEqual(words[1:4], ["-n", "2", "kedge"])


if __name__ == "__main__":
    unittest.main()
