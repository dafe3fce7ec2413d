"""Filters along one axis of an array as SciPy has them, and a median as NumPy has it, to the bit.

`scipy.ndimage` takes a third of a second to import, longer than most of what is done with these;
`numpy.median` loads all of `numpy.ma`, 10 ms, to see whether numbers are masked.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from paint3d.core.types import AnyArray

__all__ = ["gaussian_filter1d", "maximum_filter1d", "median", "minimum_filter1d"]

Border = Literal["nearest", "reflect"]


def gaussian_filter1d(
    values: AnyArray, sigma: float, axis: int = 0, mode: Border = "reflect", truncate: float = 4.0
) -> NDArray[np.float64]:
    """Smooth values with a Gaussian along one axis.

    Parameters
    ----------
    values : array of float64
    sigma : float
        Above 0, in samples.
    axis : int
    mode : {"nearest", "reflect"}
        What lies beyond the ends: the last value, or all again backwards, the last value first.
    truncate : float
        Where the Gaussian is cut off, in sigmas.
    """
    radius = int(truncate * float(sigma) + 0.5)
    weights = np.exp(-0.5 / (sigma * sigma) * np.arange(-radius, radius + 1) ** 2)
    weights /= weights.sum()
    padded = _padded(values, axis, radius, mode)
    n = values.shape[axis]
    smooth = padded[radius : radius + n] * weights[radius]
    for k in range(radius):  # from the outside in, both sides at once: the order of SciPy's sums
        smooth += (padded[k : k + n] + padded[2 * radius - k : 2 * radius - k + n]) * weights[k]
    return np.ascontiguousarray(np.moveaxis(smooth, 0, axis))


def maximum_filter1d(
    values: AnyArray, size: int, axis: int = 0, mode: Border = "reflect"
) -> AnyArray:
    """The largest value in a window of odd `size` around each, along one axis."""
    result: AnyArray = _windows(values, size, axis, mode).max(axis=-1)
    return result


def minimum_filter1d(
    values: AnyArray, size: int, axis: int = 0, mode: Border = "reflect"
) -> AnyArray:
    """The least value in a window of odd `size` around each, along one axis."""
    result: AnyArray = _windows(values, size, axis, mode).min(axis=-1)
    return result


def _windows(values: AnyArray, size: int, axis: int, mode: Border) -> AnyArray:
    padded = _padded(values, axis, size // 2, mode)
    return np.moveaxis(sliding_window_view(padded, size, axis=0), 0, axis)


def _padded(values: AnyArray, axis: int, n: int, mode: Border) -> AnyArray:
    """Values with the axis in front, and with `n` more at both of its ends.

    As `numpy.pad` does it, which takes a tenth of a millisecond to find out how.
    """
    size = values.shape[axis]
    at = np.arange(-n, size + n)
    if mode == "nearest":
        at = at.clip(0, size - 1)
    else:
        at %= 2 * size
        at = np.minimum(at, 2 * size - 1 - at)
    return np.moveaxis(values, axis, 0).take(at, axis=0)


def median(values: AnyArray) -> float:
    """The middle one of finite numbers, at least one."""
    values = np.ravel(values)
    half = values.size // 2
    if values.size % 2:
        return float(np.partition(values, half)[half])
    return 0.5 * float(np.partition(values, (half - 1, half))[half - 1 : half + 1].sum())
