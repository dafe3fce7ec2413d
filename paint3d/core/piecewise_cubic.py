"""Curves through given values, cubic from one to the next, as SciPy has them, to the last bit.

`scipy.interpolate` takes half a second to import: longer than a character takes to be planned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.tridiagonal import solve_tridiagonal
from paint3d.core.types import AnyArray

__all__ = ["PiecewiseCubic", "clamped_spline", "monotone_cubic"]


@dataclass(frozen=True, eq=False)
class PiecewiseCubic:
    """A curve through N values of K numbers each, with given slopes at all of them.

    Attributes
    ----------
    at : (N,) float64
        Rising.
    values, slopes : (N, K) float64
    """

    at: NDArray[np.float64]
    values: NDArray[np.float64]
    slopes: NDArray[np.float64]

    def __call__(self, places: AnyArray) -> NDArray[np.float64]:
        """Values (M, K) at places (M,); the first and last pieces go on beyond the ends."""
        span = np.diff(self.at)[:, None]
        mean = np.diff(self.values, axis=0) / span
        bend = (self.slopes[:-1] + self.slopes[1:] - 2 * mean) / span
        piece = np.clip(np.searchsorted(self.at, places, side="right") - 1, 0, len(span) - 1)
        step = (places - self.at[piece])[:, None]
        square = step * step
        result: NDArray[np.float64] = self.values[piece] + self.slopes[piece] * step
        result += ((mean - self.slopes[:-1]) / span - bend)[piece] * square
        result += (bend / span)[piece] * (square * step)
        return result


def clamped_spline(at: NDArray[np.float64], values: NDArray[np.float64]) -> PiecewiseCubic:
    """The curve through values (N, K) that is at rest at both ends, without jumps up to y''.

    Parameters
    ----------
    at : (N,) float64
        Rising; at least two.
    values : (N, K) float64
    """
    span = np.diff(at)
    across = span[:, None]
    mean = np.diff(values, axis=0) / across
    diagonal, slopes = np.ones(len(at)), np.zeros(values.shape)
    diagonal[1:-1] = 2 * (span[:-1] + span[1:])
    slopes[1:-1] = 3 * (across[1:] * mean[:-1] + across[:-1] * mean[1:])
    solve_tridiagonal(np.r_[span[1:], 0.0], diagonal, np.r_[0.0, span[:-1]], slopes)
    return PiecewiseCubic(at, values, slopes)


def monotone_cubic(at: NDArray[np.float64], values: NDArray[np.float64]) -> PiecewiseCubic:
    """The curve through values (N, K) that rises and falls only where they do.

    Slopes are weighted harmonic means of those to both sides (Fritsch and Butland 1984).
    Through two values it is a line.

    Parameters
    ----------
    at : (N,) float64
        Rising; at least two.
    values : (N, K) float64
    """
    span = np.diff(at)[:, None]
    mean = np.diff(values, axis=0) / span
    if len(at) == 2:
        return PiecewiseCubic(at, values, np.repeat(mean, 2, axis=0))
    one, two = 2 * span[1:] + span[:-1], span[1:] + 2 * span[:-1]
    alike = (np.sign(mean[1:]) == np.sign(mean[:-1])) & (mean[1:] != 0.0) & (mean[:-1] != 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        harmonic = 1.0 / ((one / mean[:-1] + two / mean[1:]) / (one + two))
    slopes = np.zeros(values.shape)
    slopes[1:-1][alike] = harmonic[alike]
    slopes[0] = _end_slope(span[0], span[1], mean[0], mean[1])
    slopes[-1] = _end_slope(span[-1], span[-2], mean[-1], mean[-2])
    return PiecewiseCubic(at, values, slopes)


def _end_slope(span: AnyArray, next_span: AnyArray, mean: AnyArray, after: AnyArray) -> AnyArray:
    """Slope (K,) at an end, from the two mean slopes there; it overshoots nothing."""
    slope = ((2 * span + next_span) * mean - span * after) / (span + next_span)
    slope[np.sign(slope) != np.sign(mean)] = 0.0
    steep = (np.sign(mean) != np.sign(after)) & (np.abs(slope) > 3.0 * np.abs(mean))
    return np.where(steep, 3.0 * mean, slope)
