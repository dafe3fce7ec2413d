"""Layout of the pieces of a flat page on an object.

The middle of the page lies at a place of the surface. From there one goes straight up or down to a
piece's height and then along the level line, so that lines of text lie level and pieces are as far
apart along them as on the page; every piece is then laid by geodesics around its own middle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from paint3d.calligraphy.glyphs import EM_UNITS, Box, Glyph
from paint3d.calligraphy.layout import (
    Layout,
    TextPlace,
    WritingArea,
    find_writing_areas,
    frames_to_try,
    upright_frame,
    with_suggestion,
)
from paint3d.calligraphy.page.page import Composer, Page, Piece, bounds_of
from paint3d.errors import InputError, MeshError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import EmSquare, SquareLimits, SurfaceFrame, lay_square, overlapping
from paint3d.mesh.placement import SurfaceLine

__all__ = ["PlacedPiece", "lay_page"]

_SHARES = (1.0, 0.8, 0.65, 0.5, 0.4, 0.3, 0.2)  # of the room there is: lines that are tried
_MOVES = (0.0, 0.3, -0.3, 0.6, -0.6, 1.0, -1.0, 1.5, -1.5)  # ems up from the place: tried in turn
_MOST_PLACES = 12
_ROUNDING = 1e-6  # of a length
_SHARED = 0.02  # of the em: corners of boxes that share this much more than on the page are apart
_SEAM = 0.5  # ems between the end of a text and where it begins anew, all around a body: at least
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
        If there is no such place.
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
    for n, frame in enumerate(_places(area, layout)):
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
        raise _far_too_large(surface, composer, em_mm, fault)
    raise _too_large(surface, composed, em_mm, fault)


def _places(area: WritingArea, layout: Layout) -> Iterator[SurfaceFrame]:
    """Places where the page's middle may lie: the one asked for, or one after another."""
    if layout.is_placed or layout.around:
        yield area.middle(layout)
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


def _far_too_large(
    surface: ClosestPoints, composer: Composer, em_mm: float, fault: MeshError
) -> InputError:
    """Error for a text whose advances alone show that it is too large."""
    return InputError(
        "the text is {length:,.0f} mm long at this size, which does not fit on {object} ({fault}); "
        "expected less to write or a smaller size",
        length=em_mm / EM_UNITS * composer.least_size(math.inf)[0],
        object=surface.mesh.name,
        fault=fault,
    )


class _Sheet(TextPlace):
    """A page's lines up and along, around one place of a surface."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.scale = self.em_mm / EM_UNITS
        self.too_small: MeshError | None = None  # why pages were not even composed
        self._levels: dict[tuple[float, float], SurfaceLine] = {}

    def pages(self, composer: Composer) -> Iterator[Page]:
        """The text in one line, then broken to more and more, but for what is far too large.

        Of that not even the glyphs are placed, which takes seconds for thousands.
        """
        room = self._length_along(composer)
        page: Page | None = None
        for share in (math.inf, *_SHARES):
            length = share * room / self.scale
            along, across = (self.scale * size for size in composer.least_size(length))
            if along > _FAR * room + 4.0 * self.em_mm or across > _FAR * self._length_across(
                composer
            ):
                self.too_small = self.too_small or self.surface_ends_error()
                continue
            following = composer.compose(length)
            if following is not page:
                page = following
                yield page

    def _length_across(self, composer: Composer) -> float:
        """Room across the lines, mm."""
        if not composer.runs_down:
            return sum(self.climb(sign).length for sign in (1.0, -1.0))
        right = self._level_line(0.0, 1.0)
        return right.length if right.closed else right.length + self._level_line(0.0, -1.0).length

    def _length_along(self, composer: Composer) -> float:
        """Greatest length of a line of text, mm."""
        if composer.runs_down:
            return sum(self.climb(sign).length for sign in (1.0, -1.0))
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
        in_words = self.layout.around and all(piece.word is not None for piece in page.pieces)
        if self.layout.around and not in_words:
            page = self._spread_around(page)
        fault: MeshError | None = None
        for move in (0.0,) if self.layout.is_placed else _MOVES:
            try:
                laid = self._wrap_around(page, move * self.em_mm) if in_words else page
                placed = [self._lay_piece(piece, laid, move * self.em_mm) for piece in laid.pieces]
                self._check_apart(laid, placed)
                return placed
            except MeshError as cause:
                fault = fault or cause
        assert fault is not None
        raise fault

    def _check_apart(self, page: Page, placed: Sequence[PlacedPiece]) -> None:
        """Refuse pieces that lie on each other farther than they do on the page."""
        boxes = [piece.box for piece in page.pieces]

        def shared(one: int, two: int) -> float:
            """How far two boxes would have to be moved until they are apart on the page, mm."""
            (l1, b1, r1, u1), (l2, b2, r2, u2) = boxes[one], boxes[two]
            depth = min(r1 - l2, r2 - l1, u1 - b2, u2 - b1)
            return self.scale * max(depth, 0.0) + _SHARED * self.em_mm

        found = overlapping([one.square for one in placed], shared)
        if found is not None:
            one, two = (placed[k].glyph.text for k in found)
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
        pieces = [Piece(piece.glyph, (more * piece.at[0], piece.at[1])) for piece in page.pieces]
        return replace(page, pieces=tuple(pieces))

    def _wrap_around(self, page: Page, move: float) -> Page:
        """A page of words all around the body, as often as it goes round.

        The room that is left is shared evenly by the gaps between words; a copy's middle lies at
        the place. x is counted from there.
        """
        _, lower, _, upper = page.bounds
        seam = max(self.layout.gap, _SEAM) * EM_UNITS
        lines: dict[int, dict[int, list[Box]]] = {}
        rings: dict[int, float] = {}
        widths: dict[int, float] = {}
        for piece in page.pieces:
            line, word = piece.word or (0, 0)
            lines.setdefault(line, {}).setdefault(word, []).append(piece.box)
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
            for k, word in enumerate(sorted(starts, key=lambda word: starts[word])):
                shifts[line, word] = k * more - 0.5 * whole - min(starts.values())
        pieces = []
        for copy in range(copies):
            for piece in page.pieces:
                line, word = piece.word or (0, 0)
                x = piece.at[0] + shifts[line, word] + copy * rings[line] / copies
                pieces.append(replace(piece, at=(x, piece.at[1])))
        return replace(page, pieces=tuple(pieces))

    def _ring_length(self, height: float, least: float) -> float:
        """Length of the level line so many mm above the middle, glyph units, if it is closed.

        Raises
        ------
        MeshError
            If it does not come back to its start, or is shorter than `least`, glyph units.
        """
        ring = self._level_line(round(height, 6), 1.0)
        self.check_closed(ring)
        wanted = ring.length / self.scale
        if least > wanted * (1.0 + _ROUNDING):
            raise MeshError(
                "{object} is {length:.0f} mm around; expected no less than {scale:.0f} mm",
                object=self.surface.mesh.name,
                length=ring.length,
                scale=self.scale * least,
            )
        return wanted

    def _lay_piece(self, piece: Piece, page: Page, move: float) -> PlacedPiece:
        left, lower, right, upper = page.bounds
        in_ribbon = self.layout.around and piece.word is not None
        x = self.scale * (piece.at[0] - (0.0 if in_ribbon else 0.5 * (left + right)))
        y = self.scale * (piece.at[1] - 0.5 * (lower + upper)) + move
        level = self._level_line(round(y, 6), 1.0)
        if not level.closed and x < 0.0:
            level, x = self._level_line(round(y, 6), -1.0), -x
        too_wide = not in_ribbon and self.scale * (right - left) > level.length * (1.0 + _ROUNDING)
        if too_wide if level.closed else x > level.length:
            raise self.surface_ends_error()
        frame = self.frame(level.at(x))
        box = piece.glyph.box
        size = self.scale * (box[2] - box[0]), self.scale * (box[3] - box[1])
        square = lay_square(self.surface, frame, self.em_mm, self.limits, size)
        return PlacedPiece(piece.glyph, square)

    def _level_line(self, height: float, sign: float) -> SurfaceLine:
        """The level line to the right, or with -1 to the left, so many mm above the middle."""
        if (height, sign) not in self._levels:
            climb = self.climb(math.copysign(1.0, height))
            if abs(height) > climb.length:
                raise self.surface_ends_error()
            frame = self.frame(climb.at(abs(height)))
            self._levels[height, sign] = self.walk(frame, (sign, 0.0))
        return self._levels[height, sign]
