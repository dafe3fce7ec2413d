"""Order and direction of strokes where nothing is known of the character.

Strokes are drawn to the right and downwards, and out to their point, since a brush is set down and
lifted off: that tells a rising stroke from one that falls to the left. What stands apart is written
from the left to the right where it stands side by side, and from the top downwards otherwise. A
closed stroke begins at its top. Who writes from the right mirrors the shape before, and the strokes
after; there letters run on along the line, joined, and what begins farther along it is written
later, however high.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.regions import Piece
from paint3d.core.arrays import AnyArray

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = ["directed", "in_writing_order"]

_EASY = math.radians(-55.0)  # the way that a brush is drawn most easily
_FIRST_PART = 0.6  # of a stroke: hooks come last
_SHARES = (0.6, 0.4)  # of how the first part and the whole count
_POINTED = 1.6  # how much a taper to a third counts beside that: what is easiest counts 2
_NEAR_ENDS = (0.1, 0.2, 0.3)  # of a stroke from either end: where its taper is looked at
_GAP = 0.25  # of a stroke's mean width that two parts may reach into each other
_LEVEL = 1.5  # times as wide as high: a level stroke
_SLOPE = 0.35  # how much farther to the left counts as higher
_RUNNING = 4.0  # the same where letters run on
_WHOLE = 0.05  # that, by all of the stroke
_FIRST = 0.06  # of the height, that level strokes are written before others


def directed(line: AnyArray, region: Polygon | None = None) -> NDArray[np.float64]:
    """A line (N, 2) in the direction that it is written in, by its stroke's taper, too, if given.

    What is left over of a known letter is told by its line alone: it has no taper of its own.
    """
    if np.array_equal(line[0], line[-1]):
        x, y = line[:-1].T
        leftwards = float(np.sum(np.roll(x, 1) * y - x * np.roll(y, 1))) > 0.0
        return line if leftwards else line[::-1]
    easier = _ease(line) - _ease(line[::-1])
    if region is not None:
        easier += _POINTED * _taper(line, region)
    return line if easier >= 0.0 else line[::-1]


def _taper(line: AnyArray, region: Polygon) -> float:
    """How much wider the first part of a stroke is than its last: a logarithm, from -1 to 1."""
    import shapely

    way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    at = way[-1] * np.array([_NEAR_ENDS, np.subtract(1.0, _NEAR_ENDS)])
    places = [np.interp(at.ravel(), way, line[:, axis]) for axis in (0, 1)]
    away = shapely.distance(shapely.points(*places), region.boundary)
    first, last = away.reshape(2, -1).sum(axis=1)
    if not (first > 0.0 and last > 0.0):  # a line outside of its region, which has none
        return 0.0
    return float(np.clip(math.log(first / last), -1.0, 1.0))


def _ease(line: AnyArray) -> float:
    """How easily a line is drawn."""
    at = round(_FIRST_PART * (len(line) - 1)) or 1
    total = 0.0
    for end, share in zip((line[at], line[-1]), _SHARES, strict=True):
        way = end - line[0]
        if way.any():
            total += share * math.cos(math.atan2(way[1], way[0]) - _EASY)
    return total


def in_writing_order(pieces: Sequence[Piece], *, runs_on: bool = False) -> list[Piece]:
    """Strokes in the order that they are written in, each in its direction.

    Parameters
    ----------
    pieces : sequence of Piece
    runs_on : bool
        Whether they are letters that are joined along a line, as in Arabic.
    """
    turned = [Piece(directed(piece.line, piece.region), piece.region) for piece in pieces]
    boxes = np.array([piece.region.bounds for piece in turned])
    areas = sum(piece.region.area for piece in turned)
    gap = _GAP * 2.0 * areas / sum(piece.region.length for piece in turned)
    height = float(boxes[:, 3].max() - boxes[:, 1].min())

    slope, first = (_RUNNING, 0.0) if runs_on else (_SLOPE, _FIRST * height)

    def key(k: int) -> float:
        line = turned[k].line
        early = first if _is_level(line) else 0.0
        aside = slope * line[0, 0] + _WHOLE * line[:, 0].mean()
        return float(aside - line[0, 1]) - early

    order = _divided(list(range(len(turned))), boxes, gap, key)
    return [turned[k] for k in _crossed(order, turned)]


def _crossed(order: list[int], pieces: Sequence[Piece]) -> list[int]:
    """Put level strokes before the upright ones that they cross."""
    import shapely

    lines = [shapely.LineString(piece.line) for piece in pieces]
    done: list[int] = []
    for k in order:
        at = len(done)
        if _is_level(pieces[k].line):
            for j in range(len(done) - 1, -1, -1):
                if not _is_level(pieces[done[j]].line) and lines[k].crosses(lines[done[j]]):
                    at = j
        done.insert(at, k)
    return done


def _is_level(line: AnyArray) -> bool:
    wide, high = np.abs(line[-1] - line[0])
    return bool(wide > _LEVEL * high)


def _divided(
    here: list[int], boxes: AnyArray, gap: float, key: Callable[[int], float]
) -> list[int]:
    """Divide strokes by gaps between columns or rows, and order what has none by a key."""
    if len(here) == 1:
        return here
    columns = _groups(here, boxes[:, 0], boxes[:, 2], gap)
    rows = _groups(here, -boxes[:, 3], -boxes[:, 1], gap)
    best = columns if len(columns) >= len(rows) else rows
    if len(best) == 1:
        return sorted(here, key=key)
    return [k for group in best for k in _divided(group, boxes, gap, key)]


def _groups(here: list[int], low: AnyArray, high: AnyArray, gap: float) -> list[list[int]]:
    """Strokes whose extents hang together, from the lowest on."""
    ordered = sorted(here, key=lambda k: float(low[k]))
    groups, reach = [[ordered[0]]], float(high[ordered[0]])
    for k in ordered[1:]:
        if low[k] > reach - gap:
            groups.append([])
        groups[-1].append(k)
        reach = max(reach, float(high[k]))
    return groups
