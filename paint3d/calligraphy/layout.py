"""Layout of a text's characters on an object: columns right to left, or rows.

The text becomes a grid of em squares. Its rows run along level lines of the surface and its
columns straight down, so that a text around a body stays level; every square is then laid by
geodesics around its own middle, so that its character is neither sheared nor stretched. Where
the lines draw together (down a bowl) the columns start farther apart, until no two squares overlap.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.free_arc import FreeArc, Ring, in_the_way_error
from paint3d.core.arrays import AnyArray, as_array
from paint3d.errors import InputError, MeshError, Message, Paint3DError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import (
    EmSquare,
    SquareLimits,
    SurfaceFrame,
    frame_at,
    lay_square,
    overlapping,
)
from paint3d.mesh.placement import SIDES, SurfaceLine, Upright, is_flat, place, upwards, walk
from paint3d.mesh.sheet_mesh import paper_bounds, sheet_of, writing_areas
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "LAYOUTS",
    "LEAST_EM_MM",
    "MOST_EM_MM",
    "Layout",
    "PlacedCharacter",
    "TextPlace",
    "WritingArea",
    "detail_or_size",
    "find_writing_areas",
    "frames_for",
    "frames_to_try",
    "layout_text",
    "split_text",
    "start_around",
    "upright_frame",
    "walking_step",
    "with_suggestion",
]

# ---- Places to try -------------------------------------------------------------------------------
# Places on an object that a text may be tried at, and the frames of what is written there.


_TURNS = (0.5, 0.375, 0.625, 0.25, 0.75, 0.125, 0.875, 0.0)  # from the front to the back
_HEIGHTS = (0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9)
_ACROSS = (0.5, 0.35, 0.65, 0.2, 0.8)
_SCATTERED = 60
_GOLDEN = (0.7548776662466927, 0.5698402909980532)  # even in the plane: Roberts' R2 sequence
_STEPS_PER_EM, _LEAST_STEP_MM = 8.0, 0.1


def walking_step(em_mm: float) -> float:
    """Step length (mm) of the lines that a text of an em runs along."""
    return max(em_mm / _STEPS_PER_EM, _LEAST_STEP_MM)


def upright_frame(surface: ClosestPoints, point: AnyArray, up: Upright) -> SurfaceFrame:
    """The frame at a point (3,) of a surface with a defined upwards.

    Raises
    ------
    MeshError
        If the surface lies level there.
    """
    try:
        return up.frame(surface, point)
    except InputError:
        raise MeshError(
            "{object}: the surface lies level at {point}; expected a place with an upwards",
            object=surface.mesh.name,
            point=point.round(1).tolist(),
        ) from None


def frames_to_try(surface: ClosestPoints, side: str | None) -> Iterator[SurfaceFrame]:
    """Frames all over an object, those nearest to the middle of its front first.

    Parameters
    ----------
    surface : ClosestPoints
    side : {"outside", "inside", "top", "bottom", "front", "right", "back", "left"}, optional
        From where one looks; by default the object's usual side first, then the others, and at
        last positions spread evenly over its area, which no side may show.
    """
    usual = "top" if is_flat(surface) else "outside"
    sides = [side] if side is not None else [usual, *(s for s in SIDES if s != usual)]
    for looked_from in sides:
        level = looked_from in ("top", "bottom")
        grid = product(_ACROSS, _ACROSS) if level else product(_TURNS, _HEIGHTS)
        for at in sorted(grid, key=lambda at: abs(at[0] - 0.5) + 0.5 * abs(at[1] - 0.5)):
            try:
                yield place(surface, at, side=looked_from)
            except MeshError:
                continue
    if side is None:
        yield from _scatter_frames(surface)


def _scatter_frames(surface: ClosestPoints) -> Iterator[SurfaceFrame]:
    """Frames spread over the surface by area, from triangle to triangle in the mesh's order."""
    mesh = surface.mesh
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    sides = corners[:, 1:] - corners[:, :1]
    passed = np.cumsum(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))
    fraction = (np.arange(_SCATTERED) + 0.5) / _SCATTERED
    faces = np.searchsorted(passed, fraction * passed[-1])
    first, second = np.modf(np.outer(np.arange(1, _SCATTERED + 1), _GOLDEN))[0].T
    folded = first + second > 1.0  # the other half of the parallelogram
    weights = np.stack([first, second], axis=1)
    weights[folded] = 1.0 - weights[folded]
    points = corners[faces, 0] + np.einsum("nk,nkd->nd", weights, sides[faces])
    for point, normal in zip(points, mesh.face_normals[faces], strict=True):
        yield frame_at(surface, point, upwards(normal))


# ---- Layout --------------------------------------------------------------------------------------


LAYOUTS = ("columns", "row")
LEAST_EM_MM, MOST_EM_MM = 2.0, 1000.0
"""Range of sizes of text, mm."""

_FEWEST, _ENOUGH = 18.0, 40.0  # vertices to an em: fewer break strokes up, so many show them whole
_TOUCHING = 0.004  # of the em: squares that share this much do not overlap
_WIDEST_PITCHES = (1.3, 2.0)  # ems from column to column: tried in turn
_LEAST_WIDENING, _LEAST_HEIGHTENING = 0.04, 0.005  # ems, of a pitch that is too small
_FARTHEST = 500.0  # ems from the middle: what lies beyond is not looked at for any text
_MIDDLE = (0.5, 0.5)
_WITHIN = 1e-6  # of a panel: how far from its rim a point between panels goes
_MOST_GRIDS = 8  # positions without enough room after which the search is given up
_SMALLER_FRACTIONS = (0.85, 0.7, 0.55, 0.4)  # of the em, tried in turn for what may be proposed
_TURNS_ASIDE = (0.0625, -0.0625, 0.125, -0.125, 0.1875, -0.1875, 0.25, -0.25, 0.375, -0.375, 0.5)
_MOST_SPREAD = 1.5  # of the distance of columns: how far a text is spread along a free arc
_DENSER = 4.0  # times as many characters as areas say may fit at a smaller size: two lines for one
_SMALLER = 16  # tenths off the em, one after the other, of which one may be proposed


def detail_or_size(em_mm: float, spacing: float | None) -> tuple[float, float] | None:
    """Vertex spacing and em (mm), either of which keeps characters whole; None if theirs does."""
    if spacing is None or em_mm >= _FEWEST * spacing:
        return None
    return float(f"{em_mm / _ENOUGH:.2g}"), math.ceil(_FEWEST * spacing)


@dataclass(frozen=True)
class Layout:
    """Options of the layout of a text.

    Attributes
    ----------
    order : {"columns", "row"}
        Columns from right to left, each from top to bottom; or rows from left to right.
    at : (float, float), optional
        Where the text's middle goes, as for `place`; by default in the middle, moved up or down
        where that makes it fit, or where the surface is smooth enough if it is not there.
    around : bool
        Spread the columns (or the letters of a row) evenly all around the body, with the middle at
        `at`, or starting at `point` or at the front. Where something is in the way, such as a
        handle, it is spread along the free arc beside that, or stands in the arc's middle where it
        is much shorter.
    side : {"outside", "inside", "top", "bottom", "front", "right", "back", "left"}, optional
        From where one looks at the object.
    gap : float
        Room between two columns or two rows, ems.
    between : float
        Room between two characters of a column or a row, ems.
    point : (float, float, float), optional
        Where the text's middle goes, mm, instead of `at`: a point on the object or beside it.
    turn : float
        By which the text is turned to the left, degrees; one that goes around lies level.
    brush_mm : float, optional
        Length of the brush for which a text around leaves what is in the way out; by default the
        `room_mm` of the limits.

    Raises
    ------
    InputError
        If a text around is turned.
    """

    order: str = "columns"
    at: tuple[float, float] | None = None
    around: bool = False
    side: str | None = None
    gap: float = 0.1
    between: float = 0.0
    point: tuple[float, float, float] | None = None
    turn: float = 0.0
    brush_mm: float | None = None

    def __post_init__(self) -> None:
        if self.around and self.turn:
            raise InputError(
                "the turn is {turn:g} degrees, but a text around an object lies level; expected "
                "no turn, or a text that does not go around",
                turn=self.turn,
            )

    @property
    def is_placed(self) -> bool:
        """True if the position of its middle is given."""
        return self.at is not None or self.point is not None


# ---- Grounds -------------------------------------------------------------------------------------
# What text is laid on: a sheet's paper within its margins, and of any other object all of it.


@dataclass(frozen=True, eq=False)
class WritingArea:
    """A surface to write on.

    Attributes
    ----------
    surface : ClosestPoints
    apex : (3,) float64 or None
        See `Upright`.
    """

    surface: ClosestPoints
    apex: NDArray[np.float64] | None = None

    def middle(self, layout: Layout) -> SurfaceFrame:
        """The frame where a text's middle goes, or where it is tried first.

        Raises
        ------
        InputError, MeshError
            See `place`.
        """
        if layout.point is None:
            frame = place(self.surface, layout.at or _MIDDLE, side=layout.side)
            origin, normal = frame.origin, frame.normal
            if self.apex is None and not layout.turn:
                return frame
        else:
            closest = self.surface.find(as_array(layout.point, "point", (3,))[None])
            origin, normal = closest.points[0], closest.normals[0]
        return upright_frame(self.surface, origin, self.upright(normal, layout))

    def upright(self, normal: AnyArray, layout: Layout) -> Upright:
        """Direction of up around a point of a normal (3,)."""
        return Upright(upwards(normal), self.apex, math.radians(layout.turn))


def find_writing_areas(
    surface: ClosestPoints, layout: Layout
) -> tuple[tuple[WritingArea, ...], Layout]:
    """Surfaces that a text may be laid on, in the order in which they are filled, with the layout.

    Where it is said where the text goes, margins are the writer's own affair, and of several panels
    it is the nearest.
    """
    if sheet_of(surface.mesh) is None:
        return (WritingArea(surface),), layout
    panels = _panels(surface.mesh, not layout.is_placed)
    if not layout.is_placed or len(panels) == 1:
        return panels, layout
    point = np.array([np.nan, np.nan, 0.0] if layout.point is None else layout.point)
    if layout.at is not None:
        low, high = paper_bounds(surface.mesh)[:, :2]
        point[:2] = low + as_array(layout.at, "at", (2,)) * (high - low)
    away = [float(np.linalg.norm(p.surface.find(point[None]).points[0] - point)) for p in panels]
    nearest = panels[int(np.argmin(away))]
    if layout.at is not None:
        low, high = nearest.surface.mesh.bounds[:, :2]
        u, v = np.clip((point[:2] - low) / (high - low), _WITHIN, 1.0 - _WITHIN).tolist()
        layout = replace(layout, at=(u, v))
    return (nearest,), layout


def frames_for(
    surface: ClosestPoints, at: tuple[float, float] | None, side: str | None
) -> Iterator[SurfaceFrame]:
    """Frames where what is laid on an object may go: at a position, or one after another.

    Raises
    ------
    InputError, MeshError
        See `place`.
    """
    areas, layout = find_writing_areas(surface, Layout(at=at, side=side))
    if layout.is_placed:
        yield areas[0].middle(layout)
        return
    for area in areas:
        yield from frames_to_try(area.surface, side)


@lru_cache(maxsize=8)
def _panels(mesh: TriangleMesh, within_margins: bool) -> tuple[WritingArea, ...]:
    areas = writing_areas(mesh, within_margins)
    return tuple(WritingArea(ClosestPoints(area.mesh), area.apex) for area in areas)


# ---- Characters in their squares -----------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class PlacedCharacter:
    """A character, the em square that it is written in, and its column or row, from 0."""

    text: str
    square: EmSquare
    line: int = 0


@dataclass(frozen=True)
class _Cell:
    text: str
    across: int  # from the left
    down: int  # from the top
    line: int = 0


def split_text(text: str) -> list[str]:
    """The lines of a text without white space; line breaks start a new column or row.

    Raises
    ------
    InputError
        If nothing is left.
    """
    lines = ["".join(part.split()) for part in unicodedata.normalize("NFC", text).splitlines()]
    lines = [line for line in lines if line]
    if not lines:
        raise InputError("the text is empty; expected at least one character")
    return lines


def layout_text(
    surface: ClosestPoints,
    text: str,
    em_mm: float,
    layout: Layout | None = None,
    limits: SquareLimits | None = None,
) -> list[PlacedCharacter]:
    """Place every character of a text, in writing order.

    Parameters
    ----------
    surface : ClosestPoints
    text : str
        Line breaks start a new column or row; other white space is passed over.
    em_mm : float
        Side of the em squares, mm.
    layout : Layout, optional
    limits : SquareLimits, optional

    Raises
    ------
    InputError
        If the text is empty or does not fit; the message says how much would.
    MeshError
        If there is no place for a single character.
    """
    layout = layout or Layout()
    if layout.order not in LAYOUTS:
        raise InputError(
            "layout is {order!r}; expected one of {layouts}",
            order=layout.order,
            layouts=", ".join(LAYOUTS),
        )
    lines = split_text(text)
    limits = limits or SquareLimits()
    areas, layout = find_writing_areas(surface, layout)
    if len(areas) == 1:
        return _lay_on(areas[0], lines, em_mm, layout, limits)
    if len(lines) == 1:  # a couplet's halves
        half = -(-len(lines[0]) // len(areas))
        lines = [lines[0][k : k + half] for k in range(0, len(lines[0]), half)]
    parts = np.array_split(np.array(lines, dtype=object), len(areas))
    return [
        placed
        for area, part in zip(areas, parts, strict=True)
        if len(part)
        for placed in _lay_on(area, list(part), em_mm, layout, limits)
    ]


def _lay_on(
    area: WritingArea, lines: Sequence[str], em_mm: float, layout: Layout, limits: SquareLimits
) -> list[PlacedCharacter]:
    """The squares of a text's lines on one surface."""
    fixed = layout.is_placed or layout.around
    fault: Paint3DError
    try:
        if fixed:
            grid = _Grid(area, em_mm, layout, limits, start_around(area, layout, em_mm))
        else:
            grid = _middle_grid(area, em_mm, layout, limits)
    except MeshError as cause:
        fault = cause
    else:
        squares = grid.fit(lines)
        if squares is not None:
            return squares
        fits = grid.how_many(lines)
        fault = _too_long_error(grid, lines, fits)
        arc = grid.find_arc(0.0)
        if arc is not None:
            raise grid.in_the_way_error(fault, arc, lines)
        fixed = fixed or fits > 0
    if fixed and isinstance(fault, MeshError):

        def lies(em_mm: float, layout: Layout) -> bool:
            grid = _Grid(area, em_mm, layout, limits, start_around(area, layout, em_mm))
            return grid.fit(lines) is not None

        raise with_suggestion(fault, em_mm, layout, lies)
    if fixed:
        raise fault
    return _search_frames(area, lines, em_mm, layout, limits, fault)


@lru_cache(maxsize=1)
def _middle_grid(area: WritingArea, em_mm: float, layout: Layout, limits: SquareLimits) -> _Grid:
    """The grid around the middle; the last is cached, as texts on one object often follow."""
    return _Grid(area, em_mm, layout, limits, area.middle(layout))


def _search_frames(
    area: WritingArea,
    lines: Sequence[str],
    em_mm: float,
    layout: Layout,
    limits: SquareLimits,
    fault: Paint3DError,
) -> list[PlacedCharacter]:
    """The squares of a text at the first position where it fits; the middle has that fault."""
    roomiest: _Grid | None = None
    n_seen = n_tried = 0
    for frame in frames_to_try(area.surface, layout.side):
        n_seen += 1
        try:
            if layout.turn or area.apex is not None:
                up = area.upright(frame.normal, layout)
                frame = upright_frame(area.surface, frame.origin, up)
            lay_square(area.surface, frame, em_mm, limits)
            grid = _Grid(area, em_mm, layout, limits, frame)
        except MeshError:
            continue
        squares = grid.fit(lines)
        if squares is not None:
            return squares
        n_tried += 1
        if roomiest is None or grid.usable_area > roomiest.usable_area:
            roomiest = grid
        if n_tried == _MOST_GRIDS:
            break
    if roomiest is None:
        raise type(fault)(
            Message("{cause}; {n} other places were no better", cause=fault, n=n_seen)
        ) from None
    raise _too_long_error(roomiest, lines, roomiest.how_many(lines))


def with_suggestion(
    fault: InputError, em_mm: float, layout: Layout, fits: Callable[[float, Layout], bool]
) -> InputError:
    """A fault with a smaller size, or a position beside the one asked for, at which a text fits.

    Without them where a hand moves the text about, who sees where it fits.

    Parameters
    ----------
    fault : InputError
    em_mm : float
    layout : Layout
    fits : callable
        Whether it fits at an em, mm, and by a layout; may raise `InputError`, too.
    """
    if layout.point is not None:
        return fault

    def does_fit(em_mm: float, layout: Layout) -> bool:
        try:
            return fits(em_mm, layout)
        except InputError:
            return False

    sizes = [float(f"{em_mm * fraction:.2g}") for fraction in _SMALLER_FRACTIONS]
    smaller = next((size for size in sizes if does_fit(size, layout)), None)
    positions = []
    if layout.at is not None:
        u, v = layout.at
        positions = [(round((u + turn) % 1.0, 3), v) for turn in _TURNS_ASIDE]
    other = next((at for at in positions if does_fit(em_mm, replace(layout, at=at))), None)
    if smaller is None and other is None:
        return fault
    if other is None:
        message = Message(
            "{cause}; a size of {smaller:g} mm would fit", cause=fault.message, smaller=smaller
        )
    elif smaller is None:
        return _with_position(fault, *other)
    else:
        message = Message(
            "{cause}; a size of {smaller:g} mm would fit, and this size at {u:g},{v:g}",
            cause=fault.message,
            smaller=smaller,
            u=other[0],
            v=other[1],
        )
    return type(fault)(message, hint=fault.hint)


def _with_position(fault: InputError, u: float, v: float) -> InputError:
    """A fault with a position at which a text of this size fits."""
    message = Message("{cause}; this size would fit at {u:g},{v:g}", cause=fault.message, u=u, v=v)
    return type(fault)(message, hint=fault.hint)


def _too_long_error(grid: _Grid, lines: Sequence[str], fits: int) -> InputError:
    smaller = grid.smaller(lines, fits)
    fields: dict[str, object] = {
        "n": sum(map(len, lines)),
        "object": grid.surface.mesh.name,
        "em_mm": grid.em_mm,
        "fits": fits,
    }
    return InputError(
        Message(
            "the text of {n} characters does not fit on {object} at a size of {em_mm:g} mm: {fits} "
            "of them would; expected a shorter text, a smaller size or another place",
            **fields,
        )
        if smaller is None
        else Message(
            "the text of {n} characters does not fit on {object} at a size of {em_mm:g} mm: {fits} "
            "of them would; expected a size of {smaller:g} mm, a shorter text or another place",
            smaller=smaller,
            **fields,
        )
    )


def start_around(
    area: WritingArea, layout: Layout, em_mm: float, height: float = 0.5
) -> SurfaceFrame:
    """The frame where a text's middle goes, or where the line begins that it goes round a body on.

    That is at the front, but where a handle stands before that; so high from 0 to 1.

    Raises
    ------
    InputError, MeshError
        See `place`.
    """
    if layout.is_placed or not layout.around:
        return area.middle(layout)
    first: SurfaceFrame | None = None
    for u in _TURNS:
        try:
            frame = area.middle(replace(layout, at=(u, height)))
        except MeshError:
            continue
        first = first or frame
        up = area.upright(frame.normal, layout)
        right, left = (
            walk(area.surface, frame, up, (sign, 0.0), None, walking_step(em_mm))
            for sign in (1.0, -1.0)
        )
        with suppress(MeshError):
            if Ring(area.surface, right, left, up.up, em_mm).goes_round:
                return frame
    return first or area.middle(layout)


@dataclass(eq=False)
class TextPlace:
    """A point of a surface that text is laid around, and the lines that go from there."""

    area: WritingArea
    em_mm: float
    layout: Layout
    limits: SquareLimits
    middle: SurfaceFrame
    most_mm: float | None = None  # how far lines are followed

    def __post_init__(self) -> None:
        self.surface = self.area.surface
        self.up = self.area.upright(self.middle.normal, self.layout)
        self._climbs: dict[float, SurfaceLine] = {}
        self._free: dict[tuple[float, float], FreeArc | None] = {}  # arcs that are known
        self.for_brush = self.limits
        if self.layout.brush_mm is not None:
            self.for_brush = replace(self.limits, room_mm=self.layout.brush_mm)

    def frame(self, point: AnyArray) -> SurfaceFrame:
        """The upright frame at a point (3,); MeshError where the surface lies level."""
        return upright_frame(self.surface, point, self.up)

    def walk(
        self, start: SurfaceFrame, bearing: tuple[float, float], most: float | None = None
    ) -> SurfaceLine:
        """The line from a frame in a direction, to the right and up, no longer than `most` mm."""
        most = self.most_mm if most is None else most
        return walk(self.surface, start, self.up, bearing, most, walking_step(self.em_mm))

    def climb(self, sign: float) -> SurfaceLine:
        """The line straight up from the middle, or with -1 straight down."""
        if sign not in self._climbs:
            self._climbs[sign] = self.walk(self.middle, (0.0, sign))
        return self._climbs[sign]

    def find_free_arc(self, ring: Ring, low: float, high: float) -> FreeArc | None:
        """The arc of a ring that is free for squares from `low` to `high` (mm above it).

        None where they may all round it.

        Raises
        ------
        MeshError
            If the brush has no room anywhere.
        """
        key = round(low, 3), round(high, 3)
        if key not in self._free:
            heights = np.linspace(low, high, 1 + math.ceil((high - low) / self.em_mm)).tolist()
            try:
                self._free[key] = ring.find_arc(
                    self.for_brush.room_mm, heights, partial(self.is_free, heights=heights),
                    placed=self.layout.is_placed, centred=self.layout.at is not None,
                )  # fmt: skip
            except MeshError:
                if self.layout.brush_mm is None:
                    raise
                self._free[key] = None  # another brush may have room
        return self._free[key]

    def is_free(self, point: AnyArray, heights: Sequence[float]) -> bool:
        """True if squares can be laid at a height (mm) above a point (3,), for the usual brush."""
        try:
            frame = self.frame(point)
            for height in heights:
                line = self.walk(frame, (0.0, math.copysign(1.0, height)), abs(height))
                above = self.frame(line.at(abs(height)))
                lay_square(self.surface, above, self.em_mm, self.for_brush)
        except InputError:
            return False
        return True

    def surface_ends_error(self) -> MeshError:
        """Error for a text that goes on beyond the surface."""
        return MeshError(
            "{object}: the surface ends within the text", object=self.surface.mesh.name
        )


class _Grid(TextPlace):
    """The grid of squares around one point of a surface."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.most_mm, layout = _FARTHEST * self.em_mm, self.layout
        self.right = self.walk(self.middle, (1.0, 0.0))
        self.left = self.walk(self.middle, (-1.0, 0.0))
        self.ring: Ring | None = None
        if layout.around:
            self.ring = Ring(self.surface, self.right, self.left, self.up.up, self.em_mm)
        gaps = (layout.gap, layout.between)
        gaps = gaps if layout.order == "columns" else gaps[::-1]
        self.pitch = self.em_mm * (1.0 + np.array(gaps))
        self._loose = math.inf if layout.around else 1.0
        self._start = self._first_usable()

    @cached_property
    def span(self) -> tuple[float, float]:
        """Lowest and highest position (mm up from the middle) where a square can be laid."""
        return self._reach(self._start, -1.0), self._reach(self._start, 1.0)

    def find_arc(self, block: float) -> FreeArc | None:
        """The free arc for the columns of a block of a height (mm); None: all round a body."""
        if self.ring is None:
            return None
        top = self._top(block)
        return self.find_free_arc(self.ring, top - block, top)

    def in_the_way_error(self, fault: InputError, arc: FreeArc, lines: Sequence[str]) -> InputError:
        """A fault with what is in the way, and a position that would do where one was asked for."""
        error = in_the_way_error(fault, arc.obstacle)
        if self.ring is None or self.layout.at is None:
            return error
        free = self.ring.find_arc(
            self.for_brush.room_mm, (0.0,), partial(self.is_free, heights=(0.0,))
        )
        if free is None:
            return error
        u = round(self.ring.turn_at(free.middle_for(0.0)), 2)
        layout = replace(self.layout, at=(u, self.layout.at[1]))
        try:
            start = self.area.middle(layout)
            if _Grid(self.area, self.em_mm, layout, self.limits, start).fit(lines) is None:
                return error
        except InputError:
            return error
        return _with_position(error, u, self.layout.at[1])

    @property
    def usable_area(self) -> float:
        """Area of the surface that the grid may use, mm2."""
        around = 1.0 if self.right.closed else 2.0
        return around * self.right.length * (self.span[1] - self.span[0] + self.em_mm)

    # -- how many fit -----------------------------------------------------------------------

    def _first_usable(self) -> float:
        """The position nearest to the middle, up or down, where a square can be laid."""
        if self.layout.is_placed:
            self._square(self.middle.origin)
            return 0.0
        fault: MeshError | None = None
        for away in (0.25 * self.em_mm * np.arange(7)).tolist():
            for sign in (1.0, -1.0):
                line = self.climb(sign)
                reached = away if line.reaches(away) else line.length
                try:
                    self._square(line.at(reached))
                except MeshError as cause:
                    fault = fault or cause
                else:
                    return sign * reached
        raise fault or MeshError("{object}: no place to write", object=self.surface.mesh.name)

    def _reach(self, start: float, sign: float) -> float:
        """Farthest position (mm up from the middle) where a square can lie, to a 40th of the em."""
        line = self.climb(sign)
        known, step = start, 0.5 * self.em_mm
        while step > self.em_mm / 50.0:
            distance = sign * known + step
            if distance < 0.0 or (line.reaches(distance) and self._is_usable(line.at(distance))):
                known += sign * step
            else:
                step *= 0.5
        return known

    def _is_usable(self, point: AnyArray) -> bool:
        try:
            self._square(point)
        except MeshError:
            return False
        return True

    def _square(self, point: AnyArray) -> EmSquare:
        return lay_square(self.surface, self.frame(point), self.em_mm, self.limits)

    def _has_room(self, shape: tuple[int, int], pitch: AnyArray) -> bool:
        """Return whether a grid of n across and m down fits, by the middle lines alone."""
        if shape[1] > 1:
            low, high = self.span
            if (shape[1] - 1) * pitch[1] > high - low + 0.02 * pitch[1]:
                return False
        arc = self.find_arc((shape[1] - 1) * pitch[1])
        if arc is not None:
            return bool((shape[0] - 1) * pitch[0] <= arc.length + _TOUCHING * self.em_mm)
        ring = shape[0] * pitch[0] / (1.0 + 1e-9)
        half = 0.5 * ((shape[0] - 1) * pitch[0] + self.em_mm) / (1.0 + 1e-6)
        if self.right.reaches(ring) and self.left.reaches(half):
            return True  # whether the level line is closed or not
        if self.right.closed:
            return self.right.reaches(ring)
        return self.right.reaches(half) and self.left.reaches(half)

    def how_many(self, lines: Sequence[str]) -> int:
        """Number of the text's characters that fit."""
        few, many = 0, sum(map(len, lines))
        while many - few > 1:
            n = (few + many) // 2
            if self.fit(_first_characters(lines, n)) is None:
                many = n
            else:
                few = n
        return few

    def smaller(self, lines: Sequence[str], fits: int) -> float | None:
        """The first smaller em, mm, at which all of a text fits here; None where none is found.

        So many of its characters fit at this em.
        """
        most = _DENSER * (fits + 1) / sum(map(len, lines))
        for step in range(1, _SMALLER):
            if 0.81**step > most:
                continue
            em_mm = float(f"{self.em_mm * 0.9**step:.2g}")
            try:
                grid = _Grid(self.area, em_mm, self.layout, self.limits, self.middle)
                if grid.fit(lines) is not None:
                    return em_mm
            except MeshError:
                continue
        return None

    # -- placing ----------------------------------------------------------------------------

    def fit(self, lines: Sequence[str]) -> list[PlacedCharacter] | None:
        """The squares of a text, or None where it does not fit."""
        for widest in _WIDEST_PITCHES:
            for broken in self._ways_to_break(lines):
                with suppress(MeshError):
                    placed = self._fit_lines(broken, widest)
                    if placed is not None:
                        return placed
        return None

    def _ways_to_break(self, lines: Sequence[str]) -> list[list[str]]:
        """The lines as they are, or one line as columns of even length, the best first."""
        if self.layout.order == "row" or len(lines) > 1:
            return [list(lines)]
        text, n = lines[0], len(lines[0])
        if n == 1:
            return [[text]]
        most = 1 + int((self.span[1] - self.span[0]) / self.pitch[1] + 0.02)
        heights = {math.ceil(n / math.ceil(n / tall)) for tall in range(1, most + 1)}
        ordered = sorted(heights, reverse=not self.layout.around)
        return [[text[k : k + tall] for k in range(0, n, tall)] for tall in ordered]

    def _fit_lines(self, lines: Sequence[str], widest: float) -> list[PlacedCharacter] | None:
        """Lay a grid as narrow as it can be; None or MeshError where it does not fit."""
        shape = len(lines), max(map(len, lines))
        wide, tall = shape = shape if self.layout.order == "columns" else shape[::-1]
        pitch = self.pitch.copy()
        arc = self.find_arc((tall - 1) * pitch[1])
        if arc is not None:
            wished = arc.length / max(wide - 1, 1)
            pitch[0] *= min(max(wished / pitch[0], 1.0), _MOST_SPREAD)
        elif self.ring is not None:
            pitch[0] = self.ring.length / wide
        deepest = tall  # that two neighbours reach: long columns and short ones may take turns
        if self.layout.order == "columns" and wide > 1:
            deepest = max(map(min, pairwise(map(len, lines))))
        rows = {0, min(1, deepest - 1), deepest - 1}
        sample = [_Cell("", x, y) for x in range(min(wide, 2)) for y in sorted(rows)]
        while self._has_room(shape, pitch) and pitch.max() <= widest * self.em_mm * self._loose:
            arc = self.find_arc((tall - 1) * pitch[1])
            n_round = wide if self.ring is not None and arc is None else None
            apart = self._overlaps(sample, self._place_cells(sample, shape, pitch), n_round)
            if not apart.any():
                cells = self._cells(lines)
                placed = self._place_cells(cells, shape, pitch)
                apart = self._overlaps(cells, placed, n_round)
            if not apart.any():
                if overlapping(placed, lambda *_: _TOUCHING * self.em_mm) is not None:
                    return None  # two that are no neighbours: level lines may run together
                squares = zip(cells, placed, strict=True)
                return [PlacedCharacter(cell.text, square, cell.line) for cell, square in squares]
            if n_round is not None and apart[0] > 0.0:
                return None
            least = np.array([_LEAST_WIDENING, _LEAST_HEIGHTENING]) * self.em_mm
            pitch += np.where(apart > 0.0, np.maximum(1.2 * apart, least), 0.0)
        return None

    def _cells(self, lines: Sequence[str]) -> list[_Cell]:
        """Grid cell of each character."""
        columns, longest = self.layout.order == "columns", max(map(len, lines))
        wide = len(lines) if columns else longest
        cells = []
        for k, line in enumerate(lines):
            for j, text in enumerate(line):
                at = (wide - 1 - k, j) if columns else (j, k)
                cells.append(_Cell(text, *at, k))
        return cells

    def _place_cells(
        self, cells: Sequence[_Cell], shape: tuple[int, int], pitch: AnyArray
    ) -> list[EmSquare]:
        """The squares of cells of a grid; MeshError where one cannot be laid."""
        block = (shape[1] - 1) * pitch[1]
        top, left = self._top(block), self._left(shape[0], pitch[0], self.find_arc(block))
        lines: dict[int, tuple[SurfaceLine, SurfaceLine]] = {}
        squares = []
        for cell in cells:
            if cell.across not in lines:
                lines[cell.across] = self._column(left + cell.across * pitch[0], top, top - block)
            height = top - cell.down * pitch[1]
            line = lines[cell.across][0 if height >= 0.0 else 1]
            away = abs(height)
            if not line.reaches(away - _TOUCHING * self.em_mm):
                raise self.surface_ends_error()
            squares.append(self._square(line.at(away if line.reaches(away) else line.length)))
        return squares

    def _column(self, across: float, top: float, bottom: float) -> tuple[SurfaceLine, SurfaceLine]:
        """The lines up and down from the point so many mm to the right of the middle."""
        if self.ring is not None:
            frame = self.frame(self.ring.at(across))
            up = self.walk(frame, (0.0, 1.0), max(top, 0.0))
            return up, self.walk(frame, (0.0, -1.0), max(-bottom, 0.0))
        if across >= 0.0 or self.right.closed:
            level, distance = self.right, across
        else:
            level, distance = self.left, -across
        if not level.reaches(distance) and not level.closed:
            raise self.surface_ends_error()
        frame = self.frame(level.at(distance))
        up = self.walk(frame, (0.0, 1.0), max(top, 0.0))
        return up, self.walk(frame, (0.0, -1.0), max(-bottom, 0.0))

    def _top(self, block: float) -> float:
        """Height (mm up from the middle) of the first row; the block is moved until it fits."""
        top = 0.5 * block
        if not self.layout.is_placed and (block > 0.0 or self._start != 0.0):
            low, high = self.span
            top = min(max(top, low + block), high)
        return top

    def _left(self, wide: int, pitch: float, arc: FreeArc | None) -> float:
        width = (wide - 1) * pitch
        if arc is not None:
            near = 0.0 if self.layout.is_placed else None
            return arc.middle_for(width, near) - 0.5 * width
        if not self.layout.around or self.layout.at is not None:
            return -0.5 * width
        return -(wide - 1) * pitch if self.layout.order == "columns" else 0.0

    def _overlaps(
        self, cells: Sequence[_Cell], squares: Sequence[EmSquare], n_round: int | None
    ) -> AnyArray:
        """The largest overlaps (mm) of neighbours in a row or diagonally, and in a column.

        Where so many stand all round a body, the last is a neighbour of the first.
        """
        at = {(c.across, c.down): square for c, square in zip(cells, squares, strict=True)}
        worst = np.zeros(2)
        for (across, down), square in at.items():
            right = across + 1 if n_round is None else (across + 1) % n_round
            for key in ((right, down), (right, down + 1), (right, down - 1), (across, down + 1)):
                other = at.get(key)
                if other is not None and other is not square:
                    axis = int(key[0] == across)
                    worst[axis] = max(worst[axis], square.overlap(other), other.overlap(square))
        return np.where(worst > _TOUCHING * self.em_mm, worst, 0.0)


def _first_characters(lines: Sequence[str], n: int) -> list[str]:
    """The first n characters of the lines."""
    cut = []
    for line in lines:
        cut.append(line[:n])
        n -= len(cut[-1])
    return [line for line in cut if line]
