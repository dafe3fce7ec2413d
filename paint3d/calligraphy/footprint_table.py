"""A table of footprints: the same brush, upright, pressed deeper from row to row."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.drag import drag_length
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, round_tip, trace_outline
from paint3d.brush_engine.tuft import Tuft
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["FootprintTable", "tabulate_footprints"]

_SIDE = 15  # boundary points on each side, between tip and heel
_SUPPORT_DIRECTIONS = 72
_LEVELS = 64  # rows of the table, even in the footprint's size
_FINEST = 2e-4  # of the length: how wide the first row is at the least
_FINE = 600  # descents tried to find where contact begins and where it is wide enough


@dataclass(frozen=True, eq=False)
class FootprintTable:
    """Footprints of an upright brush at L descents, each about its own centroid.

    Attributes
    ----------
    descents : (L,) float64
        D_s of each row, mm, rising.
    centroids : (L,) float64
        Distance of the centroid from P'_m along the bend, mm.
    points : (L, B, 2) float64
        Boundary, counter-clockwise from the tip, mm; the bend points along +x.
    support : (L, 72) float64
        Reach from the centroid in even directions from 0, mm.
    slack : (L,) float64
        l(D_s) of the drag law, mm.
    """

    descents: NDArray[np.float64]
    centroids: NDArray[np.float64]
    points: NDArray[np.float64]
    support: NDArray[np.float64]
    slack: NDArray[np.float64]

    def descent_at(self, level: AnyArray) -> NDArray[np.float64]:
        """D_s (mm) at fractional levels."""
        return np.interp(level, np.arange(len(self.descents)), self.descents)

    def centroid_at(self, level: AnyArray) -> NDArray[np.float64]:
        """Distance of the centroid from P'_m (mm) at fractional levels."""
        return np.interp(level, np.arange(len(self.descents)), self.centroids)

    def heel_at(self, level: AnyArray) -> NDArray[np.float64]:
        """Distance of the heel from P'_m (mm) at fractional levels."""
        heels = self.centroids + self.points[:, _SIDE + 1, 0]
        return np.interp(level, np.arange(len(self.descents)), heels)

    def length_at(self, level: AnyArray) -> NDArray[np.float64]:
        """From the heel to the tip (mm) at fractional levels."""
        lengths = self.points[:, 0, 0] - self.points[:, _SIDE + 1, 0]
        return np.interp(level, np.arange(len(self.descents)), lengths)

    def width_at(self, level: AnyArray) -> NDArray[np.float64]:
        """Width (mm) at fractional levels."""
        widths = 2.0 * self.points[:, :, 1].max(axis=1)
        result: NDArray[np.float64] = np.interp(level, np.arange(len(self.descents)), widths)
        return result

    def slack_at(self, level: AnyArray) -> NDArray[np.float64]:
        """Slack of the drag law (mm) at fractional levels."""
        return np.interp(level, np.arange(len(self.descents)), self.slack)


def tabulate_footprints(tuft: Tuft, widest_mm: float) -> FootprintTable:
    """Tabulate the footprints of a brush from the first touch to a width.

    Parameters
    ----------
    tuft : Tuft
    widest_mm : float
        Width of the last row; less where the brush ends before.

    Raises
    ------
    InputError
        If the width is not positive or the brush leaves no footprint.
    """
    if not widest_mm > 0.0:
        raise InputError("widest_mm is {widest_mm}; expected more than 0", widest_mm=widest_mm)
    descents = tuft.full_press * (np.arange(1, _FINE + 1) / _FINE) ** 1.5
    outlines = [_outline(tuft, float(descent)) for descent in descents]
    widths = np.array([0.0 if o is None else 2.0 * o[1].max() for o in outlines])
    first = int(np.argmax(widths > _FINEST * tuft.length))
    if widths[first] == 0.0:
        raise InputError("the brush leaves no footprint at any descent")
    last = max(int(np.searchsorted(np.maximum.accumulate(widths), widest_mm)), first + 1)
    last = min(last, _FINE - 1)
    size = np.sqrt(np.array([_area(o) for o in outlines[first : last + 1]]))
    wanted = np.linspace(size[0], size[-1], _LEVELS)
    at = np.interp(wanted, size, descents[first : last + 1])
    return _tabulate(tuft, at)


def _tabulate(tuft: Tuft, descents: AnyArray) -> FootprintTable:
    rows, centroids = [], []
    for descent in descents:
        outline = _outline(tuft, float(descent))
        assert outline is not None, "those with a footprint were chosen"
        reach, half_width = outline
        middle = _centroid(reach, half_width)
        centroids.append(middle)
        rows.append(_boundary(reach - middle, half_width))
    points = np.array(rows)
    angle = 2.0 * math.pi * np.arange(_SUPPORT_DIRECTIONS) / _SUPPORT_DIRECTIONS
    rays = np.stack([np.cos(angle), np.sin(angle)])
    support = (points @ rays).max(axis=1)
    slack = [drag_length(float(d), tuft.length, tuft.drag_fraction) for d in descents]
    return FootprintTable(
        np.asarray(descents), np.array(centroids), points, support, np.array(slack)
    )


def _outline(tuft: Tuft, descent: float) -> tuple[AnyArray, AnyArray] | None:
    """Reach (heel first) and half width of an upright footprint, or None without contact."""
    scratch = np.empty(SCRATCH_SIZE)
    reach, half_width = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    pe = min(1.0, descent / tuft.full_press)
    n = trace_outline(tuft, descent, 0.5 * math.pi, pe, scratch, reach, half_width)
    round_tip(reach, half_width, n)
    return (reach[n - 1 :: -1].copy(), half_width[n - 1 :: -1].copy()) if n > 2 else None


def _area(outline: tuple[AnyArray, AnyArray] | None) -> float:
    return 0.0 if outline is None else 2.0 * float(np.trapezoid(outline[1], outline[0]))


def _centroid(reach: AnyArray, half_width: AnyArray) -> float:
    return float(np.trapezoid(reach * half_width, reach) / np.trapezoid(half_width, reach))


def _boundary(reach: AnyArray, half_width: AnyArray) -> NDArray[np.float64]:
    """Points of the outline, counter-clockwise from the tip, closer together at both ends."""
    fraction = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, _SIDE + 1) / (_SIDE + 1))
    x = reach[0] + fraction * (reach[-1] - reach[0])
    y = np.interp(x, reach, half_width)
    left, right = np.stack([x, y], axis=1), np.stack([x, -y], axis=1)[::-1]
    return np.concatenate([[(reach[-1], 0.0)], left, [(reach[0], 0.0)], right])
