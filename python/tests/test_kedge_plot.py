#!/usr/bin/python3
"""Tests of kedge-plot on small synthetic runs."""
import base64
import contextlib
import io
import json
import pathlib
import struct
import sys
import tempfile
import unittest
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from kedge_plot import PlotError  # noqa: E402
from kedge_plot.command import main  # noqa: E402
from kedge_plot.filling import triangles_between  # noqa: E402
from kedge_plot.resistance import fit_hyperbola, resistance_curve  # noqa: E402
from kedge_plot.section import cut, evaluate  # noqa: E402
from kedge_runs import RunError  # noqa: E402
from kedge_runs.run import Run  # noqa: E402
from kedge_runs.vtu import read_grid  # noqa: E402

_NAMES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}


class VtuWriter:
    """Writes a grid in any of VTK's encodings."""

    def __init__(self, form, zipped=False, header="UInt32", order="<", block=64):
        self.form, self.zipped, self.header, self.order, self.block = form, zipped, header, order, block
        self.appended = b""

    def encoded(self, values):
        """Header and data in VTK's layout, in base64 unless raw."""
        word = self.order + ("Q" if self.header == "UInt64" else "I")
        data = values.astype(values.dtype.newbyteorder(self.order)).tobytes()
        if not self.zipped:
            parts = [struct.pack(word, len(data)) + data]
        else:
            blocks = [data[i:i + self.block] for i in range(0, len(data), self.block)]
            rest = len(data) % self.block
            packed = [zlib.compress(block) for block in blocks]
            head = [len(blocks), self.block, rest] + [len(block) for block in packed]
            parts = [b"".join(struct.pack(word, number) for number in head), b"".join(packed)]
        return b"".join(parts if self.form == "raw" else map(base64.b64encode, parts))

    def array(self, name, values):
        values = np.ascontiguousarray(values)
        tag = (f'<DataArray type="{_NAMES[values.dtype.str[1:]]}" Name="{name}" '
               f'NumberOfComponents="{values.shape[1] if values.ndim > 1 else 1}" ').encode()
        if self.form == "ascii":
            return tag + b'format="ascii">' + " ".join(map(str, values.ravel())).encode() + b"</DataArray>"
        if self.form == "inline":
            return tag + b'format="binary">\n' + self.encoded(values) + b"\n</DataArray>"
        offset = len(self.appended)
        self.appended += self.encoded(values)
        return tag + f'format="appended" offset="{offset}"/>'.encode()

    def write(self, path, points, cells, cell_type, cell_data):
        cells = np.asarray(cells, dtype=np.int32)
        body = (f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}"><Points>'.encode() +
                self.array("Points", np.asarray(points, dtype=float)) + b"</Points><Cells>" +
                self.array("connectivity", cells.ravel()) +
                self.array("offsets", np.arange(1, len(cells) + 1, dtype=np.int32) * cells.shape[1]) +
                self.array("types", np.full(len(cells), cell_type, dtype=np.uint8)) + b"</Cells><CellData>" +
                b"".join(self.array(name, values) for name, values in cell_data.items()) + b"</CellData></Piece>")
        order = "LittleEndian" if self.order == "<" else "BigEndian"
        zipped = ' compressor="vtkZLibDataCompressor"' if self.zipped else ""
        tail = b""
        if self.appended:
            encoding = "raw" if self.form == "raw" else "base64"
            tail = f'<AppendedData encoding="{encoding}">\n_'.encode() + self.appended + b"\n</AppendedData>"
        path.write_bytes(f'<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="{order}" '
                         f'header_type="{self.header}"{zipped}><UnstructuredGrid>'.encode() + body +
                         b"</UnstructuredGrid>" + tail + b"</VTKFile>")


def boxes(n=3):
    """A block of n^3 boxes of side 1 from the origin: points, cells and their lower corners."""
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    lower = np.stack(np.meshgrid(*3 * [np.arange(n)], indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    return (lower[:, None] + corner).reshape(-1, 3), np.arange(8 * len(lower)).reshape(-1, 8), lower


def cube(lower, upper):
    """Points and triangles of a closed box."""
    points = [[(lower, upper)[v >> d & 1][d] for d in range(3)] for v in range(8)]
    return points, [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
                    [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]


def write_run(folder, step=12, writer=None):
    """A run with a block of soil, a body in it and its history."""
    (folder / "vtk").mkdir()
    (folder / "csv").mkdir()
    points, cells, lower = boxes()
    stress = np.zeros((len(lower), 6), dtype=np.float32)
    stress[:, 0] = -1000. * lower[:, 0]
    writer = writer or VtuWriter("raw", zipped=True, header="UInt64")
    writer.write(folder / "vtk" / f"mps_1_{step:05d}.vtu", points, cells, 12,
                 {"displacement": lower.astype(np.float32), "stress": stress})
    VtuWriter("inline").write(folder / "vtk" / f"surface_{step:05d}.vtu", *cube((1., 1., 1.), (2., 2., 2.)), 5,
                              {"body": np.ones(12, dtype=np.int32)})
    d = np.linspace(0., 0.05, 60)
    rows = ["time,body1_position_x,body1_position_y,body1_position_z,body1_reaction force_x,body1_reaction force_y,"
            "body1_reaction force_z,stage,step"]
    rows += [f"{x},{3. - x},0,0,{-x / (1e-5 + x / 500.)},0,0,1,{i}" for i, x in enumerate(d)]
    (folder / "csv" / "rigid_body.csv").write_text("\n".join(rows) + "\n0.1,2.9", encoding="utf-8")  # cut off
    (folder / "summary.json").write_text(json.dumps({"version": "0.1.0", "input": "/tmp/pull.json"}), encoding="utf-8")


class TemporaryFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_command(self, *arguments):
        """Exit code, standard output and standard error."""
        out, error = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            code = main([str(self.folder), *arguments])
        return code, out.getvalue(), error.getvalue()


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
    def columns(self, **changes):
        columns = {f"body1_{field}_{axis}": np.zeros(4) for field in ("position", "reaction force") for axis in "xyz"}
        columns.update(time=np.arange(4.), stage=np.array([1., 1., 2., 2.]))
        columns.update(changes)
        return columns

    def test_axis_is_that_of_the_motion_and_signs_follow_it(self):
        curve = resistance_curve(self.columns(**{"body1_position_z": np.array([5., 4., 3., 2.]),
                                                 "body1_reaction force_z": np.array([0., -1., -2., -3.])}))
        self.assertEqual(curve.axis, "z")
        np.testing.assert_array_equal(curve.displacement, [0., 1., 2., 3.])
        np.testing.assert_array_equal(curve.force, [0., 1., 2., 3.])

    def test_stage_counts_from_the_end_of_the_one_before(self):
        columns = self.columns(**{"body1_position_x": np.array([0., 1., 2., 4.])})
        np.testing.assert_array_equal(resistance_curve(columns, stage=2).displacement, [1., 3.])

    def test_half_model_and_zero(self):
        columns = self.columns(**{"body1_position_x": np.arange(4.), "body1_reaction force_x": 5. + np.arange(4.)})
        curve = resistance_curve(columns, factor=2., zero=True)
        np.testing.assert_array_equal(curve.force, [0., 2., 4., 6.])

    def test_displacement_counts_from_the_start(self):
        columns = self.columns(body1_position_x=np.array([1., 2., 3., 5.]))
        curve = resistance_curve(columns, axis="x", start=[0.5, 0., 0.])
        np.testing.assert_array_equal(curve.displacement, [0.5, 1.5, 2.5, 4.5])

    def test_missing_body_is_named(self):
        with self.assertRaisesRegex(PlotError, "body2_position_x.*bodies in it: body1"):
            resistance_curve(self.columns(), body=2)

    def test_missing_stage_is_named(self):
        with self.assertRaisesRegex(PlotError, "no rows of stage 3"):
            resistance_curve(self.columns(), stage=3)

    def test_row_cut_off_while_written_is_left_out(self):
        write_run(self.folder)
        self.assertEqual(len(Run(self.folder).body("time")), 60)


class SectionCut(TemporaryFolder):
    def cut(self, plane="y", at=1.5, field="displacement_x", mesh=False):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        write_run(folder)
        run = Run(folder)
        grids, step = run.soil()
        if mesh:
            VtuWriter("ascii").write(folder / "vtk" / f"mesh_{step:05d}.vtu", *boxes(2)[:2], 12, {})
        return cut(grids, run.surface(step), plane, at, field, run.mesh(step) if mesh else None)

    def test_boxes_in_the_plane_are_found_once(self):
        for at in (0., 1., 1.5, 3.):  # the lower end, between two layers, inside one, the upper end
            with self.subTest(at=at):
                section = self.cut(at=at)
                self.assertEqual(len(section.values), 9)
                self.assertEqual(section.areas().sum(), 9.)

    def test_boxes_beside_the_plane_are_behind_it_the_nearest_last(self):
        # a plane near the upper face of a layer counts as one in the next layer
        for at, behind in ((1.4, {0., 2.}), (1.8, {0., 1.})):
            with self.subTest(at=at):
                backdrop = self.cut(at=at, field="displacement_y").backdrop
                self.assertEqual((len(backdrop.values), set(backdrop.values)), (18, behind))
        self.assertEqual((backdrop.values[0], backdrop.values[-1]), (0., 1.))

    def test_cracks_between_boxes_are_filled_but_neither_voids_nor_bodies(self):
        def area(lower, outline=()):
            lower = np.array(lower, dtype=float)
            triangles = triangles_between(lower, lower + 1., np.array(outline).reshape(-1, 2, 2))
            corners = (lower + 0.5)[triangles.triangles[~triangles.mask]]
            sides = corners[:, 1:] - corners[:, :1]
            return abs(np.linalg.det(sides)).sum() / 2.

        pair = [[0., 0.], [0., 1.]]
        self.assertAlmostEqual(area([*pair, [1.4, 0.], [1.4, 1.]]), 1.4)
        self.assertAlmostEqual(area([*pair, [3.4, 0.], [3.4, 1.]]), 0.)
        wall = [[1.2, -5.], [1.2, 5.]]
        self.assertAlmostEqual(area([*pair, [1.4, 0.], [1.4, 1.]], wall), 0.)
        self.assertAlmostEqual(area([*pair, [1.4, 0.], [1.4, 1.]], [[1.2, 5.], [1.2, 9.]]), 1.4)
        row = np.array([[0., 0.], [1., 0.], [2., 0.]])
        self.assertIsNone(triangles_between(row, row + 1., np.empty((0, 2, 2))))

    def test_values_and_axes_belong_to_the_boxes(self):
        section = self.cut()
        self.assertEqual(section.axes, "xz")
        np.testing.assert_array_equal(section.values, section.lower[:, 0])

    def test_outline_surrounds_the_body(self):
        section = self.cut()
        ends = section.outline.reshape(-1, 2)
        np.testing.assert_allclose([ends.min(axis=0), ends.max(axis=0)], [[1., 1.], [2., 2.]], atol=1e-12)
        lengths = np.linalg.norm(section.outline[:, 0] - section.outline[:, 1], axis=1)
        self.assertAlmostEqual(lengths.sum(), 4.)

    def test_plane_outside_the_soil_says_where_the_soil_is(self):
        with self.assertRaisesRegex(PlotError, "lies between 0 and 3 m"):
            self.cut(at=7.)

    def test_mesh_is_cut_on_request(self):
        self.assertEqual(len(self.cut().cells), 0)
        section = self.cut(mesh=True)
        self.assertEqual(section.cells.shape, (4, 2, 2))
        np.testing.assert_array_equal(section.cells.max(axis=(0, 1)), [2., 2.])

    def test_plane_strain_quadrilaterals_need_no_cut(self):
        points = [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]
        VtuWriter("ascii").write(self.folder / "mps_1_00002.vtu", points, [[0, 1, 2, 3]], 9, {"volume": np.ones(1)})
        VtuWriter("ascii").write(self.folder / "surface_00002.vtu", points[:2], [[0, 1]], 3, {})
        run = Run(self.folder)
        section = cut(run.soil()[0], run.surface(2), "y", 0., "volume")
        self.assertEqual((len(section.values), section.outline.shape), (1, (1, 2, 2)))

    def test_fields(self):
        data = {"stress": np.array([[-1., -2., -6., 0., 2., 0.]]), "velocity": np.array([[3., 0., 4.]])}
        self.assertEqual(evaluate(data, "stress_zz"), -6.)
        self.assertEqual(evaluate(data, "mean stress"), -3.)
        self.assertAlmostEqual(evaluate(data, "deviatoric stress")[0], np.sqrt(1.5 * (4. + 1. + 9.) + 3. * 4.))
        self.assertEqual(evaluate(data, "velocity magnitude"), 5.)
        with self.assertRaisesRegex(PlotError, "there are: stress_xx.*velocity_z, mean stress"):
            evaluate(data, "temperature")


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
