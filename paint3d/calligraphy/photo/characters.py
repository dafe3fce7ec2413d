"""Ink of a sheet divided into characters, by the gaps between them or by their number."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = ["Character", "characters_of"]

_APART = 1.2  # stroke widths between inks of two characters, at the least
_ALIKE = 0.5  # of the usual size: smaller inks join their neighbour
_CELLS = 240  # that a column is cut at
_UNEVEN = 3.0  # price of a character that is twice as long as its share, in ink that a cut crosses


@dataclass(frozen=True, eq=False)
class Character:
    """Ink that belongs together.

    Attributes
    ----------
    text : str
        The character where it is known, else its number.
    shape : MultiPolygon
        Pixels, y down.
    """

    text: str
    shape: MultiPolygon

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, pixels."""
        left, low, right, high = self.shape.bounds
        return right - left, high - low


def characters_of(
    parts: Sequence[Polygon], width: float, lines: Sequence[str] = (), *, columns: bool = True
) -> list[Character]:
    """Group the connected inks of a sheet into characters, in reading order.

    Parameters
    ----------
    parts : sequence of shapely.Polygon
        Pixels, y down.
    width : float
        Of a usual stroke, pixels.
    lines : sequence of str
        The characters of each column, from the right, or of each row; a single one may stand for
        all of them together.
    columns : bool

    Raises
    ------
    InputError
        If there are fewer inks than characters.
    """
    if not lines:
        return _group_by_gaps(parts, width, columns)
    n = sum(map(len, lines))
    if len(parts) < n:
        raise InputError(
            "the text has {n} characters, the sheet {parts} inks apart from each other; expected "
            "no fewer: give no text where characters are joined",
            hint="leave --text out",
            n=n,
            parts=len(parts),
        )
    boxes = np.array([part.bounds for part in parts])
    if not columns:
        boxes = boxes[:, [1, 0, 3, 2]]
    boxes_of = _boxes_in_lines(boxes, list(lines), columns)
    text = "".join(lines)
    return [_make_character(text[k], [parts[i] for i in boxes_of[k]]) for k in range(n)]


def _make_character(text: str, parts: Sequence[Polygon]) -> Character:
    import shapely

    return Character(text, shapely.MultiPolygon(parts))


# -- by gaps ------------------------------------------------------------------------------------


def _group_by_gaps(parts: Sequence[Polygon], width: float, columns: bool) -> list[Character]:
    """Group inks whose boxes overlap or are near each other; small ones join the nearest."""
    boxes = np.array([part.bounds for part in parts])
    groups = [[k] for k in range(len(parts))]
    near = _APART * width
    spans = boxes
    gaps, grown = _box_gaps(spans, spans), _joined_sides(spans, spans)
    np.fill_diagonal(gaps, np.inf)
    while len(groups) > 1:
        sizes = np.maximum(spans[:, 2] - spans[:, 0], spans[:, 3] - spans[:, 1])
        usual = float(np.quantile(sizes, 0.8))
        is_small = sizes < _ALIKE * usual
        joins = (gaps < near) | is_small | is_small[:, None]
        joins &= (grown < 1.35 * usual) | (gaps <= 0.0)
        price = np.where(joins, gaps, np.inf)
        i, j = sorted(map(int, np.unravel_index(int(np.argmin(price)), price.shape)))
        if not price[i, j] <= 0.5 * usual:
            break
        groups[i] += groups.pop(j)
        spans, gaps, grown = (
            np.delete(spans, j, 0), _drop_row(gaps, j), _drop_row(grown, j)
        )  # fmt: skip
        spans[i] = _bound_boxes(boxes[groups[i]])
        gaps[i] = gaps[:, i] = _box_gaps(spans[i : i + 1], spans)
        grown[i] = grown[:, i] = _joined_sides(spans[i : i + 1], spans)
        gaps[i, i] = np.inf
    spans = np.array([_bound_boxes(boxes[group]) for group in groups])
    order = _reading_order(spans, columns)
    return [_make_character(str(n + 1), [parts[i] for i in groups[k]]) for n, k in enumerate(order)]


def _bound_boxes(boxes: AnyArray) -> NDArray[np.float64]:
    return np.concatenate([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])


def _box_gaps(spans: AnyArray, others: AnyArray) -> NDArray[np.float64]:
    """Distances of boxes from others: (K, L); negative where they overlap."""
    low, high = spans[:, None, :2], spans[:, None, 2:]
    apart = np.maximum(low - others[None, :, 2:], others[None, :, :2] - high)
    gaps: NDArray[np.float64] = np.where(
        (apart > 0.0).all(axis=2), np.hypot(apart[..., 0], apart[..., 1]), apart.max(axis=2)
    )
    return gaps


def _joined_sides(spans: AnyArray, others: AnyArray) -> NDArray[np.float64]:
    """Longer side (K, L) of the box around two boxes."""
    low = np.minimum(spans[:, None, :2], others[None, :, :2])
    high = np.maximum(spans[:, None, 2:], others[None, :, 2:])
    result: NDArray[np.float64] = (high - low).max(axis=2)
    return result


def _drop_row(table: AnyArray, k: int) -> NDArray[np.float64]:
    """A square table without a row and its column."""
    left: NDArray[np.float64] = np.delete(np.delete(table, k, 0), k, 1)
    return left


def _reading_order(spans: AnyArray, columns: bool) -> list[int]:
    """Columns from the right, each downwards; or rows from the top, each to the right."""
    middle = 0.5 * (spans[:, :2] + spans[:, 2:])
    across = -middle[:, 0] if columns else middle[:, 1]
    along = middle[:, 1] if columns else middle[:, 0]
    size = spans[:, 2] - spans[:, 0] if columns else spans[:, 3] - spans[:, 1]
    order = np.argsort(across, kind="stable")
    line, lines = 0, np.zeros(len(spans), int)
    begin = across[order[0]]
    for k in order:
        if across[k] - begin > 0.6 * float(np.median(size)):
            line, begin = line + 1, across[k]
        lines[k] = line
    return sorted(range(len(spans)), key=lambda k: (lines[k], along[k]))


# -- by how many there are ----------------------------------------------------------------------


def _boxes_in_lines(boxes: AnyArray, lines: list[str], columns: bool) -> list[list[int]]:
    """Boxes (K, 4) of each character; lines run along y, side by side along x."""
    counts = [len(line) for line in lines]
    across = 0.5 * (boxes[:, 0] + boxes[:, 2])
    bounds = _line_spans(boxes, sum(counts))
    if len(lines) > 1 and len(bounds) != len(lines):
        bounds = list(pairwise(_find_cuts(boxes[:, [0, 2]], len(lines))))
    if columns:
        bounds = bounds[::-1]
    if len(lines) == 1 and len(bounds) > 1:
        counts = _count_by_length(boxes, bounds, counts[0])
    groups: list[list[int]] = []
    if len(bounds) != len(counts):
        bounds = [(-math.inf, math.inf)]
    for (left, right), n in zip(bounds, counts, strict=True):
        mine = np.flatnonzero((across >= left) & (across < right))
        groups += _cut_line(boxes, mine, n)
    return groups


def _line_spans(boxes: AnyArray, most: int) -> list[tuple[float, float]]:
    """Spans of lines that no ink joins, small ones with their neighbour; `most` or fewer."""
    order = np.argsort(boxes[:, 0])
    spans: list[list[float]] = []
    for k in order:
        left, right = boxes[k, 0], boxes[k, 2]
        if spans and left <= spans[-1][1]:
            spans[-1][1] = max(spans[-1][1], right)
        else:
            spans.append([left, right])
    widest = max(right - left for left, right in spans)
    while len(spans) > 1:
        gaps = [b[0] - a[1] for a, b in pairwise(spans)]
        joined = [b[1] - a[0] for a, b in pairwise(spans)]
        can = [k for k in range(len(gaps)) if joined[k] < 1.25 * widest]
        if not can and len(spans) <= most:
            break
        k = min(can or range(len(gaps)), key=lambda i: gaps[i])
        spans[k : k + 2] = [[spans[k][0], spans[k + 1][1]]]
        widest = max(right - left for left, right in spans)
    return [(left, right + 1e-9) for left, right in spans]


def _count_by_length(boxes: AnyArray, bounds: list[tuple[float, float]], n: int) -> list[int]:
    """Number of n characters in each line, by the lines' lengths; at least one."""
    lengths = []
    for left, right in bounds:
        across = 0.5 * (boxes[:, 0] + boxes[:, 2])
        mine = boxes[(across >= left) & (across < right)]
        lengths.append(float(mine[:, 3].max() - mine[:, 1].min()))
    counts = [1] * len(bounds)
    while sum(counts) < n:
        counts[int(np.argmax(np.array(lengths) / counts))] += 1
    return counts


def _cut_line(boxes: AnyArray, mine: AnyArray, n: int) -> list[list[int]]:
    """The boxes of one line as n characters."""
    if not len(mine):
        raise InputError(
            "the sheet has a line without ink; expected ink in every line of the text",
            hint="--text",
        )
    cuts = _find_cuts(boxes[mine][:, [1, 3]], n)
    middles = 0.5 * (boxes[mine, 1] + boxes[mine, 3])
    which = np.clip(np.searchsorted(cuts, middles, side="right") - 1, 0, n - 1)
    groups = [mine[which == k].tolist() for k in range(n)]
    if not all(groups):
        raise InputError(
            "{n} characters were expected in a line where {groups} were found; expected the text "
            "with a line break after each column or row",
            hint="--text; --layout row for rows",
            n=n,
            groups=sum(map(bool, groups)),
        )
    return groups


def _find_cuts(spans: AnyArray, n: int) -> NDArray[np.float64]:
    """Positions (n + 1,) that part inks with spans (K, 2) into n, evenly and crossing few.

    The least of what the cuts cross and of how uneven the parts are, by dynamic programming.
    """
    low, high = float(spans[:, 0].min()), float(spans[:, 1].max())
    grid = np.linspace(low, high + 1e-6, _CELLS + 1)
    longest = max(float((spans[:, 1] - spans[:, 0]).max()), 1e-9)
    inside = np.minimum(grid[:, None] - spans[:, 0], spans[:, 1] - grid[:, None])
    crossed = np.clip(inside, 0.0, None).sum(axis=1) / longest
    length = (high - low) / n
    best = np.full((n + 1, len(grid)), np.inf)
    came = np.zeros((n + 1, len(grid)), int)
    best[0, 0] = 0.0
    uneven = _UNEVEN * (np.subtract.outer(grid, grid) / length - 1.0) ** 2  # [end, start]
    uneven[np.triu_indices(len(grid))] = np.inf
    for k in range(1, n + 1):
        total = best[k - 1][None] + uneven + crossed[:, None] * (k < n)
        came[k] = total.argmin(axis=1)
        best[k] = total.min(axis=1)
    at = [len(grid) - 1]
    for k in range(n, 0, -1):
        at.append(int(came[k, at[-1]]))
    return grid[at[::-1]]
