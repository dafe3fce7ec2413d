"""Bicubic splines through values on a grid: several functions of one rectangle at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.mesh.kernels.tensor_spline import evaluate_splines

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
        from scipy.interpolate import RectBivariateSpline  # half a second, and only pads need it

        shape = (len(xs), len(ys))
        coefficients = np.empty((*shape, values.shape[2]))
        for f in range(values.shape[2]):
            spline = RectBivariateSpline(xs, ys, values[..., f])
            coefficients[..., f] = spline.get_coeffs().reshape(shape)
        x_knots, y_knots = (np.array(knots) for knots in spline.get_knots())
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


def _differences(coefficients: AnyArray, knots: AnyArray) -> AnyArray:
    """Coefficients of the derivative along the first axis."""
    spans = knots[_DEGREE + 1 : -1] - knots[1 : -_DEGREE - 1]
    result: AnyArray = np.diff(coefficients, axis=0) * _DEGREE / spans[:, None, None]
    return result
