#!/usr/bin/python3
"""Tests of what kedge-study says of missing files, missing answers and mixed versions."""
import json
import unittest
import warnings

from test_kedge_study import STUDY, StudyCase

from kedge_study.records import version_of


class Messages(StudyCase):
    def test_missing_files_are_named(self):
        self.write().write_text(json.dumps(STUDY | {"scene": "nowhere.json"}), encoding="utf-8")
        self.assertRegex(self.study()[1], r"nowhere\.json: cannot be read \(No such file or directory\)\n$")
        self.write(answers={"f": {"function": "nowhere.py:f"}}, references={})
        self.assertRegex(self.study()[1], r"answers\.f\.function: nowhere\.py:f: No such file or directory\n$")
        self.write()
        (self.folder / "kedge").unlink()
        version_of.cache_clear()
        self.assertRegex(self.study()[1], r"kedge: cannot be started \(No such file or directory\); scripts/build")

    def test_answers_that_do_not_exist_say_why(self):
        answers = {"far": {"curve": "force", "take": "max", "from": 2, "to": 3}, "whole": {"expression": "F / 0"},
                   "never": {"curve": "force", "take": "at", "x": 7}, "over": {"curve": "none", "take": "max"}}
        self.write(answers=STUDY["answers"] | answers, curves=STUDY["curves"] | {"none": {"x": "u", "y": "F / 0"}})
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            code, text = self.study("--parts", "choices")
        self.assertEqual(code, 0, text)
        for line in ("default: the curve none has no finite value", "default: no over: it is infinite",
                     "no far of the curve force: there is none from 2 to 3; x lies between 0.1 and 1",
                     "no never of the curve force: there is none at 7; x lies"):
            self.assertIn(line, text)
            self.assertIn(line, (self.folder / "out" / "test.md").read_text(encoding="utf-8"))
        self.assertNotIn("fail-True: no far", text)  # it did not come so far

    def test_drawing_alone_mixes_versions_and_says_so(self):
        self.study("--parts", "cells", "--keep")
        self.program("def5678")
        self.study("--parts", "choices")
        code, text = self.study("--draw")
        self.assertEqual(code, 0, text)
        self.assertIn("test: the results come from several versions of the program (abc1234, def5678)\n", text)
        self.assertEqual({row["commit"] for row in self.table().values()}, {"abc1234", "def5678"})
        self.assertIn("(mixed)", (self.folder / "out" / "test.md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
