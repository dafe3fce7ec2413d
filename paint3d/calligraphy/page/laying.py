"""Layout of the pieces of a flat page on an object.

The middle of the page lies at a point of the surface. From there one goes straight up or down to a
piece's height and then along the level line, so that lines of text lie level and pieces are as far
apart along them as on the page; every piece is then laid by geodesics around its own middle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from paint3d.calligraphy.free_arc import FreeArc, Ring, in_the_way_error
from paint3d.calligraphy.glyphs import EM_UNITS, Box, Glyph
from paint3d.calligraphy.layout import (
    Layout,
    TextPlace,
    WritingArea,
    find_writing_areas,
    frames_to_try,
    start_around,
    upright_frame,
    with_suggestion,
)
from paint3d.calligraphy.page.page import Composer, Page, Piece, bounds_of
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError, MeshError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import EmSquare, SquareLimits, SurfaceFrame, lay_squares, overlapping
from paint3d.mesh.placement import SurfaceLine

__all__ = ["PlacedPiece", "lay_page"]

_LINE_FRACTIONS = (1.0, 0.8, 0.65, 0.5, 0.4, 0.3, 0.2)  # of the room there is: lines that are tried
_MOVES = (0.0, 0.3, -0.3, 0.6, -0.6, 1.0, -1.0, 1.5, -1.5)  # ems up from the point: tried in turn
_MOST_PLACES = 12
_ROUNDING = 1e-6  # of a length
_SHARED = 0.02  # of the em: corners of boxes that share this much more than on the page are apart
_SEAM = 0.5  # ems between the end of a text and where it begins anew, all around a body: at least
_MOST_MORE = 0.5 * EM_UNITS  # by which words are drawn apart along a free arc
_MOST_AT_ONCE = 2048  # pieces
_FAR = 1.5  # times the room, which other heights may have more of: what is larger is not composed


@dataclass(frozen=True, eq=False)
class PlacedPiece:
    """A glyph, and the square or box that it is written in."""

    glyph: Glyph
    square: EmSquare


def lay_page(
    surface: ClosestPoints,
    composer: Composer,
    em_mm: float,
    layout: Layout | None = None,
    limits: SquareLimits | None = None,
) -> tuple[Page, list[PlacedPiece]]:
    """Lay a page on an object.

    Parameters
    ----------
    surface : ClosestPoints
    composer : Composer
        A page, or a text whose lines are broken to the room that there is.
    em_mm : float
        1024 glyph units, mm.
    layout : Layout, optional
        Its `at`, `around`, `side` and `gap`.
    limits : SquareLimits, optional

    Returns
    -------
    Page
        As it was composed.
    list of PlacedPiece
        In writing order.

    Raises
    ------
    InputError
        If the page does not fit; the message says how large it is, and why.
    MeshError
        If there is no such position.
    """
    layout, limits = layout or Layout(), limits or SquareLimits()
    try:
        return _lay_on_area(surface, composer, em_mm, layout, limits)
    except InputError as cause:
        fault = cause

    def fits(em_mm: float, layout: Layout) -> bool:
        return bool(_lay_on_area(surface, composer, em_mm, layout, limits, most_places=1))

    raise with_suggestion(fault, em_mm, layout, fits)


def _lay_on_area(
    surface: ClosestPoints,
    composer: Composer,
    em_mm: float,
    layout: Layout,
    limits: SquareLimits,
    most_places: int = _MOST_PLACES,
) -> tuple[Page, list[PlacedPiece]]:
    fault: MeshError | None = None
    composed: Page | None = None  # in one line, or broken as little as was tried
    areas, layout = find_writing_areas(surface, layout)
    area = areas[0]  # of a couplet, the panel on the right
    for n, frame in enumerate(_frames_to_try(area, layout, em_mm)):
        if n == most_places:
            break
        sheet = _Sheet(area, em_mm, layout, limits, frame)
        for page in sheet.pages(composer):
            composed = composed or page
            try:
                return page, sheet.lay(page)
            except MeshError as cause:
                fault = fault or cause
        fault = fault or sheet.too_small
    if fault is None:
        raise MeshError(
            "{object}: there is no place to write; expected a surface",
            object=surface.mesh.name,
        )
    if composed is None:
        raise InputError(  # its advances alone show that it is too large
            "the text is {length:,.0f} mm long at this size, which does not fit on {object} "
            "({fault}); expected less to write or a smaller size",
            length=em_mm / EM_UNITS * composer.least_size(math.inf)[0],
            object=surface.mesh.name,
            fault=fault,
        )
    raise _too_large(surface, composed, em_mm, fault)


def _frames_to_try(area: WritingArea, layout: Layout, em_mm: float) -> Iterator[SurfaceFrame]:
    """Frames for the page's middle: the one asked for, or candidates one after another."""
    if layout.is_placed or layout.around:
        yield start_around(area, layout, em_mm)
        return
    turned = bool(layout.turn) or area.apex is not None
    for frame in frames_to_try(area.surface, layout.side):
        upright = area.upright(frame.normal, layout)
        yield upright_frame(area.surface, frame.origin, upright) if turned else frame


def _too_large(surface: ClosestPoints, page: Page, em_mm: float, fault: MeshError) -> InputError:
    left, lower, right, upper = page.bounds
    scale = em_mm / EM_UNITS
    width, height = scale * (right - left), scale * (upper - lower)
    return InputError(
        "{source}: {width:.0f} x {height:.0f} mm do not fit on {object} ({fault}); expected less "
        "to write, a smaller size or another place",
        source=page.source,
        width=width,
        height=height,
        object=surface.mesh.name,
        fault=fault,
    )


class _Sheet(TextPlace):
    """A page's lines up and along, around one point of a surface."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.scale = self.em_mm / EM_UNITS
        self.too_small: MeshError | None = None  # why pages were not even composed
        self._levels: dict[tuple[float, float], SurfaceLine] = {}
        self._rings: dict[float, Ring] = {}

    def pages(self, composer: Composer) -> Iterator[Page]:
        """Yield the text in one line, then broken to more and more, except if far too large.

        Of that not even the glyphs are placed, which takes seconds for thousands.
        """
        available = self._length_along(composer)
        page: Page | None = None
        for fraction in (math.inf, *_LINE_FRACTIONS):
            length = fraction * available / self.scale
            along, across = (self.scale * size for size in composer.least_size(length))
            if along > _FAR * available + 4.0 * self.em_mm or across > _FAR * self._length_across(
                composer
            ):
                self.too_small = self.too_small or self.surface_ends_error()
                continue
            following = composer.compose(length)
            if following is not page:
                page = following
                yield page

    def _length_across(self, composer: Composer) -> float:
        """Length available across the lines, mm."""
        if not composer.runs_down:
            return sum(self.climb(sign).length for sign in (1.0, -1.0))
        right = self._level_line(0.0, 1.0)
        return right.length if right.closed else right.length + self._level_line(0.0, -1.0).length

    def _length_along(self, composer: Composer) -> float:
        """Greatest length of a line of text, mm."""
        if composer.runs_down:
            return sum(self.climb(sign).length for sign in (1.0, -1.0))
        with suppress(MeshError):
            if self.layout.around and (arc := self._find_arc([0.0])) is not None:
                return arc.length + self.em_mm
        right = self._level_line(0.0, 1.0)
        if right.closed:
            return right.length
        return 2.0 * min(right.length, self._level_line(0.0, -1.0).length)

    def lay(self, page: Page) -> list[PlacedPiece]:
        """Every piece of a page; the page is moved up or down where that makes it fit.

        Raises
        ------
        MeshError
            If the surface ends within the page, or a piece has no place on it.
        """
        fault: MeshError | None = None
        for move in (0.0,) if self.layout.is_placed else _MOVES:
            try:
                laid = self._arrange(page, move * self.em_mm)
                placed = self._lay_pieces(laid, move * self.em_mm)
                self._check_apart(laid, placed)
                return placed
            except MeshError as cause:
                fault = fault or cause
        assert fault is not None
        raise fault

    def _arrange(self, page: Page, move: float) -> Page:
        """A page as it is laid; of one that goes around a body x is counted from the point."""
        if not self.layout.around:
            return page
        arc = self._find_arc(self._heights(page, move))
        if arc is not None:
            return self._lay_along(page, arc)
        if all(piece.word is not None for piece in page.pieces):
            return self._wrap_around(page, move)
        return self._spread_around(page)

    def _heights(self, page: Page, move: float) -> list[float]:
        """Middles of the lines of a page, mm above the point."""
        _, lower, _, upper = page.bounds
        middle = 0.5 * (lower + upper)
        return sorted({round(self.scale * (one.at[1] - middle) + move, 6) for one in page.pieces})

    def _find_arc(self, heights: Sequence[float]) -> FreeArc | None:
        """The free arc for lines at such heights, rising, mm; None where nothing is in the way.

        What is free beside all of them, along each: the body may be narrower at some.
        """
        arc = self.find_free_arc(self._ring_at(0.0), heights[0], heights[-1])
        if arc is None:
            return None
        rings = [self._ring_at(height) for height in (0.0, *heights)]
        girths = [ring.length / ring.n_turns for ring in rings]
        start, end = (
            best(end_of_arc * girth / girths[0] for girth in girths)
            for best, end_of_arc in ((max, arc.start), (min, arc.end))
        )
        return replace(arc, start=start, end=max(start, end))

    def _ring_at(self, height: float) -> Ring:
        if height not in self._rings:
            right, left = (self._level_line(height, sign) for sign in (1.0, -1.0))
            self._rings[height] = Ring(self.surface, right, left, self.up.up, self.em_mm)
        return self._rings[height]

    def _lay_along(self, page: Page, arc: FreeArc) -> Page:
        """A page along a free arc: drawn out a little where there is room, and in its middle.

        Words stay whole.

        Raises
        ------
        MeshError
            If it is longer than the arc.
        """
        left, _, right, _ = page.bounds
        available = (arc.length + self.em_mm) / self.scale
        if right - left > available * (1.0 + _ROUNDING):
            raise in_the_way_error(
                MeshError(
                    "beside it {room:.0f} mm are free round {object}, and {width:.0f} mm are taken",
                    room=self.scale * available,
                    width=self.scale * (right - left),
                    object=self.surface.mesh.name,
                ),
                arc.obstacle,
            )
        shifts: dict[tuple[int, int], float] = {}
        widest = right - left
        for line, words in _words_of(page).items():
            start, _, end, _ = bounds_of(box for boxes in words.values() for box in boxes)
            gaps = max(len(words) - 1, 1)
            more = min((available - (end - start)) / gaps, _MOST_MORE) if len(words) > 1 else 0.0
            for k, word in enumerate(_from_left(words)):
                shifts[line, word] = more * (k - 0.5 * (len(words) - 1)) - 0.5 * (start + end)
            widest = max(widest, end - start + more * (len(words) - 1))
        near = 0.0 if self.layout.is_placed else None
        middle = arc.middle_for(max(self.scale * widest - self.em_mm, 0.0), near) / self.scale
        pieces = [
            replace(piece, at=(middle + piece.at[0] + shifts[_word_of(piece, k)], piece.at[1]))
            for k, piece in enumerate(page.pieces)
        ]
        return replace(page, pieces=tuple(pieces))

    def _check_apart(self, page: Page, placed: Sequence[PlacedPiece]) -> None:
        """Refuse pieces that lie on each other farther than they do on the page."""
        boxes = [piece.box for piece in page.pieces]

        def shared(one: int, two: int) -> float:
            """The depth to which two boxes overlap on the page, and a little more, mm."""
            (l1, b1, r1, u1), (l2, b2, r2, u2) = boxes[one], boxes[two]
            depth = min(r1 - l2, r2 - l1, u1 - b2, u2 - b1)
            return self.scale * max(depth, 0.0) + _SHARED * self.em_mm

        overlap = overlapping([one.square for one in placed], shared)
        if overlap is not None:
            one, two = (placed[k].glyph.text for k in overlap)
            raise MeshError(
                "{object}: the lines of the surface run together there, so that {one!r} and "
                "{two!r} would lie on each other",
                object=self.surface.mesh.name,
                one=one,
                two=two,
            )

    def _spread_around(self, page: Page) -> Page:
        """A page drawn out until it goes all around the body."""
        left, _, right, _ = page.bounds
        gap = self.layout.gap * EM_UNITS
        wanted = self._ring_length(0.0, right - left + gap)
        more = wanted / (right - left + gap)
        spread = [Piece(one.glyph, (more * one.at[0], one.at[1])) for one in page.pieces]
        left, _, right, _ = bounds_of(one.box for one in spread)
        pieces = [Piece(one.glyph, (one.at[0] - 0.5 * (left + right), one.at[1])) for one in spread]
        return replace(page, pieces=tuple(pieces))

    def _wrap_around(self, page: Page, move: float) -> Page:
        """A page of words all around the body, as often as it goes round.

        The length that is left is shared evenly by the gaps between words; a copy's middle lies at
        the point. x is counted from there.
        """
        _, lower, _, upper = page.bounds
        seam = max(self.layout.gap, _SEAM) * EM_UNITS
        lines = _words_of(page)
        rings: dict[int, float] = {}
        widths: dict[int, float] = {}
        for piece in page.pieces:
            line, _ = piece.word or (0, 0)
            rings[line] = self.scale * (piece.at[1] - 0.5 * (lower + upper)) + move
        for line, words in lines.items():
            left, _, right, _ = bounds_of(box for boxes in words.values() for box in boxes)
            widths[line] = right - left
            rings[line] = self._ring_length(rings[line], widths[line] + seam)
        copies = min(int(rings[line] * (1.0 + _ROUNDING) / (widths[line] + seam)) for line in lines)
        shifts: dict[tuple[int, int], float] = {}
        for line, words in lines.items():
            more = (rings[line] / copies - widths[line] - seam) / len(words)
            starts = {word: bounds_of(boxes)[0] for word, boxes in words.items()}
            whole = widths[line] + more * (len(words) - 1)
            for k, word in enumerate(_from_left(words)):
                shifts[line, word] = k * more - 0.5 * whole - min(starts.values())
        pieces = []
        for copy in range(copies):
            for piece in page.pieces:
                line, word = piece.word or (0, 0)
                x = piece.at[0] + shifts[line, word] + copy * rings[line] / copies
                pieces.append(replace(piece, at=(x, piece.at[1])))
        return replace(page, pieces=tuple(pieces))

    def _ring_length(self, height: float, least: float) -> float:
        """Length of the level line at a height (mm) above the middle, glyph units.

        Raises
        ------
        MeshError
            If it does not come back to its start, or is shorter than `least`, glyph units.
        """
        ring = self._ring_at(round(height, 6))
        wanted = ring.length / self.scale
        if least > wanted * (1.0 + _ROUNDING):
            raise MeshError(
                "{object} is {length:.0f} mm around; expected no less than {scale:.0f} mm",
                object=self.surface.mesh.name,
                length=ring.length,
                scale=self.scale * least,
            )
        return wanted

    def _lay_pieces(self, page: Page, move: float) -> list[PlacedPiece]:
        """Lay the pieces from the edges inwards, more and more side by side."""
        order = _outermost_first(page)
        squares: dict[int, EmSquare] = {}
        while len(squares) < len(order):
            several = order[len(squares) :][: min(max(len(squares), 1), _MOST_AT_ONCE)]
            frames: list[SurfaceFrame] = []
            fault: InputError | None = None
            for k in several:
                try:
                    frames.append(self._frame_of(page.pieces[k], page, move))
                except InputError as cause:  # unless one before it has no place
                    fault = cause
                    break
            boxes = [page.pieces[k].glyph.box for k in several[: len(frames)]]
            sizes = [(self.scale * (b[2] - b[0]), self.scale * (b[3] - b[1])) for b in boxes]
            laid = lay_squares(self.surface, frames, self.em_mm, sizes, self.limits)
            if fault is not None:
                raise fault
            squares.update(zip(several, laid, strict=True))
        return [PlacedPiece(piece.glyph, squares[k]) for k, piece in enumerate(page.pieces)]

    def _frame_of(self, piece: Piece, page: Page, move: float) -> SurfaceFrame:
        left, lower, right, upper = page.bounds
        x = self.scale * (piece.at[0] - (0.0 if self.layout.around else 0.5 * (left + right)))
        y = self.scale * (piece.at[1] - 0.5 * (lower + upper)) + move
        return self.frame(self._point_at(x, round(y, 6), right - left))

    def _point_at(self, x: float, height: float, width: float) -> AnyArray:
        """The point (3,) at an offset (mm) right of and above the middle, of a page of a width."""
        if self.layout.around:
            return self._ring_at(height).at(x)
        level = self._level_line(height, 1.0)
        if not level.closed and x < 0.0:
            level, x = self._level_line(height, -1.0), -x
        too_wide = self.scale * width > level.length * (1.0 + _ROUNDING)
        if too_wide if level.closed else x > level.length:
            raise self.surface_ends_error()
        return level.at(x)

    def _level_line(self, height: float, sign: float) -> SurfaceLine:
        """The level line to the right, or with -1 to the left, at a height (mm)."""
        if (height, sign) not in self._levels:
            climb = self.climb(math.copysign(1.0, height))
            if abs(height) > climb.length:
                raise self.surface_ends_error()
            frame = self.frame(climb.at(abs(height)))
            self._levels[height, sign] = self.walk(frame, (sign, 0.0))
        return self._levels[height, sign]


def _outermost_first(page: Page) -> list[int]:
    """Indices of a page's pieces from its edges inwards: a surface ends there first."""
    left, lower, right, upper = page.bounds

    def distance_to_edge(k: int) -> float:
        x, y = page.pieces[k].at
        return min(x - left, right - x, y - lower, upper - y)

    return sorted(range(len(page.pieces)), key=distance_to_edge)


def _words_of(page: Page) -> dict[int, dict[int, list[Box]]]:
    """The boxes of a page's pieces by line and word; what is no word is one by itself."""
    lines: dict[int, dict[int, list[Box]]] = {}
    for k, piece in enumerate(page.pieces):
        line, word = _word_of(piece, k)
        lines.setdefault(line, {}).setdefault(word, []).append(piece.box)
    return lines


def _word_of(piece: Piece, k: int) -> tuple[int, int]:
    return (0, k) if piece.word is None else piece.word


def _from_left(words: dict[int, list[Box]]) -> list[int]:
    return sorted(words, key=lambda word: bounds_of(words[word])[0])
