#!/usr/bin/python3
"""Tests of the values between material points and of how a section draws them."""
import types
import unittest

import numpy as np
from synthetic_run import TemporaryFolder

from kedge_plot.figures import add_soil, plt
from kedge_plot.filling import crossing
from kedge_plot.smoothing import edge_places, edge_values, interpolate

_NOTHING = np.empty((0, 2, 2))


def squares(corners, side=1.):
    """Lower and upper corners of squares."""
    lower = np.array(corners, dtype=float).reshape(-1, 2)
    return lower, lower + side


def block(n):
    """Lower and upper corners of n x n squares of side 1 from the origin."""
    return squares(np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=-1))


class Interpolation(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(2)
        self.points = self.random.random((300, 3))

    def test_linear_fields_are_exact_inside_and_beyond(self):
        slope, places = self.random.normal(size=(3, 4)), 1.2 * self.random.random((50, 3)) - 0.1
        found = interpolate(places, self.points, 3. + self.points @ slope)
        np.testing.assert_allclose(found, 3. + places @ slope, atol=1e-7)

    def test_values_come_back_at_the_points(self):
        values = self.random.normal(size=(300, 2))
        np.testing.assert_allclose(interpolate(self.points, self.points, values), values, atol=1e-6)

    def test_error_in_curved_fields_falls_with_the_square_of_the_spacing(self):
        places, errors = 0.25 + 0.5 * self.random.random((400, 3)), []
        for count in (1000, 8000):
            points = self.random.random((count, 3))
            found = interpolate(places, points, np.sin(3. * points[:, :1]))
            errors.append(abs(found - np.sin(3. * places[:, :1])).mean())
        self.assertAlmostEqual(errors[0] / errors[1], 4., delta=1.)

    def test_points_in_a_plane_and_few_points(self):
        self.points[:, 1] = 0.
        places = self.points[:20] + [0.01, 0., 0.02]
        values = 2. * self.points[:, :1] - self.points[:, 2:]
        np.testing.assert_allclose(interpolate(places, self.points, values), 2. * places[:, :1] - places[:, 2:],
                                   atol=1e-6)
        np.testing.assert_allclose(interpolate(places, self.points[:1], values[:1]), values[0, 0] * np.ones((20, 1)))


class EdgeValues(unittest.TestCase):
    def test_regular_grid_is_bilinear_inside_and_constant_beyond_the_outer_centres(self):
        lower, upper = block(4)
        values = 1. + 2. * (lower[:, 0] + 0.5) + 3. * (lower[:, 1] + 0.5)
        inside = np.clip(edge_places(lower, upper), 0.5, 3.5)
        np.testing.assert_allclose(edge_values(lower, upper, values, _NOTHING), 1. + inside @ [2., 3.])

    def test_neighbours_of_other_sizes_agree_where_their_corners_meet(self):
        lower = np.array([[0., 0.], [2., 0.], [2., 1.]])
        upper = lower + np.array([[2.], [1.], [1.]])
        places, values = edge_places(lower, upper), edge_values(lower, upper, np.array([0., 3., 5.]), _NOTHING)
        here = (abs(places - [2., 1.]) < 1e-12).all(axis=2)
        self.assertEqual(here.sum(), 3)
        self.assertEqual(np.ptp(values[here]), 0.)
        self.assertTrue(0. < values[here][0] < 5.)

    def test_a_gap_wider_than_half_a_box_separates(self):
        for gap, apart in ((0.4, False), (0.6, True)):
            with self.subTest(gap=gap):
                values = edge_values(*squares([[0., 0.], [1. + gap, 0.]]), np.array([0., 1.]), _NOTHING)
                self.assertEqual(bool((values[0] == 0.).all()), apart)

    def test_the_outline_of_a_body_separates(self):
        boxes, values = squares([[0., 0.], [1.1, 0.]]), np.array([0., 1.])
        wall = np.array([[[1.05, -5.], [1.05, 5.]]])
        np.testing.assert_array_equal(edge_values(*boxes, values, wall), np.repeat(values[:, None], 8, axis=1))
        self.assertTrue((edge_values(*boxes, values, wall + [0., 9.]) != values[:, None]).any())

    def test_a_box_that_a_body_cuts_keeps_its_value(self):
        wall = np.array([[[0.7, -5.], [0.7, 5.]]])
        np.testing.assert_array_equal(edge_values(*squares([[0., 0.]]), np.array([4.]), wall), np.full((1, 8), 4.))


class Crossing(unittest.TestCase):
    def test_long_and_short_segments_are_found(self):
        wall = np.array([[[0., -100.], [0., 100.]], [[5., 0.], [5., 0.1]]])
        segments = np.array([[[-1., 80.], [1., 80.]], [[-1., 101.], [1., 101.]], [[0.5, 0.], [4.5, 0.]],
                             [[1., 0.05], [50., 0.05]]])
        np.testing.assert_array_equal(crossing(segments, wall), [True, False, False, True])
        self.assertEqual(crossing(segments, _NOTHING).sum() + len(crossing(segments[:0], wall)), 0)


class Drawing(TemporaryFolder):
    def colours(self, section, places, blocks):
        """Red, green and blue of the drawn section at places (m)."""
        figure, axes = plt.subplots(figsize=(4., 4.), dpi=100)
        axes.set_position([0., 0., 1., 1.])
        axes.set(xlim=(-1., 5.), ylim=(-1., 5.))
        axes.axis("off")
        add_soil(axes, section, 1., (0., 1.), blocks)
        figure.canvas.draw()
        pixels = np.asarray(figure.canvas.buffer_rgba())[:, :, :3]
        columns, rows = (axes.transData.transform(places)).astype(int).T
        plt.close(figure)
        return pixels[len(pixels) - 1 - rows, columns].astype(int)

    def section(self, lower, upper, values):
        backdrop = types.SimpleNamespace(lower=lower[:0], upper=upper[:0], values=values[:0])
        return types.SimpleNamespace(lower=lower, upper=upper, values=values, outline=_NOTHING, backdrop=backdrop)

    def test_voids_stay_empty_and_soil_reaches_its_outer_edges(self):
        lower, upper = block(4)
        kept = ~((lower >= 1.) & (lower < 3.)).all(axis=1)
        section = self.section(lower[kept], upper[kept], lower[kept, 0] / 3.)
        void = [[2., 2.], [1.05, 1.05], [2.95, 2.95], [-0.05, 2.], [4.05, 2.], [2., 4.05]]
        soil = [[0.05, 0.05], [0.95, 2.], [3.95, 3.95], [2., 0.95], [2., 3.95]]
        for blocks in (False, True):
            with self.subTest(blocks=blocks):
                self.assertTrue((self.colours(section, void, blocks) == 255).all())
                self.assertTrue((self.colours(section, soil, blocks).min(axis=1) < 200).all())

    def test_colours_run_smoothly_unless_blocks_are_asked_for(self):
        lower, upper = block(4)
        section = self.section(lower, upper, lower[:, 0] / 3.)
        line = np.column_stack([np.linspace(0.6, 3.4, 141), np.full(141, 1.7)])
        for blocks, least, most in ((False, 0, 8), (True, 60, 255)):
            with self.subTest(blocks=blocks):
                largest = abs(np.diff(self.colours(section, line, blocks), axis=0)).max()
                self.assertTrue(least <= largest <= most, largest)


if __name__ == "__main__":
    unittest.main()
