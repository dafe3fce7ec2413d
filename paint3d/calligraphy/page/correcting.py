"""Correction of a page's strokes: reversing, reordering, joining, splitting, leaving out.

A page under correction never changes; each correction makes another one. Strokes lie where they do
on the page, and those of one piece follow each other. Ink is neither made nor lost: parts of a
split stroke together are its region, and a joined one is that of both, with a bridge where they lie
apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import Box, GlyphStroke
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import arc_lengths, points_at
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = ["CorrectedPage", "CorrectedStroke", "halves_at"]

_GRID = 1e-3  # glyph units: to which a file of strokes is rounded
_NEAREST_END = 0.02  # of a stroke's length: a cut nearer to an end is none
_MOST_SAMPLES = 300  # along a stroke, to find which half a point belongs to
_STANDS_OUT = 0.25  # of a box: so far letters of a font may stand out of theirs
_CRUMB = 1.0  # square units: smaller bits that touch neither half are rounding


@dataclass(frozen=True, eq=False)
class CorrectedStroke:
    """A stroke under correction.

    Attributes
    ----------
    stroke : GlyphStroke
        Where it lies on the page, glyph units.
    piece : int
        Which piece of the page it belongs to.
    is_left_out : bool
        Whether it is not to be written.
    """

    stroke: GlyphStroke
    piece: int
    is_left_out: bool = False


@dataclass(frozen=True, eq=False)
class CorrectedPage:
    """A page and its strokes as they were corrected; `of` begins one.

    Attributes
    ----------
    base : Page
        As it was.
    strokes : tuple of CorrectedStroke
        In writing order, those of a piece one after another.
    """

    base: Page
    strokes: tuple[CorrectedStroke, ...]
    _first: tuple[CorrectedStroke, ...] = field(repr=False)

    @classmethod
    def of(cls, page: Page) -> CorrectedPage:
        """A page before any correction."""
        strokes = tuple(
            CorrectedStroke(_translate(stroke, _to_page(piece)), k)
            for k, piece in enumerate(page.pieces)
            for stroke in piece.glyph.strokes
        )
        return cls(page, strokes, strokes)

    @property
    def is_changed(self) -> bool:
        """True if any correction was made."""
        return self.strokes != self._first

    def number(self, k: int) -> tuple[int, int]:
        """A stroke's position in its piece, counted from 1, and the number of strokes there."""
        mine = self._strokes_of_piece(self.strokes[k].piece)
        return mine.index(k) + 1, len(mine)

    @property
    def numbers(self) -> list[int]:
        """Position of each stroke in its piece, counted from 1."""
        counts = [0] * len(self.base.pieces)
        numbers = []
        for one in self.strokes:
            counts[one.piece] += 1
            numbers.append(counts[one.piece])
        return numbers

    def text(self, k: int) -> str:
        """Text of the piece that a stroke belongs to."""
        return self.base.pieces[self.strokes[k].piece].glyph.text

    # -- corrections ------------------------------------------------------------------------

    def reverse(self, k: int) -> CorrectedPage:
        """Stroke k written the other way."""
        return self._replace_stroke(
            k, replace(self.strokes[k], stroke=_reverse_order(self.strokes[k].stroke))
        )

    def leave_out(self, k: int, on: bool = True) -> CorrectedPage:
        """Stroke k left out, or taken in again."""
        return self._replace_stroke(k, replace(self.strokes[k], is_left_out=on))

    def move(self, k: int, by: int) -> tuple[CorrectedPage, int]:
        """Stroke k later in its piece by so many, or earlier; and its position then."""
        mine = self._strokes_of_piece(self.strokes[k].piece)
        to = min(max(k + by, mine[0]), mine[-1])
        others = [one for j, one in enumerate(self.strokes) if j != k]
        return self._replace_all([*others[:to], self.strokes[k], *others[to:]]), to

    def move_piece(self, k: int, by: int) -> tuple[CorrectedPage, int]:
        """The piece of stroke k later by so many, or earlier; and the stroke's position then."""
        order = list(dict.fromkeys(one.piece for one in self.strokes))
        piece = self.strokes[k].piece
        at = order.index(piece)
        order.insert(min(max(at + by, 0), len(order) - 1), order.pop(at))
        strokes = [one for p in order for one in self.strokes if one.piece == p]
        return self._replace_all(strokes), strokes.index(self.strokes[k])

    def leave_out_piece(self, k: int, on: bool = True) -> CorrectedPage:
        """All strokes of the piece of stroke k left out, or taken in again."""
        piece = self.strokes[k].piece
        return self._replace_all(
            replace(one, is_left_out=on) if one.piece == piece else one for one in self.strokes
        )

    def join(self, k: int, other: int) -> tuple[CorrectedPage, int]:
        """Stroke k and another as one, in the direction of k; and its position then.

        They meet at those ends that lie nearest to each other.

        Raises
        ------
        InputError
            If they are the same, or one has no area.
        """
        if k == other:
            raise InputError("a stroke cannot be joined to itself; choose another one")
        joined = replace(
            self.strokes[k],
            stroke=_join_strokes(self.strokes[k].stroke, self.strokes[other].stroke),
        )
        strokes = [joined if j == k else one for j, one in enumerate(self.strokes) if j != other]
        return self._replace_all(strokes), strokes.index(joined)

    def split(self, k: int, point: Sequence[float] | AnyArray) -> CorrectedPage:
        """Stroke k as two, cut across its line at the point nearest to a point of the page.

        Raises
        ------
        InputError
            If that is an end of it.
        """
        halves = halves_at(self.strokes[k].stroke, np.asarray(point, np.float64))
        strokes = [*self.strokes]
        strokes[k : k + 1] = [replace(self.strokes[k], stroke=half) for half in halves]
        return self._replace_all(strokes)

    # -- what is there ----------------------------------------------------------------------

    def stroke_at(self, point: Sequence[float] | AnyArray, reach: float) -> int | None:
        """The stroke that a point of the page lies on, or that is nearest; None beyond `reach`.

        Where strokes cross it is that whose line is nearest.
        """
        import shapely

        there = shapely.Point(*point)
        best, nearest = (np.inf, np.inf), None
        for k, one in enumerate(self.strokes):
            off = shapely.distance(one.stroke.polygon(), there)
            line = shapely.distance(shapely.LineString(one.stroke.median), there)
            if off <= reach and (off, line) < best:
                best, nearest = (float(off), float(line)), k
        return nearest

    def page(self) -> Page:
        """The page with what is to be written.

        Pieces that were not touched are the page's own.

        Raises
        ------
        InputError
            If every stroke is left out.
        """
        order = list(dict.fromkeys(one.piece for one in self.strokes))
        pieces = [self._make_piece(p) for p in order]
        written = tuple(piece for piece in pieces if piece.glyph.strokes)
        return replace(self.base, pieces=written)

    def _make_piece(self, p: int) -> Piece:
        piece = self.base.pieces[p]
        mine = [one for one in self.strokes if one.piece == p]
        if mine == [one for one in self._first if one.piece == p]:
            return piece
        back = -_to_page(piece)
        strokes = tuple(_translate(one.stroke, back) for one in mine if not one.is_left_out)
        box = _bound_strokes(piece.glyph.box, strokes)
        glyph = replace(piece.glyph, strokes=strokes, box=box)
        moved = np.array(glyph.middle) - piece.glyph.middle
        return Piece(glyph, (piece.at[0] + float(moved[0]), piece.at[1] + float(moved[1])))

    def _strokes_of_piece(self, piece: int) -> list[int]:
        return [j for j, one in enumerate(self.strokes) if one.piece == piece]

    def _replace_stroke(self, k: int, changed: CorrectedStroke) -> CorrectedPage:
        return self._replace_all(changed if j == k else one for j, one in enumerate(self.strokes))

    def _replace_all(self, strokes: Iterable[CorrectedStroke]) -> CorrectedPage:
        return replace(self, strokes=tuple(strokes))


# -- strokes ------------------------------------------------------------------------------------


def _to_page(piece: Piece) -> NDArray[np.float64]:
    """Transform of a piece's own units to the page."""
    return np.array(piece.at) - piece.glyph.middle


def _translate(stroke: GlyphStroke, by: AnyArray) -> GlyphStroke:
    return stroke.mapped(lambda points: points + by)


def _reverse_order(stroke: GlyphStroke) -> GlyphStroke:
    return replace(stroke, median=stroke.median[::-1], dryness=stroke.dryness[::-1])


def _bound_strokes(box: Box, strokes: Sequence[GlyphStroke]) -> Box:
    """A piece's box, enlarged to all its strokes where some stand far out of it."""
    if not strokes:
        return box
    points = np.concatenate([stroke.outline for stroke in strokes])
    low, high = np.minimum(points.min(axis=0), box[:2]), np.maximum(points.max(axis=0), box[2:])
    reach = _STANDS_OUT * max(box[2] - box[0], box[3] - box[1])
    if (low >= np.array(box[:2]) - reach).all() and (high <= np.array(box[2:]) + reach).all():
        return box
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def halves_at(stroke: GlyphStroke, point: AnyArray) -> tuple[GlyphStroke, GlyphStroke]:
    """A stroke cut in two across its line, at the point nearest to a point (2,).

    Every point of its region goes to the half whose line is nearest.

    Raises
    ------
    InputError
        If that is an end of it.
    """
    import shapely

    line = shapely.LineString(stroke.median)
    cut, length = float(line.project(shapely.Point(*point))), float(line.length)
    if not _NEAREST_END * length < cut < (1.0 - _NEAREST_END) * length:
        raise InputError("the cut lies at the stroke's end; expected a place between its ends")
    middle = points_at(stroke.median, np.array([cut]))
    along = arc_lengths(stroke.median)
    lines = (
        np.concatenate([stroke.median[along < cut], middle]),
        np.concatenate([middle, stroke.median[along > cut]]),
    )
    regions = _part_region(stroke.polygon(), stroke.median, cut)
    drynesses = _part_dryness(stroke.dryness, cut / length)
    first, second = (
        GlyphStroke.filling(region, own, dry, stroke.strength)
        for region, own, dry in zip(regions, lines, drynesses, strict=True)
    )
    return first, second


def _part_region(region: Polygon, median: AnyArray, cut: float) -> tuple[Polygon, Polygon]:
    """A region in two, by which part of its line is nearest: the cells of points along it."""
    import shapely

    length = float(arc_lengths(median)[-1])
    step = max(length / _MOST_SAMPLES, 0.125 * float(region.area) / length)
    before = np.arange(cut - 0.5 * step, 0.0, -step)  # the cut is the border of two cells
    after = np.arange(cut + 0.5 * step, length, step)
    if not len(before) or not len(after):
        before, after = np.array([0.5 * cut]), np.array([1.5 * cut])
    points_along = np.round(points_at(median, np.concatenate([before, after])) / _GRID) * _GRID
    # a line that comes back on itself has some points twice
    _, first = np.unique(points_along, axis=0, return_index=True)
    distinct = np.sort(first)
    points = shapely.points(points_along[distinct])
    cells = shapely.get_parts(
        shapely.voronoi_polygons(shapely.multipoints(points), extend_to=region)
    )
    of_point, cell = shapely.STRtree(cells).query(points, predicate="within")
    mine = shapely.union_all(cells[cell[distinct[of_point] < len(before)]])
    one = shapely.intersection(region, mine, grid_size=_GRID)
    other = shapely.difference(region, mine, grid_size=_GRID)
    return _merge_small_parts(_polygons(one), _polygons(other))


def _polygons(shape: Any) -> list[Polygon]:
    """The areas of a shape, largest first."""
    import shapely

    parts = shapely.get_parts(shape)
    areas = [part for part in parts if part.geom_type == "Polygon" and not part.is_empty]
    return sorted(areas, key=lambda part: -part.area)


def _merge_small_parts(one: list[Polygon], other: list[Polygon]) -> tuple[Polygon, Polygon]:
    """Keep the largest part of each; merge smaller ones into the one they touch most."""
    if not one or not other:
        raise InputError("the cut parts nothing; expected a place within the stroke's ink")
    wholes, loose = [one[0], other[0]], [*one[1:], *other[1:]]
    while loose:
        touching = [
            (float(whole.boundary.intersection(bit.boundary).length), w, b)
            for b, bit in enumerate(loose)
            for w, whole in enumerate(wholes)
        ]
        length, w, b = max(touching)
        grown = _polygons(wholes[w].union(loose[b], grid_size=_GRID))
        bit = loose.pop(b)
        if length > 0.0 and len(grown) == 1:
            wholes[w] = grown[0]
        elif bit.area > _CRUMB:
            wholes[w] = _bridge_regions(wholes[w], bit, 0.1 * float(np.sqrt(bit.area)))
    return wholes[0], wholes[1]


def _part_dryness(
    dryness: Sequence[float], fraction: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Fractions left bare at even stations, of the two parts of a stroke."""
    n = len(dryness)
    if not n:
        return (), ()
    first = min(max(round(n * fraction), 1), max(n - 1, 1))
    counts = first, max(n - first, 1)
    spans = (0.0, fraction), (fraction, 1.0)
    parts = [
        _resample_dryness(dryness, low, high, m)
        for (low, high), m in zip(spans, counts, strict=True)
    ]
    return parts[0], parts[1]


def _resample_dryness(
    dryness: Sequence[float], low: float, high: float, n: int
) -> tuple[float, ...]:
    """Fractions at n even stations of a part of a stroke, from those of all of it."""
    at = low + (np.arange(n) + 0.5) / n * (high - low)
    known = (np.arange(len(dryness)) + 0.5) / len(dryness)
    return tuple(np.round(np.interp(at, known, dryness), 3).tolist())


def _join_strokes(one: GlyphStroke, other: GlyphStroke) -> GlyphStroke:
    """Two strokes as one, in the direction of the first."""
    pairs = (
        (one, other), (one, _reverse_order(other)), (other, one), (_reverse_order(other), one),
    )  # fmt: skip
    gaps = [float(np.linalg.norm(a.median[-1] - b.median[0])) for a, b in pairs]
    a, b = pairs[int(np.argmin(gaps))]
    shapes = a.polygon(), b.polygon()
    if min(shape.area for shape in shapes) <= 0.0:
        raise InputError("a stroke without area was to be joined; expected one with ink")
    merged = _polygons(shapes[0].union(shapes[1], grid_size=_GRID))
    lengths = [float(arc_lengths(part.median)[-1]) for part in (a, b)]
    region = merged[0]
    if len(merged) > 1:
        widths = [s.area / max(w, 1e-9) for s, w in zip(shapes, lengths, strict=True)]
        region = _bridge_regions(*shapes, 0.4 * min(widths), (a.median[-1], b.median[0]))
    gap = min(gaps)
    following = b.median[1:] if gap <= _GRID else b.median
    dryness: tuple[float, ...] = ()
    if a.dryness or b.dryness:
        dryness = _concatenate_dryness((a.dryness, b.dryness), lengths)
    strength = float(np.average([a.strength, b.strength], weights=np.maximum(lengths, 1e-9)))
    return GlyphStroke.filling(region, np.concatenate([a.median, following]), dryness, strength)


def _concatenate_dryness(
    drynesses: Sequence[Sequence[float]], lengths: Sequence[float]
) -> tuple[float, ...]:
    """Fractions at even stations of two strokes as one; a stroke that does not say is wet."""
    known = [dry or (0.0,) for dry in drynesses]
    at = [(np.arange(len(d)) + 0.5) / len(d) * w for d, w in zip(known, lengths, strict=True)]
    stations = np.concatenate([at[0], lengths[0] + at[1]])
    n = len(stations)
    wanted = (np.arange(n) + 0.5) / n * sum(lengths)
    return tuple(np.round(np.interp(wanted, stations, np.concatenate(known)), 3).tolist())


def _bridge_regions(
    one: Polygon,
    other: Polygon,
    half_width: float,
    ends: tuple[AnyArray, AnyArray] | None = None,
) -> Polygon:
    """Two regions that lie apart as one, with ink between their ends, or where they are nearest."""
    import shapely

    lines = [shapely.shortest_line(one, other)]
    if ends is not None:
        lines.append(shapely.LineString(np.stack(ends)))
    bridge = shapely.union_all(lines).convex_hull.buffer(max(half_width, _GRID * 10.0))
    return _polygons(shapely.union_all([one, other, bridge], grid_size=_GRID))[0]
