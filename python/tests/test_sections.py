#!/usr/bin/python3
"""Tests of sections through the soil on small synthetic runs."""
import json
import pathlib
import tempfile
import unittest
from unittest import mock

import numpy as np
from synthetic_run import TemporaryFolder, VtuWriter, boxes, write_run

from kedge_plot import OptionError, PlotError
from kedge_plot.fields import evaluate
from kedge_plot.figures import add_soil, draw_section, plt, unit_of
from kedge_plot.command import moment
from kedge_plot.filling import triangles_between
from kedge_plot.section import cut
from kedge_runs.run import Run

ROOT = pathlib.Path(__file__).resolve().parents[2]


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
        grid = np.stack(np.meshgrid(np.arange(6.), np.arange(6.)), axis=-1).reshape(-1, 2)
        for missing, lost in ((1, 0.), (2, 9. - 4 * 0.5)):  # a larger void keeps only its cut corners
            hole = ((grid >= 2.) & (grid < 2. + missing)).all(axis=1)
            self.assertAlmostEqual(area(grid[~hole]), 25. - lost)
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

    def write_plane_strain(self):
        points = [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]
        VtuWriter("ascii").write(self.folder / "mps_1_00002.vtu", points, [[0, 1, 2, 3]], 9, {"volume": np.ones(1)})
        VtuWriter("ascii").write(self.folder / "surface_00002.vtu", points[:2], [[0, 1]], 3, {})

    def test_plane_strain_quadrilaterals_need_no_cut(self):
        self.write_plane_strain()
        run = Run(self.folder)
        section = cut(run.soil()[0], run.surface(2), "y", 0., "volume")
        self.assertEqual((len(section.values), section.outline.shape), (1, (1, 2, 2)))
        self.assertTrue(section.is_flat)
        self.assertFalse(self.cut().is_flat)

    def test_plane_strain_has_one_plane(self):
        self.write_plane_strain()
        for options in (("--plane", "z"), ("--at", "3")):
            with self.subTest(options):
                code, _, error = self.run_command(*options)
                self.assertEqual(code, 2)
                self.assertIn("a run in plane strain lies in the plane y = 0", error)
        with self.assertRaises(OptionError):
            cut(Run(self.folder).soil()[0], None, "x", 0., "volume")

    def test_titles_name_stage_and_time(self):
        write_run(self.folder, step=3)
        (self.folder / "vtk" / "mps_1.pvd").write_text('<DataSet timestep="1.25" part="0" file="mps_1_00003.vtu"/>',
                                                       encoding="utf-8")
        run = Run(self.folder)
        self.assertEqual(moment(run, 3), "Step 3")
        for kind, text in (("static", "Step 3, stage 1, load 1.25"), ("dynamic", "Step 3, stage 1, 1.25 s")):
            summary = {"stages": [{"steps": 2, "type": kind}]}
            (self.folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
            self.assertEqual(moment(Run(self.folder), 3), text)

    def test_soil_without_a_value_is_grey(self):
        section = self.cut()
        section.values[0] = np.nan
        axes = plt.figure().subplots()
        soil = add_soil(axes, section, 1., blocks=True)
        axes.figure.canvas.draw()
        np.testing.assert_allclose(soil.get_facecolors()[0], [0.8, 0.8, 0.8, 1.])
        self.assertGreater(np.ptp(soil.get_facecolors()[1, :3]), 0.1)
        plt.close(axes.figure)

    def test_the_label_of_the_colours_is_inside_the_figure(self):
        for window in ((-9., 12., 0., 3.), (0., 3., 0., 3.)):
            with self.subTest(window), mock.patch.object(plt, "close"):
                draw_section(self.cut(), self.folder / "a.png", "displacement magnitude", window=window)
                figure = plt.gcf()
                figure.canvas.draw()
                bar = figure.axes[1]
                label = bar.xaxis.label if bar.get_xlabel() else bar.yaxis.label
                self.assertEqual(label.get_text(), "Displacement magnitude [mm]")
                low, high = figure.dpi * figure.get_tightbbox().get_points()
                extent = label.get_window_extent()
                self.assertTrue((extent.min >= low).all() and (extent.max <= high).all(), extent)
            plt.close("all")

    def test_units_are_those_of_the_manual(self):
        text = (ROOT / "doc" / "parameters.md").read_text(encoding="utf-8").partition("## Fields of material points")[2]
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if "`" in line]
        units = {name.strip("`"): unit for *_, name, unit, _ in
                 (row if row[1].startswith("`") else [row[0], *row[2:]] for row in rows if len(row) == 4)}
        self.assertGreater(len(units), 15)
        scaled = {"kPa": ("Pa", 1e-3), "MPa": ("Pa", 1e-6), "mm": ("m", 1e3), "": ("-", 1.)}
        for field, unit in units.items():
            drawn, factor = unit_of(field)
            known = scaled.get(drawn, (drawn.replace("²", "2").replace("³", "3"), 1.))
            self.assertEqual(known, (unit, factor), field)
        self.assertEqual(unit_of("initial volume", is_flat=True), ("m²", 1.))

    def test_fields(self):
        data = {"stress": np.array([[-1., -2., -6., 0., 2., 0.]]), "velocity": np.array([[3., 0., 4.]])}
        self.assertEqual(evaluate(data, "stress_zz"), -6.)
        self.assertEqual(evaluate(data, "mean stress"), -3.)
        self.assertAlmostEqual(evaluate(data, "deviatoric stress")[0], np.sqrt(1.5 * (4. + 1. + 9.) + 3. * 4.))
        self.assertEqual(evaluate(data, "velocity magnitude"), 5.)
        with self.assertRaisesRegex(PlotError, "there are: stress_xx.*velocity_z, mean stress"):
            evaluate(data, "temperature")


if __name__ == "__main__":
    unittest.main()
