"""Splines over a grid: the functions of one rectangle that SciPy's own evaluation gives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline

from paint3d.mesh.chart import SplineMap


@pytest.mark.parametrize("nodes", [(4, 4), (5, 41), (33, 8)])
@pytest.mark.parametrize("order", [(0, 0), (1, 0), (0, 1)])
def test_functions_are_those_of_scipy_to_the_bit(
    nodes: tuple[int, int], order: tuple[int, int]
) -> None:
    chance = np.random.default_rng(3)
    xs = np.sort(chance.uniform(-60.0, 60.0, nodes[0]))
    ys = np.linspace(-7.3, 5.1, nodes[1])
    values = chance.normal(size=(*nodes, 3)).cumsum(axis=0)
    xy = chance.uniform([xs[0], ys[0]], [xs[-1], ys[-1]], (5000, 2))
    xy[: nodes[0], 0], xy[-nodes[1] :, 1] = xs, ys  # on the nodes, too
    xy[100:102] = [[xs[0], ys[0]], [xs[-1], ys[-1]]]
    found = SplineMap(xs, ys, values)(xy, *order)
    for f in range(3):
        expected = RectBivariateSpline(xs, ys, values[..., f]).ev(*xy.T, *order)
        np.testing.assert_array_equal(found[:, f], expected)


def test_beyond_the_grid_the_rim_holds() -> None:
    xs, ys = np.linspace(0.0, 6.0, 7), np.linspace(0.0, 4.0, 5)
    values = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1)
    found = SplineMap(xs, ys, values)(np.array([[-1.0, 2.0], [7.0, 9.0]]))
    np.testing.assert_allclose(found, [[0.0, 2.0], [6.0, 4.0]], atol=1e-12)
