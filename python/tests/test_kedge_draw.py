#!/usr/bin/python3
"""Tests of kedge-draw: both kinds of STL, and what it says of other files."""
import pathlib
import struct
import subprocess
import tempfile
import unittest

PROGRAM = pathlib.Path(__file__).resolve().parents[1] / "kedge-draw"
CORNERS = (0., 0., 0.), (1., 0., 0.), (0., 1., 0.)
FACET = "facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS) + \
    "endloop\nendfacet\n"


class Draw(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def draw(self, content, picture="a.png"):
        """Exit code and error of drawing a file with this content; None: there is no file."""
        if content is not None:
            (self.folder / "a.stl").write_bytes(content)
        words = [PROGRAM, self.folder / "a.stl", "--output", self.folder / picture]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    def test_binary_and_ascii_surfaces_look_alike(self):
        ascii_, pictures = f"solid a\n{FACET}endsolid a\n".encode(), []
        numbers = [0., 0., 1., *(number for corner in CORNERS for number in corner)]
        binary = b"solid".ljust(80) + struct.pack("<I12fH", 1, *numbers, 0)  # its header may say so, too
        for content in (ascii_, binary):
            self.assertEqual(self.draw(content), (0, ""))
            pictures.append((self.folder / "a.png").read_bytes())
        self.assertEqual(*pictures)

    def test_other_files_are_refused_in_words(self):
        for content, message in ((None, "a.stl: cannot be read (No such file or directory)"),
                                 (b"", "a.stl: not an STL, or cut off"),
                                 (b"solid a\nendsolid a\n", "a.stl: holds no triangles"),
                                 (FACET.encode(), "a.stl: not an STL, or cut off"),
                                 (f"solid a\n{FACET}facet\nvertex 1 2 3\n".encode(), "a.stl: not an STL, or cut off"),
                                 (f"solid a\n{FACET.replace('1.0', 'x')}".encode(), "a.stl: not an STL (")):
            with self.subTest(message):
                code, error = self.draw(content)
                self.assertEqual(code, 4)
                self.assertTrue(error.startswith("kedge-draw: "), error)
                self.assertIn(message, error)

    def test_pictures_that_cannot_be_written_are_named(self):
        content = f"solid a\n{FACET}endsolid a\n".encode()
        self.assertIn("none/a.png: cannot be written (No such file", self.draw(content, "none/a.png")[1])
        self.assertIn("a.foo: no format of pictures has this ending", self.draw(content, "a.foo")[1])


if __name__ == "__main__":
    unittest.main()
