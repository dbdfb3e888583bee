#!/usr/bin/python3
"""Tests of sections through the soil on small synthetic runs."""
import pathlib
import tempfile
import unittest

import numpy as np
from synthetic_run import TemporaryFolder, VtuWriter, boxes, write_run

from kedge_plot import PlotError
from kedge_plot.fields import evaluate
from kedge_plot.filling import triangles_between
from kedge_plot.section import cut
from kedge_runs.run import Run


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


if __name__ == "__main__":
    unittest.main()
