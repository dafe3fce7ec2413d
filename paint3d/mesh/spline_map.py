"""Bicubic splines through values on a grid: several functions of one rectangle at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.mesh.kernels.tensor_spline import eliminate_spline, evaluate_splines, solve_spline

__all__ = ["SplineMap"]

_DEGREE = 3


class SplineMap:
    """F functions of (x, y), each a bicubic spline through its values at the nodes of a grid.

    Parameters
    ----------
    xs, ys : (A,), (B,) float64
        Rising; at least four each.
    values : (A, B, F) float64
    """

    def __init__(
        self, xs: NDArray[np.float64], ys: NDArray[np.float64], values: NDArray[np.float64]
    ) -> None:
        x_knots, y_knots = _knots(xs), _knots(ys)
        coefficients = _fitted(xs, x_knots, ys, y_knots, values)
        along_x = _differences(coefficients, x_knots)
        along_y = _differences(coefficients.transpose(1, 0, 2), y_knots).transpose(1, 0, 2)
        self._parts = {
            (0, 0): (x_knots, y_knots, (_DEGREE, _DEGREE), coefficients),
            (1, 0): (x_knots[1:-1].copy(), y_knots, (_DEGREE - 1, _DEGREE), along_x),
            (0, 1): (
                x_knots, y_knots[1:-1].copy(), (_DEGREE, _DEGREE - 1), np.ascontiguousarray(along_y)
            ),
        }  # fmt: skip

    def __call__(self, xy: AnyArray, dx: int = 0, dy: int = 0) -> AnyArray:
        """Values (N, F) at places (N, 2), or their first derivatives along x or along y.

        Beyond the grid the rim's hold.
        """
        x_knots, y_knots, degrees, coefficients = self._parts[dx, dy]
        out = np.empty((len(xy), coefficients.shape[2]))
        evaluate_splines(x_knots, y_knots, degrees, coefficients, np.array(xy, np.float64), out)
        return out


def _knots(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where the pieces of a spline through values at places meet: in all but the outer four."""
    ends = [np.repeat(places[end], _DEGREE + 1) for end in (0, -1)]
    return np.concatenate([ends[0], places[2:-2], ends[1]])


def _fitted(
    xs: AnyArray, x_knots: AnyArray, ys: AnyArray, y_knots: AnyArray, values: AnyArray
) -> NDArray[np.float64]:
    """Coefficients (A, B, F), to the last bit those of FITPACK (SciPy's RectBivariateSpline)."""
    n_x, n_y, n_functions = values.shape
    along_x = np.array(values, np.float64, order="C").reshape(n_x, -1)
    x_triangle = eliminate_spline(xs, x_knots, along_x)
    along_y = np.ascontiguousarray(along_x.reshape(values.shape).swapaxes(0, 1)).reshape(n_y, -1)
    solve_spline(eliminate_spline(ys, y_knots, along_y), along_y)
    both = along_y.reshape(n_y, n_x, n_functions).swapaxes(0, 1)
    along_x = np.ascontiguousarray(both).reshape(n_x, -1)
    solve_spline(x_triangle, along_x)
    return along_x.reshape(values.shape)


def _differences(coefficients: AnyArray, knots: AnyArray) -> AnyArray:
    """Coefficients of the derivative along the first axis."""
    spans = knots[_DEGREE + 1 : -1] - knots[1 : -_DEGREE - 1]
    result: AnyArray = np.diff(coefficients, axis=0) * _DEGREE / spans[:, None, None]
    return result
