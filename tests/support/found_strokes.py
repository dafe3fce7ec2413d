"""Agreement of strokes found in a shape with the strokes that it was made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.optimize import linear_sum_assignment
from scipy.stats import kendalltau
from shapely import MultiPolygon, Polygon

from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import line_length, resample

__all__ = ["AsListed", "Found", "as_listed", "joined", "region_of", "score"]

_FOUND, _MATCHED = 0.7, 0.5  # IoU of a stroke with its own
_SHORT = 0.08  # of the shape's size: chords shorter than that tell no direction
_CLOSED = 0.2  # of a line's length between its ends: it is a ring
_FLAT = 0.07  # of the greater side of a box: the least that the other one is taken for
_POINTS = 24  # of a line
_DOT = 0.15  # of the box: a shorter line is a dot's, which has no direction
_SURELY = 0.98  # of the distance gone backwards: what goes there and back is no course
_LISTED_DOT = 0.15  # of the greater side of its letter: the same of the table's


@dataclass(frozen=True)
class Found:
    """Comparison of the strokes found in a shape with the true ones.

    Attributes
    ----------
    found : float
        Share of the true strokes with a found one of an IoU above 0.7.
    count : int
        How many strokes more than there are.
    iou : float
        Mean over the pairs that fit best.
    tau : float
        Kendall's tau of the order; nan where fewer than two strokes have a pair.
    direction : float
        Share of the pairs that are written the same way.
    """

    found: float
    count: int
    iou: float
    tau: float
    direction: float


def region_of(stroke: GlyphStroke) -> Polygon:
    """The region of a stroke, mended where its outline crosses itself."""
    return Polygon(stroke.outline, stroke.holes).buffer(0.0)


def joined(strokes: Sequence[GlyphStroke]) -> MultiPolygon:
    """The ink of all strokes together."""
    parts = shapely.get_parts(shapely.union_all([region_of(stroke) for stroke in strokes]))
    return MultiPolygon([part for part in parts if part.geom_type == "Polygon"])


def score(strokes: Sequence[GlyphStroke], truth: Sequence[GlyphStroke]) -> Found:
    """Pair found strokes with true ones so that their regions agree best, and compare."""
    regions, wanted = [region_of(s) for s in strokes], [region_of(s) for s in truth]
    iou = np.array([[a.intersection(b).area / a.union(b).area for b in wanted] for a in regions])
    rows, columns = linear_sum_assignment(-iou)
    pairs = [(i, j) for i, j in zip(rows, columns, strict=True) if iou[i, j] > _MATCHED]
    tau = kendalltau(*zip(*pairs, strict=True))[0] if len(pairs) > 1 else np.nan
    size = float(np.ptp(np.concatenate([s.outline for s in truth]), axis=0).max())
    ways = [_same_way(strokes[i].median, truth[j].median, _SHORT * size) for i, j in pairs]
    return Found(
        found=sum(iou[i, j] > _FOUND for i, j in pairs) / len(truth),
        count=len(strokes) - len(truth),
        iou=float(iou[rows, columns].sum() / len(truth)),
        tau=float(tau),
        direction=float(np.mean(ways)) if ways else np.nan,
    )


def _same_way(line: np.ndarray, other: np.ndarray, short: float) -> bool:
    way, wanted = line[-1] - line[0], other[-1] - other[0]
    if np.linalg.norm(wanted) > short:
        return bool(way @ wanted > 0.0)
    return bool(np.linalg.norm(line[0] - other[0]) < np.linalg.norm(line[-1] - other[0]))


@dataclass(frozen=True)
class AsListed:
    """Agreement of a letter's strokes with a table of ductus.

    Attributes
    ----------
    count : int
        How many strokes more than the table has.
    tau : float
        Kendall's tau of the order of those that have one of the table; nan below two.
    direction : float
        Share of them that are written the same way, or are dots.
    """

    count: int
    tau: float
    direction: float

    @property
    def agrees(self) -> bool:
        """True if all strokes with a match in the table are in its order and direction."""
        return self.direction == 1.0 and not self.tau < 1.0 - 1e-9


def as_listed(strokes: Sequence[GlyphStroke], *forms: Sequence[GlyphStroke]) -> AsListed:
    """Pair strokes with the table's, box laid on box, so that they lie nearest; and compare.

    Nothing is bent to fit: what the decomposition did to lay the same lines over the shape has no
    part in it. Of a letter's several forms that counts whose lines lie nearest, whatever their
    order and direction.
    """
    lines = _in_unit_box([stroke.median for stroke in strokes])
    paired = [_paired(lines, _in_unit_box([one.median for one in form])) for form in forms]
    nearest = min(range(len(forms)), key=lambda k: paired[k][0])
    _, wanted, pairs = paired[nearest]
    dots = _dots(forms[nearest])
    tau = kendalltau(*zip(*pairs, strict=True))[0] if len(pairs) > 1 else np.nan
    same = [j in dots or _same_course(lines[i], wanted[j]) for i, j in pairs]
    return AsListed(len(strokes) - len(wanted), float(tau), float(np.mean(same)))


def _paired(
    lines: Sequence[np.ndarray], table: list[np.ndarray]
) -> tuple[float, list[np.ndarray], list[tuple[int, int]]]:
    """Pair strokes with a table's: distances in either direction, the table, and the pairs."""
    away = np.array([[min(_apart(a, b), _apart(a[::-1], b)) for b in table] for a in lines])
    rows, columns = linear_sum_assignment(away)
    one, two = np.concatenate(lines), np.concatenate(table)
    apart = np.linalg.norm(one[:, None] - two[None], axis=2)
    unlike = float(apart.min(axis=0).mean() + apart.min(axis=1).mean())
    pairs = [(int(i), int(j)) for i, j in zip(rows, columns, strict=True)]
    return unlike + float(away[rows, columns].mean()), table, pairs


def _dots(table: Sequence[GlyphStroke]) -> set[int]:
    """Which strokes of a letter are dots."""
    side = float(np.ptp(np.concatenate([one.median for one in table]), axis=0).max())
    return {k for k, one in enumerate(table) if line_length(one.median) < _LISTED_DOT * side}


def _in_unit_box(lines: Sequence[AnyArray]) -> list[np.ndarray]:
    """Lines evenly resampled, all together in a box from 0 to 1."""
    every = np.concatenate(lines)
    low, size = every.min(axis=0), np.ptp(every, axis=0)
    size = np.maximum(size, _FLAT * max(float(size.max()), 1e-12))
    return [_evenly((line - low) / size) for line in lines]


def _evenly(line: AnyArray) -> np.ndarray:
    return resample(line, max(line_length(line), 1e-9) / (_POINTS - 1), _POINTS)[:_POINTS]


def _same_course(line: AnyArray, other: AnyArray) -> bool:
    if line_length(line) < _DOT:
        return True
    if _is_ring(line) and _is_ring(other):
        return _turn(line) * _turn(other) > 0.0
    return _along(line, other) < _SURELY * _along(line[::-1], other)


def _along(one: AnyArray, two: AnyArray) -> float:
    """Measure the distance of two lines by time warping.

    At an even pace a bow with a swash before it is nearer to the same bow gone backwards.
    """
    away = np.linalg.norm(one[:, None] - two[None], axis=2)
    total = np.full((len(one) + 1, len(two) + 1), np.inf)
    total[0, 0] = 0.0
    for i, row in enumerate(away, start=1):
        for j, step in enumerate(row, start=1):
            total[i, j] = step + min(total[i - 1, j], total[i, j - 1], total[i - 1, j - 1])
    return float(total[-1, -1])


def _apart(one: AnyArray, two: AnyArray) -> float:
    return float(np.linalg.norm(one - two, axis=1).mean())


def _is_ring(line: AnyArray) -> bool:
    return bool(np.linalg.norm(line[-1] - line[0]) < _CLOSED * line_length(line))


def _turn(line: AnyArray) -> float:
    """Twice the area that a line goes around, positive against the clock."""
    x, y = line.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
