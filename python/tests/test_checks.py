#!/usr/bin/python3
"""Tests of the checks: each finds its fault, and nothing in a good example."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECKS = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "checks"


class CheckCase(unittest.TestCase):
    """Runs a check on a small repository."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def run_check(self, name, *arguments):
        return subprocess.run([sys.executable, str(CHECKS / name), "--root", str(self.root), *arguments],
                              capture_output=True, text=True, check=False)

    def assert_finds(self, name, *parts):
        result = self.run_check(name)
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        for part in parts:
            self.assertIn(part, result.stdout)

    def assert_passes(self, name, *arguments):
        result = self.run_check(name, *arguments)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


class Help(CheckCase):
    def test_every_check_explains_itself(self):
        for path in CHECKS.glob("check-*"):
            with self.subTest(path.name):
                result = self.run_check(path.name, "--help")
                self.assertEqual(result.returncode, 0)
                self.assertIn("Checks ", result.stdout)


class Format(CheckCase):
    def setUp(self):
        super().setUp()
        self.write(".clang-format", "BasedOnStyle: LLVM\n")
        result = self.run_check("check-format")
        if result.returncode == 77:
            self.skipTest(result.stdout)

    def test_accepts_good_layout(self):
        self.write("source/a.cc", "int main() { return 0; }\n")
        self.assert_passes("check-format")

    def test_finds_bad_layout(self):
        self.write("source/a.cc", "int   main(){return 0;}\n")
        self.assert_finds("check-format", "source/a.cc:1:")

    def test_fix_corrects_it(self):
        self.write("include/a.h", "int   f(  );\n")
        self.assert_passes("check-format", "--fix")
        self.assertEqual((self.root / "include/a.h").read_text(encoding="utf-8"), "int f();\n")


class Floors(CheckCase):
    def setUp(self):
        super().setUp()
        self.write("CMakeLists.txt", "kedge_room(base LINKS fmt::fmt)\n"
                   "kedge_room(mesh ROOMS base LINKS deal.II)  # not kedge_room(attic)\n"
                   "kedge_room(bodies ROOMS base)\n"
                   "kedge_room(\n  contact\n  ROOMS base mesh\n  HEADERS_OF bodies\n  PRIVATE_LINKS output)\n")

    def test_accepts_named_rooms_and_the_own_room(self):
        self.write("source/contact/a.cc", "#include \"b.h\"\n#include <kedge/contact/b.h>\n#include <kedge/mesh/c.h>\n"
                   "#include <kedge/bodies/d.h>\n")
        self.write("source/main.cc", "#include <kedge/contact/a.h>\n")
        self.assert_passes("check-floors")

    def test_finds_rooms_that_are_not_named(self):
        self.write("include/kedge/mesh/a.h", "#pragma once\n#  include <kedge/bodies/b.h>\n")
        self.assert_finds("check-floors", "include/kedge/mesh/a.h:2: mesh includes <kedge/bodies/b.h>, "
                          "but kedge_room(mesh ...) in CMakeLists.txt does not name bodies")

    def test_finds_rooms_that_are_not_declared(self):
        self.write("source/attic/a.cc", "\n")
        self.write("source/mesh/a.cc", "#include <kedge/attic/b.h>\n")
        self.assert_finds("check-floors", "the room attic is not declared", "<kedge/attic/b.h> is in no known room")

    def test_finds_lists_that_name_no_room(self):
        self.write("CMakeLists.txt", "kedge_room(base ROOMS attic)\n")
        self.assert_finds("check-floors", "kedge_room(base ...) names attic, which is no room")

    def test_finds_rooms_that_include_each_other(self):
        self.write("CMakeLists.txt", "kedge_room(base)\nkedge_room(mesh ROOMS base bodies)\n"
                   "kedge_room(bodies ROOMS contact)\nkedge_room(contact ROOMS mesh)\n")
        self.assert_finds("check-floors", "these rooms include each other: bodies, contact, mesh")

    def test_finds_relative_paths_into_other_rooms(self):
        self.write("source/base/a.cc", "#include \"../output/b.h\"\n")
        self.assert_finds("check-floors", "leaves its folder")


class Core(CheckCase):
    def test_accepts_deal_ii_outside_the_core(self):
        self.write("source/mesh/a.cc", "#include <deal.II/grid/tria.h>\n")
        self.write("source/assembly/a.cc", "#include <kedge/base/b.h>\n#include <Kokkos_Core.hpp>\n")
        self.write("include/kedge/base/b.h", "#include <vector>\n")
        self.write("source/solvers/linear_solver.cc", "#include <BelosLinearProblem.hpp>\n")
        self.write("source/solvers/multigrid.cc", "#include <MueLu_Hierarchy.hpp>\n")
        self.assert_passes("check-core")

    def test_finds_deal_ii_in_the_core(self):
        for name in ("include/kedge/base/kokkos.h", "include/kedge/contact_forces/coulomb.h", "source/solvers/a.cc",
                     "include/kedge/materials/a.h", "source/assembly/a.cc"):
            with self.subTest(name):
                self.write(name, "#include <deal.II/base/point.h>\n")
                self.assert_finds("check-core", f"{name}:1: the core reaches deal.II/base/point.h")
                (self.root / name).unlink()

    def test_finds_deal_ii_behind_other_headers(self):
        self.write("source/assembly/a.cc", "#include \"local.h\"\n")
        self.write("source/assembly/local.h", "#include <kedge/basis/b.h>\n")
        self.write("include/kedge/basis/b.h", "#include <kedge/mesh/c.h>\n")
        self.write("include/kedge/mesh/c.h", "\n#include <deal.II/grid/tria.h>\n")
        self.assert_finds("check-core", "source/assembly/a.cc:1: the core reaches deal.II/grid/tria.h, "
                          "through source/assembly/local.h:1, through include/kedge/basis/b.h:1, "
                          "through include/kedge/mesh/c.h:2")

    def test_headers_that_include_each_other_come_to_an_end(self):
        self.write("include/kedge/materials/a.h", "#include <kedge/materials/b.h>\n")
        self.write("include/kedge/materials/b.h", "#include <kedge/materials/a.h>\n")
        self.assert_passes("check-core")

    def test_finds_solver_libraries_outside_the_linear_solver(self):
        self.write("include/kedge/solvers/linear_solver.h", "#include <BelosLinearProblem.hpp>\n")
        self.write("source/simulation/a.cc", "#include <MueLu.hpp>\n")
        self.assert_finds("check-core", "<BelosLinearProblem.hpp>", "<MueLu.hpp>")


class Lengths(CheckCase):
    def test_counts_lines_of_sources_and_scripts_only(self):
        self.write("source/a.cc", 400 * "\n")
        self.write("doc/a.md", 1000 * "\n")
        self.write("LICENSE", 1000 * "\n")
        self.assert_passes("check-lengths")

    def test_finds_long_files(self):
        self.write("source/a.cc", 401 * "\n")
        self.write("scripts/a", "#!/bin/bash\n" + 500 * "\n")
        self.assert_finds("check-lengths", "source/a.cc: 401 lines", "scripts/a: 501 lines")

    def test_counts_characters_not_bytes(self):
        self.write("a.py", f"# {118 * 'β'}\n")
        self.assert_passes("check-lengths")

    def test_finds_wide_lines(self):
        wide = 30 * "word "
        for name in ("a.py", "CMakeLists.txt", "a.cmake", "a.md", "b"):
            with self.subTest(name):
                self.write(name, f"#!/bin/sh\n# {wide}\n")
                self.assert_finds("check-lengths", f"{name}:2: 152 characters; break the line")
                (self.root / name).unlink()

    def test_leaves_wide_lines_of_other_files_alone(self):
        for name in ("a.cc", "a.json", "LICENSE"):
            self.write(name, 200 * "word ")
        self.assert_passes("check-lengths")

    def test_accepts_wide_lines_of_markdown_that_cannot_be_broken(self):
        word, words = 130 * "x", 30 * "word "
        self.write("a.md", f"| {words} |\n- [{words}]({word})\n![{words}](a.png)\nhttps://{word}\n"
                   f"```sh\n{words}\n```\n")
        self.assert_passes("check-lengths")

    def test_finds_wide_text_of_markdown_beside_links_and_code(self):
        words = 30 * "word "
        self.write("a.md", f"see [{words}](a.png)\n```sh\n```\n{words}\n")
        self.assert_finds("check-lengths", "a.md:1:", "a.md:4:", "2 findings")


if __name__ == "__main__":
    unittest.main()
