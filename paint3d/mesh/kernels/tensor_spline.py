"""Several spline functions over one rectangle, fitted and evaluated together.

The weights of the coefficients around a place depend on the knots alone, so that functions with the
same knots share them. De Boor's recursion, as FITPACK has it, to the last bit.
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["eliminate_spline", "evaluate_splines", "solve_spline"]

_MOST = 4  # one more than the highest degree


@kernel
def _find_interval(knots, degree, x, near):
    """Place of the knot that begins the interval of x; its ends belong to the first and last.

    The interval that begins at `near` is looked at first: ways go on where they were.
    """
    low, high = degree, len(knots) - degree - 2
    if low <= near < high and knots[near] <= x < knots[near + 1]:
        return near
    while low < high:
        middle = (low + high + 1) // 2
        if knots[middle] <= x:
            low = middle
        else:
            high = middle - 1
    return low


@kernel(inline="always")
def _fill_weights(knots, degree, at, x, weights):
    """Values at x of the B-splines that do not vanish in the interval that begins at knot `at`."""
    weights[0] = 1.0
    for j in range(1, degree + 1):
        from_left = 0.0
        for i in range(j):
            right, left = knots[at + 1 + i], knots[at + 1 + i - j]
            per_span = weights[i] / (right - left)
            weights[i] = from_left + per_span * (right - x)
            from_left = per_span * (x - left)
        weights[j] = from_left


@kernel
def evaluate_splines(x_knots, y_knots, degrees, coefficients, xy, out):
    """Evaluate tensor products of B-splines at places of their rectangle.

    Parameters
    ----------
    x_knots : (A + k + 1,), y_knots : (B + m + 1,) float64
        Not falling; the ends stand degree + 1 times.
    degrees : (int, int)
        k and m, at most 3.
    coefficients : (A, B, F) float64
        Of F functions.
    xy : (N, 2) float64
        What lies beyond the rectangle is taken at its rim.
    out : (N, F) float64
        Filled.
    """
    k, m = degrees
    along, across = np.empty(_MOST), np.empty(_MOST)
    low_x, high_x = x_knots[k], x_knots[len(x_knots) - k - 1]
    low_y, high_y = y_knots[m], y_knots[len(y_knots) - m - 1]
    n_functions = coefficients.shape[2]
    column, row = k, m
    for n in range(len(xy)):
        x = min(max(xy[n, 0], low_x), high_x)
        y = min(max(xy[n, 1], low_y), high_y)
        column, row = _find_interval(x_knots, k, x, column), _find_interval(y_knots, m, y, row)
        _fill_weights(x_knots, k, column, x, along)
        _fill_weights(y_knots, m, row, y, across)
        for f in range(n_functions):
            total = 0.0
            for i in range(k + 1):
                for j in range(m + 1):
                    part = coefficients[column - k + i, row - m + j, f]
                    total += part * along[i] * across[j]
            out[n, f] = total


@kernel
def eliminate_spline(places, knots, values):
    """Rotate the equations of a cubic spline through values into a triangle, row after row.

    Givens' rotations in FITPACK's order, to the last bit. `solve_spline` goes on from there.

    Parameters
    ----------
    places : (A,) float64
        Rising.
    knots : (A + 4,) float64
        Not falling; the ends stand four times.
    values : (A, W) float64
        At the places, of W functions; turned with the equations.

    Returns
    -------
    (A, 4) float64
        The triangle, each row from its diagonal on.
    """
    n, n_functions = values.shape
    triangle, turned = np.zeros((n, _MOST)), np.zeros((n, n_functions))
    row, right = np.empty(_MOST), np.empty(n_functions)
    first = _MOST - 1
    for m in range(n):
        first = _find_interval(knots, _MOST - 1, places[m], first)
        _fill_weights(knots, _MOST - 1, first, places[m], row)
        for f in range(n_functions):
            right[f] = values[m, f]
        for i in range(_MOST):
            pivot, at = row[i], first - _MOST + 1 + i
            if pivot == 0.0:
                continue
            diagonal = triangle[at, 0]
            if abs(pivot) >= diagonal:
                length = abs(pivot) * math.sqrt(1.0 + (diagonal / pivot) ** 2)
            else:
                length = diagonal * math.sqrt(1.0 + (pivot / diagonal) ** 2)
            cosine, sine = diagonal / length, pivot / length
            triangle[at, 0] = length
            for f in range(n_functions):
                above, below = turned[at, f], right[f]
                turned[at, f] = cosine * above + sine * below
                right[f] = cosine * below - sine * above
            for j in range(i + 1, _MOST):
                above, below = triangle[at, j - i], row[j]
                triangle[at, j - i] = cosine * above + sine * below
                row[j] = cosine * below - sine * above
    values[:] = turned
    return triangle


@kernel
def solve_spline(triangle, values):
    """Solve what `eliminate_spline` left, from below: coefficients (A, W) in place of values."""
    n, n_functions = values.shape
    for i in range(n - 1, -1, -1):
        for f in range(n_functions):
            left = values[i, f]
            for j in range(1, min(_MOST, n - i)):
                left -= values[i + j, f] * triangle[i, j]
            values[i, f] = left / triangle[i, 0]
