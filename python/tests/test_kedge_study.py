#!/usr/bin/python3
"""Tests of kedge-study: the file, what varies, and runs of a made-up program."""
import contextlib
import csv
import io
import json
import os
import pathlib
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest

PYTHON = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PYTHON))

import matplotlib.pyplot as plt  # noqa: E402  (found only after the line above)

from kedge_study import StudyError, panels  # noqa: E402
from kedge_study.cases import cases_of, label  # noqa: E402
from kedge_study.command import main  # noqa: E402
from kedge_study.inputs import replace  # noqa: E402
from kedge_study.records import version_of  # noqa: E402
from kedge_study.results import of_runs  # noqa: E402
from kedge_study.study import load  # noqa: E402

# A program that answers force = 10 + h^2 at u = 0 to 1; "fail": it stops half way with exit code 3.
PROGRAM = '''#!/usr/bin/python3
import json, os, pathlib, sys, time
if sys.argv[1] == "--version":
    print("kedge 0 (commit COMMIT, back end Serial)")
    sys.exit()
scene = json.loads(pathlib.Path(sys.argv[2]).read_text())
if scene.get("bad"):
    print("kedge: bad: unknown key", file=sys.stderr)
    sys.exit(2)
if sys.argv[1] == "check":
    print(json.dumps({"stages": [{"time": scene["time"], "memory": scene["memory"]}],
                      "columns": ["time", "body1_position_x", "body1_reaction force_x", "stage", "step"]}))
    sys.exit()
folder = pathlib.Path(sys.argv[sys.argv.index("--output") + 1])
(folder / "csv").mkdir(parents=True)
with open(folder / "started", "w") as file:
    file.write(str(os.getpid()))
if scene["h"] == scene.get("file error"):
    sys.exit(4)
time.sleep(scene["sleep"])
end = 5 if scene["fail"] else 10
rows = ["time,body1_position_x,body1_reaction force_x,stage,step"]
for step in range(1, end + 1):
    rows.append(f"{step / 10},{5 + step / 10},{10 + scene['h']**2},1,{step}")
(folder / "csv" / "rigid_body.csv").write_text("\\n".join(rows) + "\\n")
summary = {"status": "failed" if scene["fail"] else "finished", "peak memory": 1e8,
           "stages": [{"steps": end, "cuts": 2, "rigid points at start": [[5, 0, 0]]}]}
(folder / "summary.json").write_text(json.dumps(summary))
if scene["fail"]:
    print("kedge: no convergence", file=sys.stderr)
    sys.exit(3)
'''
SCENE = {"comment": "x", "h": 1, "fail": False, "sleep": 0, "time": 1, "memory": 1e6, "list": [{"deep": 1}]}
STUDY = {
    "title": "Test", "question": "?", "scene": "scene.json", "constants": {"exact": "= 2 * 5"},
    "parameters": {"h": {"default": 1, "label": "cell size / m"}, "fail": {"default": False}},
    "derived": {"steps": "round(1 / h)"},
    "set": {"h": "= h", "fail": "= fail", "list.0.deep": ["= steps"]},
    "columns": {"u": "body1_displacement_x", "F": "body1_reaction force_x"},
    "curves": {"force": {"x": "u", "y": "F"}},
    "answers": {"F": {"curve": "force", "take": "mean", "from": 0.2}, "end": {"curve": "force", "take": "at", "x": 1},
                "excess": {"expression": "F - exact"}, "cuts": {"summary": "cuts"},
                "ratio": {"relative": "F", "run": {"h": 1}}},
    "references": {"F": [{"value": "exact"}]},
    "parts": {"cells": {"grid": {"h": [1, 0.5, 0.25]},
                        "charts": [{"kind": "curves"}, {"kind": "convergence", "over": "h"}, {"kind": "cost"}]},
              "choices": {"one at a time": {"fail": [True], "h": [0.5]}}},
    "quick": {"parameters": {"h": 2}, "expect": {"F": [13, 15]}}}


class StudyCase(unittest.TestCase):
    """Makes folders with a study, a scene and a program."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.write()
        self.program("abc1234")
        version_of.cache_clear()

    def write(self, scene=None, **changes):
        (self.folder / "scene.json").write_text(json.dumps(SCENE | (scene or {})), encoding="utf-8")
        self.path = self.folder / "test.study.json"
        self.path.write_text(json.dumps(STUDY | changes), encoding="utf-8")
        return self.path

    def program(self, commit):
        path = self.folder / "kedge"
        path.write_text(PROGRAM.replace("COMMIT", commit), encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        version_of.cache_clear()

    def study(self, *options):
        """Exit code and what the command prints."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main([str(self.path), "--program", str(self.folder / "kedge"), "--output", str(self.folder / "out"),
                         "--jobs", "2", *options])
        return code, out.getvalue() + err.getvalue()

    def table(self, folder="out"):
        with open(self.folder / folder / "test.csv", newline="", encoding="utf-8") as file:
            return {row["run"]: row for row in csv.DictReader(file)}


class File(StudyCase):
    def test_wrong_keys_are_refused_with_the_nearest(self):
        for changes, message in (({"titel": "x"}, "unknown key \"titel\"; did you mean \"title\""),
                                 ({"answers": {"F": {"curve": "forse", "take": "mean"}}}, "did you mean \"force\""),
                                 ({"answers": {"F": {"curve": "force", "take": "middle"}}}, "answers.F"),
                                 ({"references": {"G": [{"value": 1}]}}, "there is no answer \"G\""),
                                 ({"parts": {"a": {"grid": {"size": [1]}}}}, "there is no parameter \"size\""),
                                 ({"parts": {"a": {"grid": {"h": [1]}, "charts": [{"kind": "over"}]}}}, "over"),
                                 ({"references": {"F": [{"value": "exakt"}]}}, "did you mean exact"),
                                 ({"curves": {"force": {"x": "u", "y": "F * uu"}}}, "curves.force.y"),
                                 ({"command": ["x"]}, "top level"), ({"derived": {"n": "nn"}}, "derived.n"),
                                 ({"answers": {"F": {"curve": "force", "take": "at"}}}, "\"at\" needs \"x\""),
                                 ({"ranks": 0}, "at least 1"), ({"derived": {"u": "1"}}, "derived has that name, too"),
                                 ({"derived": {"step": "1"}, "curves": {"force": {"x": "u", "y": "F * step"}}},
                                  "step is a column of rigid_body.csv and one of derived")):
            with self.subTest(message):
                self.write(**changes)
                code, text = self.study("--estimate")
                self.assertEqual(code, 2, text)
                self.assertIn(message, text)

    def test_columns_that_runs_will_lack_are_refused_before_any_run(self):
        for column in ("body1_reaction force_y", "body2_displacement_x"):
            with self.subTest(column):
                self.write(columns={"u": "body1_displacement_x", "F": column})
                code, text = self.study()
                self.assertEqual(code, 2, text)
                self.assertIn(f"rigid_body.csv has no column \"{column}\"; it has time, body1_position_x", text)
                self.assertFalse(list(self.folder.glob("out/runs/*/output")))

    def test_paths_that_the_scene_lacks_are_refused(self):
        scene = {"a": [{"b": 1}]}
        replace(scene, "a.0.c", 2, "x")
        replace(scene, "a.0.b", None, "x")
        self.assertEqual(scene, {"a": [{"c": 2}]})
        for path in ("b.c", "a.1.c", "a.0.c.d"):
            with self.assertRaisesRegex(StudyError, "the scene has no"):
                replace(scene, path, 1, "set." + path)

    def test_schema_says_what_is_meant(self):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            self.assertEqual(main(["--schema"]), 0)
        self.assertIn("parts", json.loads(out.getvalue())["properties"])


class Cases(StudyCase):
    def test_parts_share_runs(self):
        parts = cases_of(load(self.path), self.folder / "kedge")
        self.assertEqual([case.name for case in parts["cells"]], ["default", "h-0.5", "h-0.25"])
        self.assertEqual([case.name for case in parts["choices"]], ["default", "fail-True", "h-0.5"])
        self.assertIs(parts["cells"][1], parts["choices"][2])
        self.assertEqual(label(load(self.path), parts["cells"][1], parts["cells"]), "cell size 0.5 m")
        self.assertEqual(parts["cells"][1].settings, [("h", 0.5), ("fail", False), ("list.0.deep", [2])])

    def test_long_names_of_equal_runs_have_folders_of_their_own(self):
        label_ = "x" * 70  # of a parameter that no setting uses
        self.write(parameters=STUDY["parameters"] | {label_: {"default": 0}},
                   parts={"a": {"grid": {label_: [1, 2]}}})
        one, two = cases_of(load(self.path), self.folder / "kedge")["a"]
        self.assertEqual(one.input, two.input)
        self.assertNotEqual(one.folder(self.folder, "1"), two.folder(self.folder, "1"))

    def test_hash_knows_all_but_comments(self):
        def first():
            return cases_of(load(self.path), self.folder / "kedge")["cells"][0].input

        before = first()
        self.write({"comment": "other"})
        self.assertEqual(first(), before)
        self.write({"sleep": 0.1})
        self.assertNotEqual(first(), before)
        self.write(set=STUDY["set"] | {"time": 3})
        self.assertNotEqual(first(), before)

    def test_hash_knows_surfaces_of_settings(self):
        self.write(set=STUDY["set"] | {"stl": "a.stl"})
        keys = []
        for content in ("solid a", "solid b"):
            (self.folder / "a.stl").write_text(content, encoding="utf-8")
            keys.append(cases_of(load(self.path), self.folder / "kedge")["cells"][0].input)
        self.assertNotEqual(*keys)

    def test_whole_numbers_are_equal_however_written(self):
        self.write(parts={"a": {"runs": [{"h": 2.0}, {"h": 2}]}})
        self.assertEqual(len(cases_of(load(self.path), self.folder / "kedge")["a"]), 1)


class Runs(StudyCase):
    def test_runs_answers_and_pages(self):
        code, text = self.study()
        self.assertEqual(code, 0, text)
        rows = self.table()
        self.assertEqual(len(rows), 4)
        self.assertAlmostEqual(float(rows["h-0.5"]["F"]), 10.25)
        self.assertAlmostEqual(float(rows["h-0.5"]["excess"]), 0.25)
        self.assertAlmostEqual(float(rows["h-0.5"]["ratio"]), 10.25 / 11., places=5)
        self.assertEqual((rows["h-0.5"]["cuts"], rows["h-0.5"]["commit"]), ("2", "abc1234"))
        page = (self.folder / "out" / "test.md").read_text(encoding="utf-8")
        self.assertIn("order 2, limit 10 ±", page)
        self.assertIn("+2.5", page)
        self.assertIn("data:image/svg", (self.folder / "out" / "test.html").read_text(encoding="utf-8"))
        self.assertTrue((self.folder / "out" / "test-cells.png").is_file())

    def test_a_failure_is_a_result(self):
        self.study()
        row = self.table()["fail-True"]
        self.assertEqual((row["status"], row["message"], row["end"]), ("failed", "kedge: no convergence", ""))
        self.assertAlmostEqual(float(row["reached"]), 0.5)
        self.assertAlmostEqual(float(row["F"]), 11.)  # the mean from 0.2 on, as far as it came
        self.assertIn("**failed** at 0.5", (self.folder / "out" / "test.md").read_text(encoding="utf-8"))

    def test_what_is_there_is_not_repeated(self):
        self.study("--parts", "cells")
        self.assertIn("all 3 runs are there", self.study("--parts", "cells")[1])
        self.assertIn("1 of 4 runs to make", self.study()[1])
        self.assertIn("4 of 4 runs to make", self.study("--again")[1])

    def test_versions_are_not_mixed(self):
        self.study("--parts", "cells", "--keep")
        self.program("def5678")
        self.assertIn("3 of 3 runs to make", self.study("--parts", "cells", "--estimate")[1])
        self.study("--parts", "choices")
        rows = (self.folder / "out" / "runs").glob("*/record.json")
        some = next(path for path in rows if "def5678" in path.read_text(encoding="utf-8"))
        some.write_text(some.read_text(encoding="utf-8").replace("def5678", "other"), encoding="utf-8")
        code, text = self.study("--parts", "choices")
        self.assertEqual(code, 2)
        self.assertIn("several versions of the program (def5678, other); run the study again, or allow it", text)
        self.assertEqual(self.study("--parts", "choices", "--mix")[0], 0)

    def test_programs_can_vary(self):
        (self.folder / "old").write_text(PROGRAM.replace("COMMIT", "old0001"), encoding="utf-8")
        (self.folder / "old").chmod(0o755)
        parameters = STUDY["parameters"] | {"build": {"default": "kedge"}}
        self.write(parameters=parameters, program="= build", parts={"builds": {"grid": {"build": ["kedge", "old"]}}})
        code, text = self.study()
        self.assertEqual(code, 0, text)
        self.assertEqual([row["commit"] for row in self.table().values()], ["abc1234", "old0001"])

    def test_kept_table_draws_without_runs(self):
        self.study("--keep")
        self.assertTrue((self.folder / "test-cells.png").is_file())
        before = self.table("")
        code, text = self.study("--draw", "--work", str(self.folder / "none"))
        self.assertEqual(code, 0, text)
        self.assertEqual(self.table(), before)
        self.write({"sleep": 0.01})
        self.assertEqual(self.study("--draw", "--work", str(self.folder / "none"))[0], 2)  # results of another input

    def test_a_chart_shows_only_the_runs_that_it_names(self):
        def part(only):
            return {"grid": {"h": [2, 1, 0.5]}, "charts": [{"kind": "convergence", "over": "h", "only": only}]}

        for only, has_limit in (("h > 0", True), ("h < 2", False)):  # two sizes have no limit
            self.write(parts={"a": part(only)})
            self.assertEqual(self.study()[0], 0)
            page = (self.folder / "out" / "test.md").read_text(encoding="utf-8")
            self.assertEqual("limit 10" in page, has_limit)
            self.assertTrue((self.folder / "out" / "test-a.png").is_file())
            (self.folder / "out" / "test-a.png").unlink()
        self.write(parts={"a": part("h > 2")})
        self.assertEqual(self.study()[0], 0)
        self.assertFalse((self.folder / "out" / "test-a.png").is_file())
        self.write(parts={"a": part("size < 2")})
        code, text = self.study()
        self.assertEqual((code, "charts[0].only" in text), (2, True), text)

    def test_changes_are_of_the_default_or_of_nothing(self):
        self.study("--parts", "choices")
        study = load(self.path)
        cases = cases_of(study, self.folder / "kedge")["choices"]
        results = list(of_runs(study, cases, self.folder / "out" / "runs").values())
        for shown, label_ in ((results, "% of 11"), (results[1:], "% of none")):
            axes = plt.figure().subplots()
            panels.changes(axes, study, study.parts["choices"], {"kind": "changes", "answer": "F"}, shown)
            self.assertIn(label_, axes.get_xlabel())
            self.assertEqual([text.get_text() for text in axes.get_yticklabels()], ["fail True", "cell size 0.5 m"])
            plt.close(axes.figure)

    def test_pictures_of_equal_names_do_not_overwrite_each_other(self):
        for file in ("one", "two"):
            (self.folder / f"{file}.py").write_text(
                f"def draw(runs, path):\n    path.write_text('{file}')\n", encoding="utf-8")
        self.write(parts={"cells": {"grid": {"h": [1, 0.5]}, "pictures": {"A": "one.py:draw", "B": "two.py:draw"}}})
        code, text = self.study()
        self.assertEqual(code, 0, text)
        drawn = sorted(self.folder.glob("out/*draw*.png"))
        self.assertEqual([path.read_text(encoding="utf-8") for path in drawn], ["two", "one"])

    def test_quick_form_expects(self):
        self.assertEqual(self.study("--quick")[0], 0)
        self.write(quick={"parameters": {"h": 2}, "expect": {"F": [15, 16]}})
        code, text = self.study("--quick")
        self.assertEqual(code, 1)
        self.assertIn("default: F = 14.0 is not in [15, 16]", text)
        self.write(quick={"parameters": {"fail": True}})
        self.assertEqual(self.study("--quick")[0], 1)

    def test_wrong_input_ends_the_study(self):
        self.write({"bad": 1})
        code, text = self.study()
        self.assertEqual(code, 2)
        self.assertIn("bad: unknown key", text)
        self.assertFalse((self.folder / "out" / "test.csv").is_file())

    def test_an_error_leaves_no_run_behind(self):
        self.write({"sleep": 30, "file error": 0.5})
        program = self.folder / "kedge"
        program.write_text(program.read_text(encoding="utf-8").replace(
            'if scene["h"] == scene', 'time.sleep(0.5)\nif scene["h"] == scene'), encoding="utf-8")
        code, text = self.study("--parts", "cells")
        self.assertEqual(code, 2, text)
        started = list(self.folder.glob("out/runs/*/output/started"))
        self.assertGreater(len(started), 1)
        for path in started:
            self.assertFalse(self.still_runs(int(path.read_text(encoding="utf-8"))), path)

    @staticmethod
    def still_runs(pid):
        """Whether a process goes on after a moment to end."""
        for _ in range(100):
            try:
                if os.waitpid(pid, os.WNOHANG)[0]:
                    return False
            except ChildProcessError:
                return False
            time.sleep(0.05)
        return True

    def test_dear_runs_are_left_out(self):
        self.write({"memory": 1e18})
        code, text = self.study()
        self.assertIn("GB of memory", text)
        self.assertEqual(code, 2)
        self.write({"time": 1e5})
        self.assertIn("does not fit into the budget", self.study("--budget", "1 min")[1])

    def test_time_limit_stops_a_run(self):
        program = (self.folder / "kedge").read_text(encoding="utf-8")
        self.write({"sleep": 1}, **{"time limit": "0.3 s"})
        for place in ("time.sleep(scene[\"sleep\"])", "folder ="):  # after and before there is any output
            with self.subTest(place):
                (self.folder / "kedge").write_text(program.replace(place, "while scene['sleep']: pass\n" + place),
                                                   encoding="utf-8")
                self.study("--parts", "cells", "--again")
                self.assertEqual({row["status"] for row in self.table().values()}, {"stopped"})

    def test_an_interrupted_study_goes_on(self):
        self.write({"sleep": 1.5})
        words = [str(PYTHON / "kedge-study"), str(self.path), "--program", str(self.folder / "kedge"), "--output",
                 str(self.folder / "out"), "--jobs", "1", "--parts", "cells"]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        while len(list(self.folder.glob("out/runs/*/output/started"))) < 2 and process.poll() is None:
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        text = process.communicate(timeout=60)[0]
        self.assertEqual(process.returncode, 130, text)
        self.write({"sleep": 1.5})
        code, text = self.study("--parts", "cells")
        self.assertIn("2 of 3 runs to make", text)
        self.assertEqual(code, 0, text)

    def test_commands_instead_of_scenes(self):
        tool = self.folder / "tool"
        tool.write_text("#!/bin/sh\necho 'offset,condition 1' >out.csv; echo 1,$1 >>out.csv; echo 2,5 >>out.csv\n",
                        encoding="utf-8")
        tool.chmod(0o755)
        changes = {"set": {}, "columns": {}, "command": ["tool", "= h"], "curves": {
            "condition": {"table": "out.csv", "x": "offset", "y": "condition_1"}},
            "answers": {"most": {"curve": "condition", "take": "max"}}, "references": {},
            "parts": {"a": {"grid": {"h": [3, 7]}}}, "derived": {}}
        content = STUDY | changes
        del content["scene"]
        self.path.write_text(json.dumps(content), encoding="utf-8")
        code, text = self.study()
        self.assertEqual(code, 0, text)
        self.assertEqual([row["most"] for row in self.table().values()], ["5", "7"])


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "Agg")
    unittest.main()
