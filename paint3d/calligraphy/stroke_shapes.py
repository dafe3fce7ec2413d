"""Outlines for strokes that are only centre lines: what a brush makes of each type of stroke.

For every type the table says how wide a stroke is, given its length and how crowded the character
is, and where sections across each of its segments end, to the left and to the right: cut entries,
flat feet and the shoulders of folds are in these. The segments of a stroke are laid on its line and
joined.
"""

from __future__ import annotations

import importlib.resources
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.kanjivg import LineStroke
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import cross_2d, headings_of, interpolate, line_length, resample_to
from paint3d.errors import InputError

__all__ = [
    "BODY",
    "SOURCE_OF_SHAPES",
    "ZONE",
    "StrokeSegment",
    "corners_of",
    "cut_line",
    "is_hooked",
    "shape_strokes",
]

# ---- Segments ------------------------------------------------------------------------------------
# Strokes as segments: a stroke's line is cut at its sharp corners, each piece has stations.
#
# What a brush does at the beginning and the end of a segment depends on the width, what it does
# between on the length. A segment therefore has a zone at each end, as long as the half width asks,
# and a body.


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
_ZONE_WIDTHS, _ZONE_FRACTION = 4.0, 0.4


def corners_of(kind: str) -> int:
    """Number of sharp corners of a stroke of a type."""
    return _CORNERS.get(kind[:1], 0)


def is_hooked(kind: str) -> bool:
    """Return whether a stroke of a type ends in a hook."""
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
        return line_length(self.points)

    def stations(self, half_width: float, before: float, after: float) -> NDArray[np.float64]:
        """Distances (2 ZONE + BODY,) along the segment; it goes on straight before and after."""
        zone = min(_ZONE_WIDTHS * half_width, _ZONE_FRACTION * self.length)
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
        along = np.linspace(0.0, self.length, len(self.points))
        inside = np.clip(distances, 0.0, self.length)
        tangents = np.gradient(self.points, axis=0)
        tangents = gaussian_filter1d(tangents, 0.04 * len(along), axis=0, mode="nearest")
        tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-9)
        point, tangent = (interpolate(inside, along, values) for values in (self.points, tangents))
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
        point = point + (np.asarray(distances) - inside)[:, None] * tangent
        return point, np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)


def cut_line(line: AnyArray, n_corners: int, hook: float = 0.0) -> list[StrokeSegment]:
    """Cut a line (N, 2) at its sharpest corners into segments.

    One of the corners of a line that ends in a hook lies within the fraction `hook` of its end.
    """
    points = resample_to(line, _SAMPLES)
    cuts = [0, *sorted(_find_corners(points, n_corners, hook)), _SAMPLES - 1]
    segments = []
    for first, last in pairwise(cuts):
        segments.append(
            StrokeSegment(_smooth_segment(resample_to(points[first : last + 1], _SAMPLES)))
        )
    return segments


def _find_corners(points: AnyArray, n: int, hook: float) -> list[int]:
    """Indices of the n sharpest corners, a segment apart from each other and from the ends."""
    window = int(_WINDOW * _SAMPLES)
    margin = max(2, int(_LEAST_SEGMENT * _SAMPLES))
    turning = np.zeros(_SAMPLES)
    for k in range(margin, _SAMPLES - margin):
        reach = min(window, k, _SAMPLES - 1 - k)
        back, onward = points[k] - points[k - reach], points[k + reach] - points[k]
        turning[k] = abs(np.arctan2(cross_2d(back, onward), back @ onward))
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


def _smooth_segment(points: AnyArray) -> NDArray[np.float64]:
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


# ---- Shapes of strokes ---------------------------------------------------------------------------


SOURCE_OF_SHAPES = "widths learned from hanzi-writer-data (Arphic Public License)"

_LIKE = {"㇅": "㇈", "㇊": "㇈", "㇌": "㇋", "㇡": "㇉", "一": "㇐", "㇞": "㇉"}
_HOOK = 0.16  # of the length: hooks of centre lines are small
_FINE = 160  # sections along a segment
_ROUNDING = 1.5  # units: the radius that corners of an outline are rounded with
_STEADY, _STRAYS = 0.8, math.radians(14.0)  # where the last heading is read; a bend from there
_LEAST_HALF, _MOST_HALF = 6.0, 70.0  # units
# Of characters of few strokes a brush makes these bolder than the printed script that widths were
# learned from: how much more at most, and after how many strokes a third of it is left
_BOLDER, _FEW = 0.28, 14.0


@lru_cache(maxsize=1)
def _shapes() -> dict[str, dict[str, Any]]:
    file = importlib.resources.files("paint3d.calligraphy").joinpath("data/stroke_shapes.json")
    result: dict[str, dict[str, Any]] = json.loads(file.read_text("utf-8"))["shapes"]
    return result


def shape_strokes(lines: Sequence[LineStroke], name: str = "glyph") -> list[GlyphStroke]:
    """Give the strokes of one character their outlines.

    Parameters
    ----------
    lines : sequence of LineStroke
        All strokes of the character: how many there are decides how fine they are.
    name : str
        What to call the character in messages.

    Raises
    ------
    InputError
        If a line is too short for a stroke.
    """
    return [
        _shape_stroke(line, len(lines), f"{name}: stroke {k + 1}") for k, line in enumerate(lines)
    ]


def _shape_stroke(stroke: LineStroke, n_strokes: int, name: str) -> GlyphStroke:
    kind, shape = _shape_of(stroke)
    segments = cut_line(stroke.line, len(shape["legs"]) - 1, _HOOK if is_hooked(kind) else 0.0)
    if len(segments) != len(shape["legs"]):
        kind, shape = _guess_type(stroke.line)
        segments = cut_line(stroke.line, 0)
    if is_hooked(kind) and len(segments) > 1:
        segments[-2] = _drop_end_bend(segments[-2])
        segments[-1] = _make_hook(segments[-2], segments[-1], shape["last"])
    length = sum(segment.length for segment in segments)
    law = shape["law"]
    half = math.exp(law[0] + law[1] * math.log(n_strokes) + law[2] * math.log(max(length, 1.0)))
    half *= 1.0 + _BOLDER * math.exp(-n_strokes / _FEW)
    half = min(max(half, _LEAST_HALF), _MOST_HALF)
    outline = _join_outlines(_segment_outlines(segments, shape["legs"], half), name)
    median = np.concatenate([segment.points[k > 0 :] for k, segment in enumerate(segments)])
    return GlyphStroke(outline, median[:: max(1, len(median) // 60)])


def _shape_of(stroke: LineStroke) -> tuple[str, dict[str, Any]]:
    """The shape of a stroke's type, or of the type most like it."""
    shapes = _shapes()
    for kind in (stroke.kind, stroke.kind[:1], _LIKE.get(stroke.kind[:1], "")):
        if kind in shapes:
            return kind, shapes[kind]
    return _guess_type(stroke.line)


def _guess_type(line: AnyArray) -> tuple[str, dict[str, Any]]:
    """Type of a line that has none: level, falling to the left, to the right, or upright."""
    x, y = line[-1] - line[0]
    if abs(y) < 0.4 * abs(x):
        kind = "㇐"
    elif abs(x) < 0.3 * abs(y):
        kind = "㇑"
    else:
        kind = "㇒" if x < 0.0 else "㇏"
    return kind, _shapes()[kind]


def _drop_end_bend(segment: StrokeSegment) -> StrokeSegment:
    """A segment without the bend at its end with which it leads into a hook."""
    steps = np.diff(segment.points, axis=0)
    heading = headings_of(steps)
    n = len(heading)
    first = int(_STEADY * n)
    straying = np.abs(heading[first:] - heading[first]) > _STRAYS
    last = first + int(np.argmax(straying)) if straying.any() else n
    straight = segment.points[: last + 1]
    beyond = float((segment.points[-1] - straight[-1]) @ steps[last - 1])
    missing = max(0.0, beyond / float(np.linalg.norm(steps[0])))
    end = straight[-1] + missing * steps[last - 1] / max(np.linalg.norm(steps[last - 1]), 1e-9)
    line = np.vstack([straight, end]) if missing > 0.0 else straight
    return cut_line(line, 0)[0]


def _make_hook(before: StrokeSegment, hook: StrokeSegment, last: Sequence[float]) -> StrokeSegment:
    """A straight hook, as long and as sharply turned as a brush makes it."""
    length, turn = last
    direction = before.points[-1] - before.points[-30]
    angle = math.atan2(direction[1], direction[0]) + turn
    end = before.points[-1] + length * np.array([math.cos(angle), math.sin(angle)])
    return StrokeSegment(np.linspace(before.points[-1], end, len(hook.points)))


def _segment_outlines(
    segments: Sequence[StrokeSegment], shapes: Sequence[dict[str, Any]], half: float
) -> list[AnyArray]:
    """Polygons of all segments; on the inner side of a fold one is no wider than before it."""
    outlines = []
    for k, (segment, facts) in enumerate(zip(segments, shapes, strict=True)):
        sides = {side: np.array(facts[side]) for side in ("lo", "hi")}
        if k > 0:
            inner = _inner_side(segments[k - 1], segment)
            sides[inner][:ZONE] = _limit_width(sides[inner][:ZONE], sides[inner][ZONE])
        if k + 1 < len(segments):
            inner = _inner_side(segment, segments[k + 1])
            sides[inner][-ZONE:] = _limit_width(sides[inner][-ZONE:], sides[inner][-ZONE - 1])
        outlines.append(_segment_outline(segment, {**facts, **sides}, half))
    return outlines


def _inner_side(one: StrokeSegment, two: StrokeSegment) -> str:
    a, b = one.points[-1] - one.points[-30], two.points[30] - two.points[0]
    return "hi" if cross_2d(a, b) > 0.0 else "lo"


def _limit_width(offsets: AnyArray, limit: float) -> AnyArray:
    return np.minimum(offsets, limit) if limit > 0.0 else np.maximum(offsets, limit)


def _segment_outline(
    segment: StrokeSegment, facts: dict[str, Any], half: float
) -> NDArray[np.float64]:
    """Closed polygon (N, 2) around one segment."""
    stations = segment.stations(half, half * facts["before"], half * facts["after"])
    keep = np.r_[True, np.diff(stations) > 1e-6 * half]
    at = np.linspace(stations[0], stations[-1], _FINE)
    sides = np.column_stack([facts[side][keep] for side in ("lo", "hi")])
    lo, hi = PchipInterpolator(stations[keep], sides)(at).T
    points, lefts = segment.at(at)
    left, right = points + half * hi[:, None] * lefts, points + half * lo[:, None] * lefts
    return np.concatenate([left, right[::-1]])


def _join_outlines(outlines: Sequence[AnyArray], name: str) -> NDArray[np.float64]:
    """The outline (N, 2) of all segments together, with its corners a little rounded."""
    from shapely import Polygon, unary_union

    whole = unary_union([Polygon(outline).buffer(0.0) for outline in outlines])
    whole = whole.buffer(_ROUNDING).buffer(-2.0 * _ROUNDING).buffer(_ROUNDING)
    pieces = [piece for piece in getattr(whole, "geoms", [whole]) if not piece.is_empty]
    if not pieces:
        raise InputError("{name} is too short to have a shape; expected a longer line", name=name)
    largest = max(pieces, key=lambda piece: piece.area)
    return np.asarray(largest.exterior.coords)[:-1]
