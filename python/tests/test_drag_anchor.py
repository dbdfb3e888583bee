"""The drag-anchor benchmark: its tables hold what its charts need."""
import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "benchmarks" / "drag-anchor"), str(ROOT / "python")]

import charts  # noqa: E402
from trajectory import COLUMNS, Curves, read_kept  # noqa: E402


class Ramp(Curves):
    """A drag of 1 m in which everything grows in its own proportion to the distance."""
    record = {"dragged / m": "1.00", "finished": "True"}

    def __init__(self):
        self.distance = np.linspace(0., 1., 201)
        for factor, name in enumerate(COLUMNS.values(), start=1):
            setattr(self, name, factor * self.distance)


class Kept(unittest.TestCase):
    def test_curves_and_table_come_back_as_written(self):
        with tempfile.TemporaryDirectory() as folder:
            curves, table = pathlib.Path(folder) / "curves.csv", pathlib.Path(folder) / "table.csv"
            charts.write_curves({"coarse": Ramp(), "fine": Ramp()}, curves)
            charts.write_table({"coarse": Ramp(), "fine": Ramp()}, table)
            kept = read_kept(curves, table)
            self.assertEqual(list(kept), ["coarse", "fine"])
            self.assertEqual(kept["fine"].record["dragged / m"], "1.00")
            self.assertAlmostEqual(kept["fine"].distance[-1], 1., places=6)
            for factor, name in enumerate(COLUMNS.values(), start=1):
                self.assertAlmostEqual(kept["coarse"].at(getattr(kept["coarse"], name), 0.5), 0.5 * factor, places=4)
            before = curves.read_text(encoding="utf-8"), table.read_text(encoding="utf-8")
            charts.write_curves(kept, curves)
            charts.write_table(kept, table)
            self.assertEqual((curves.read_text(encoding="utf-8"), table.read_text(encoding="utf-8")), before)

    def test_no_tables_no_runs(self):
        self.assertEqual(read_kept(pathlib.Path("missing.csv"), pathlib.Path("missing.csv")), {})


if __name__ == "__main__":
    unittest.main()
