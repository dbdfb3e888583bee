#!/usr/bin/python3
"""Tests of the numbers of a study: expressions, answers from curves, convergence."""
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from kedge_study import StudyError  # noqa: E402  (found only after the line above)
from kedge_study.convergence import order_of_errors, pareto_front, richardson  # noqa: E402
from kedge_study.expressions import evaluate, resolve  # noqa: E402
from kedge_study.taking import take  # noqa: E402


class Expressions(unittest.TestCase):
    def test_arithmetic(self):
        self.assertEqual(evaluate("2 + 3 * h", {"h": 2}, "x"), 8)
        self.assertAlmostEqual(evaluate("3*pi + 2", {}, "x"), 11.42478, places=4)
        self.assertEqual(evaluate("round(7 / 2.1)", {}, "x"), 3)
        self.assertEqual(evaluate("'a' if n > 1 else 'b'", {"n": 2}, "x"), "a")
        self.assertEqual(evaluate("mean(F[(u > 1) & (u < 4)])", {"F": np.array([1., 2., 4., 8.]),
                                                                 "u": np.array([1., 2., 3., 4.])}, "x"), 3.)
        self.assertEqual(evaluate(4, {}, "x"), 4)

    def test_only_arithmetic(self):
        for text in ("__import__('os')", "h.real", "[x for x in h]", "lambda: 1", "open('x')", "mean(a=1)"):
            with self.subTest(text), self.assertRaises(StudyError):
                evaluate(text, {"h": 1}, "x")

    def test_errors_name_the_place(self):
        for text in ("1 +", "hh", "1 / 0", "sqrt('a')"):
            with self.subTest(text), self.assertRaisesRegex(StudyError, "derived.steps"):
                evaluate(text, {"h": 1}, "f: derived.steps")
        with self.assertRaisesRegex(StudyError, "did you mean steps"):
            evaluate("stepz", {"steps": 1}, "x")

    def test_values_of_json(self):
        self.assertEqual(resolve({"a": ["= h", "on", 3, {"b": "= 2 * h"}]}, {"h": 4}, "x"),
                         {"a": [4, "on", 3, {"b": 8}]})


class Numbers(unittest.TestCase):
    def test_taken_from_curves(self):
        x, y = np.array([1., 2., 3., 4.]), np.array([2., 4., 4., 2.])
        self.assertEqual(take(x, y, "max", {}), 4.)
        self.assertAlmostEqual(take(x, y, "mean", {"from": 2., "to": 4.}), 3.5)
        self.assertEqual(take(x, y, "at", {"x": 1.5}), 3.)
        self.assertIsNone(take(x, y, "at", {"x": 0.5}))  # before the first row
        self.assertEqual(take(-x, y, "at", {"x": -1.5}), 3.)
        self.assertIsNone(take(x, y, "at", {"x": 5.}))
        self.assertIsNone(take(x, y, "mean", {"to": 5.}))
        self.assertIsNone(take(-x, y, "mean", {"from": -5.}))
        self.assertAlmostEqual(take(-x, y, "mean", {"from": -4., "to": -2.}), 3.5)
        self.assertAlmostEqual(take(x, y, "spread", {"from": 3.}), 1. / 3.)
        t = np.linspace(0., 10., 400)
        self.assertAlmostEqual(take(t, np.sin(2. * np.pi * t / 2.5), "period", {}), 2.5, places=2)
        self.assertAlmostEqual(take(t, t / (0.1 + t / 7.), "limit", {}), 7., places=6)

    def test_taken_from_a_path_to_and_fro(self):
        x, y = np.array([0., 2., 1., -1., 3.]), np.array([0., 4., 7., 9., 1.])
        self.assertEqual(take(x, y, "at", {"x": 1.}), 2.)  # where x first reaches it
        self.assertEqual(take(x, y, "at", {"x": -0.5}), 8.5)
        self.assertEqual((take(x, y, "min", {}), take(x, y, "max", {}), take(x, y, "end", {})), (0., 9., 1.))
        for kind in ("mean", "spread", "period"):
            with self.subTest(kind), self.assertRaisesRegex(StudyError, "to and fro"):
                take(x, y, kind, {})

    def test_richardson_finds_order_and_limit(self):
        for order in (1., 2., 1.5):
            for sizes in ([0.4, 0.2, 0.1], [0.3, 0.2, 0.1]):
                found = richardson(sizes, [5. + 3. * size**order for size in sizes])
                self.assertAlmostEqual(found.order, order, places=6)
                self.assertAlmostEqual(found.limit, 5., places=8)
                self.assertAlmostEqual(found.uncertainty, 1.25 * 3. * 0.1**order, places=8)

    def test_high_orders_are_not_trusted(self):
        found = richardson([0.4, 0.2, 0.1], [5. + 3. * size**5 for size in (0.4, 0.2, 0.1)])
        self.assertAlmostEqual(found.order, 5., places=6)
        self.assertAlmostEqual(found.uncertainty, 1.25 * 3. * (0.2**5 - 0.1**5) / 3., places=10)

    def test_no_order_where_answers_swing(self):
        found = richardson([0.4, 0.2, 0.1], [1., 2., 1.5])
        self.assertIsNone(found.order)
        self.assertEqual(found.limit, 1.5)
        self.assertAlmostEqual(found.uncertainty, 1.5)
        self.assertIsNone(richardson([0.2, 0.1], [1., 2.]))

    def test_order_of_errors(self):
        self.assertAlmostEqual(order_of_errors([0.4, 0.2, 0.1], [0.16, 0.04, 0.01]), 2.)
        self.assertIsNone(order_of_errors([0.2, 0.1], [0.1, 0.]))

    def test_pareto_front(self):
        self.assertEqual(pareto_front([1., 2., 3., 4.], [5., 6., 2., 2.]), [0, 2])


if __name__ == "__main__":
    unittest.main()
