#!/usr/bin/python3
"""Tests of the reader of VTK files."""
import unittest

import numpy as np
from synthetic_run import TemporaryFolder, VtuWriter, boxes

from kedge_runs import RunError
from kedge_runs.run import Run
from kedge_runs.vtu import read_grid


class Reader(TemporaryFolder):
    def read_back(self, **encoding):
        points, cells, lower = boxes()
        path = self.folder / "grid.vtu"
        VtuWriter(**encoding).write(path, points, cells, 12, {"corner": lower.astype(np.float32)})
        grid = read_grid(path)
        np.testing.assert_array_equal(grid.points, points)
        np.testing.assert_array_equal(grid.cells(12), cells)
        np.testing.assert_array_equal(grid.cell_data["corner"], lower)

    def test_every_encoding(self):
        self.read_back(form="ascii")
        for form in ("inline", "base64", "raw"):
            for zipped in (False, True):
                for header in ("UInt32", "UInt64"):
                    for order in ("<", ">"):
                        with self.subTest(form=form, zipped=zipped, header=header, order=order):
                            self.read_back(form=form, zipped=zipped, header=header, order=order)

    def test_blocks_that_fill_exactly(self):
        self.read_back(form="raw", zipped=True, block=27 * 12)

    def test_raw_data_that_look_like_markup(self):
        path = self.folder / "grid.vtu"
        tag = np.frombuffer(b"<AppendedData></AppendedData>...", dtype=np.uint8)
        points, cells, _ = boxes(2)
        VtuWriter("raw").write(path, points, cells, 12, {"bytes": tag.reshape(8, 4)})
        self.assertEqual(read_grid(path).cell_data["bytes"].tobytes(), tag.tobytes())

    def test_pieces_are_joined(self):
        points, cells, lower = boxes()
        for i, part in enumerate((slice(0, 10), slice(10, 27))):
            own = cells[part]
            VtuWriter("raw", zipped=True).write(self.folder / f"mps_1_00002_{i}.vtu", points[own.ravel()],
                                                np.arange(own.size).reshape(-1, 8), 12, {"corner": lower[part]})
        (self.folder / "mps_1_00002.pvtu").write_text(
            '<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid><Piece Source="mps_1_00002_0.vtu"/>'
            '<Piece Source="mps_1_00002_1.vtu"/></PUnstructuredGrid></VTKFile>', encoding="utf-8")
        (grid,), step = Run(self.folder).soil()
        self.assertEqual(step, 2)
        np.testing.assert_array_equal(grid.points[grid.cells(12)].min(axis=1), grid.cell_data["corner"])
        self.assertEqual(len(grid.cell_data["corner"]), 27)

    def test_truncated_file_is_named(self):
        points, cells, lower = boxes()
        path = self.folder / "grid.vtu"
        VtuWriter("raw").write(path, points, cells, 12, {"corner": lower})
        path.write_bytes(path.read_bytes()[:-400])
        with self.assertRaisesRegex(RunError, "grid.vtu: damaged"):
            read_grid(path)

    def test_missing_file_is_named(self):
        with self.assertRaisesRegex(RunError, "nowhere.vtu: cannot be read"):
            read_grid(self.folder / "nowhere.vtu")


if __name__ == "__main__":
    unittest.main()
