"""Curves through values: what SciPy gives, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.linalg import solve_banded

from paint3d.core.piecewise_cubic import clamped_spline, monotone_cubic
from paint3d.core.tridiagonal import solve_tridiagonal


def a_curve(n: int, spread: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, values of which some are alike, and where to look: beyond the ends, too."""
    chance = np.random.default_rng(n)
    at = np.cumsum(spread * chance.uniform(0.01, 1.0, n))
    values = chance.normal(size=(n, 4)).round(1)
    values[n // 2 + 1 : n // 2 + 3] = values[n // 2]
    looked = chance.uniform(at[0] - 0.1 * spread, at[-1] + 0.1 * spread, 3000)
    looked[:n] = at
    return at, values, looked


@pytest.mark.parametrize("spread", [0.003, 8.0])
@pytest.mark.parametrize("n", [3, 4, 30, 301])
def test_clamped_splines_are_scipys(n: int, spread: float) -> None:
    at, values, looked = a_curve(n, spread)
    expected = CubicSpline(at, values, bc_type="clamped")(looked)
    np.testing.assert_array_equal(clamped_spline(at, values)(looked), expected)


def test_a_clamped_spline_of_two_values_is_at_rest_at_both() -> None:
    at, values = np.array([0.0, 2.0]), np.array([[0.0], [4.0]])
    curve = clamped_spline(at, values)
    np.testing.assert_array_equal(curve(np.array([0.0, 1.0, 2.0])), [[0.0], [2.0], [4.0]])
    np.testing.assert_array_equal(curve.slopes, 0.0)


@pytest.mark.parametrize("n", [2, 3, 4, 29, 301])
def test_monotone_curves_are_scipys(n: int) -> None:
    at, values, looked = a_curve(n, 1.0)
    expected = PchipInterpolator(at, values)(looked)
    np.testing.assert_array_equal(monotone_cubic(at, values)(looked), expected)


@pytest.mark.parametrize("n", [2, 3, 50])
def test_rows_are_exchanged_where_a_pivot_is_small(n: int) -> None:
    chance = np.random.default_rng(n)
    lower, upper = chance.normal(size=(2, n - 1))
    diagonal, right = 0.1 * chance.normal(size=n), chance.normal(size=(n, 3))
    banded = np.stack([np.r_[0.0, upper], diagonal, np.r_[lower, 0.0]])
    expected = solve_banded((1, 1), banded, right)
    solve_tridiagonal(lower, diagonal, upper, right)
    np.testing.assert_array_equal(right, expected)
