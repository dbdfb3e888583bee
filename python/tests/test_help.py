#!/usr/bin/python3
"""Every program explains itself: --help works, so its imports do, too."""
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Help(unittest.TestCase):
    def test_every_program_explains_itself(self):
        programs = [*ROOT.glob("scripts/*"), *ROOT.glob("python/kedge-*"), ROOT / "tests/scenes/run-scene"]
        for program in filter(pathlib.Path.is_file, programs):
            with self.subTest(program.relative_to(ROOT)):
                result = subprocess.run([program, "--help"], capture_output=True, text=True, check=False)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertIn("usage: ", result.stdout.lower())


if __name__ == "__main__":
    unittest.main()
