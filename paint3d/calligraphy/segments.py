"""Strokes as segments: a stroke's line is cut at its sharp corners, each piece has stations.

What a brush does at the beginning and the end of a segment depends on the width, what it does
between on the length. A segment therefore has a zone at each end, as long as the half width asks,
and a body.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from paint3d.core.arrays import AnyArray

__all__ = ["BODY", "ZONE", "StrokeSegment", "corners_of", "cut_line", "is_hooked"]

ZONE, BODY = 11, 7
"""Stations in each end zone and between the two."""

_CORNERS = {
    "㇕": 1, "㇖": 1, "㇚": 1, "㇇": 1, "㇗": 1, "㇙": 1, "㇛": 1, "㇜": 1,
    "㇂": 1, "㇁": 1, "㇟": 1, "㇃": 1,
    "㇆": 2, "㇈": 2, "㇅": 2, "㇊": 2, "㇞": 2, "㇉": 3, "㇋": 3, "㇌": 3, "㇡": 4,
}  # fmt: skip
_HOOKED = "㇆㇚㇂㇁㇟㇈㇉㇃㇡"
_SAMPLES = 96
_WINDOW = 0.12  # of the length: how far to both sides a corner is looked at
_LEAST_SEGMENT = 0.05  # of the length
_ZONE_WIDTHS, _ZONE_SHARE = 4.0, 0.4


def corners_of(kind: str) -> int:
    """How many sharp corners a stroke of a type has."""
    return _CORNERS.get(kind[:1], 0)


def is_hooked(kind: str) -> bool:
    """Whether a stroke of a type ends in a hook."""
    return kind[:1] != "" and kind[:1] in _HOOKED


@dataclass(frozen=True, eq=False)
class StrokeSegment:
    """A piece of a stroke without sharp corners.

    Attributes
    ----------
    points : (N, 2) float64
        Evenly spaced.
    """

    points: NDArray[np.float64]

    @property
    def length(self) -> float:
        """In the units of the points."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def stations(self, half_width: float, before: float, after: float) -> NDArray[np.float64]:
        """Distances (2 ZONE + BODY,) along the segment; it goes on straight before and after."""
        zone = min(_ZONE_WIDTHS * half_width, _ZONE_SHARE * self.length)
        rest = self.length - zone
        return np.concatenate(
            [
                np.linspace(-before, zone, ZONE),
                np.linspace(zone, rest, BODY + 2)[1:-1],
                np.linspace(rest, self.length + after, ZONE),
            ]
        )

    def at(self, distances: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Points and unit vectors to the left, (N, 2) each, at distances along the segment."""
        way = np.linspace(0.0, self.length, len(self.points))
        inside = np.clip(distances, 0.0, self.length)
        tangents = np.gradient(self.points, axis=0)
        tangents = gaussian_filter1d(tangents, 0.04 * len(way), axis=0, mode="nearest")
        tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-9)
        point, tangent = (
            np.stack([np.interp(inside, way, values[:, k]) for k in range(2)], axis=1)
            for values in (self.points, tangents)
        )
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
        point = point + (np.asarray(distances) - inside)[:, None] * tangent
        return point, np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)


def cut_line(line: AnyArray, n_corners: int, hook: float = 0.0) -> list[StrokeSegment]:
    """Cut a line (N, 2) at its sharpest corners into segments.

    One of the corners of a line that ends in a hook lies within the share `hook` of its end.
    """
    points = _resampled(line, _SAMPLES)
    cuts = [0, *sorted(_sharpest(points, n_corners, hook)), _SAMPLES - 1]
    segments = []
    for first, last in pairwise(cuts):
        segments.append(StrokeSegment(_calmed(_resampled(points[first : last + 1], _SAMPLES))))
    return segments


def _sharpest(points: AnyArray, n: int, hook: float) -> list[int]:
    """Indices of the n sharpest corners, a segment apart from each other and from the ends."""
    window = int(_WINDOW * _SAMPLES)
    margin = max(2, int(_LEAST_SEGMENT * _SAMPLES))
    turning = np.zeros(_SAMPLES)
    for k in range(margin, _SAMPLES - margin):
        reach = min(window, k, _SAMPLES - 1 - k)
        back, onward = points[k] - points[k - reach], points[k + reach] - points[k]
        cross = back[0] * onward[1] - back[1] * onward[0]
        turning[k] = abs(np.arctan2(cross, back @ onward))
    chosen: list[int] = []
    if hook > 0.0 and n:
        tail = int((1.0 - hook) * _SAMPLES)
        chosen.append(tail + int(np.argmax(turning[tail:])))
    for k in np.argsort(-turning, kind="stable"):
        if len(chosen) == n or turning[k] == 0.0:
            break
        if all(abs(k - other) > margin for other in chosen):
            chosen.append(int(k))
    return chosen


def _resampled(line: AnyArray, n: int) -> NDArray[np.float64]:
    way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    at = np.linspace(0.0, way[-1], n)
    return np.stack([np.interp(at, way, line[:, k]) for k in range(2)], axis=1)


def _calmed(points: AnyArray) -> NDArray[np.float64]:
    """Smooth a segment; its ends stay."""
    sigma = 0.05 * len(points)
    chord = np.linspace(points[0], points[-1], len(points))
    reach = len(points) - 1
    off = points - chord
    padded = np.concatenate([-off[reach:0:-1], off, -off[-2 : -reach - 2 : -1]])
    result: NDArray[np.float64] = (
        chord + gaussian_filter1d(padded, sigma, axis=0)[reach : reach + len(points)]
    )
    return result
