"""A copybook on the object: ghosts of characters to paint over, and how well each was met.

The characters, or the pieces of a page, lie where `paint3d write` would put them. A stroke belongs
to the character in whose em square most of it was painted; of a recording, or a text that the brush
wrote by itself, each time that the brush was down counts. When a character has as many strokes as
its glyph, or whenever it is asked for, the painting is compared with the glyph's outlines in the
surface's own coordinates.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.laid_text import LaidText
from paint3d.app.model.stroke_log import ERASES, Stroke
from paint3d.calligraphy.fonts.fallback import FallbackGlyphs, set_whole, with_fallback
from paint3d.calligraphy.glyph_sources import has_letters, load_glyphs, open_glyphs
from paint3d.calligraphy.glyphs import Glyph
from paint3d.calligraphy.layout import LEAST_EM_MM, MOST_EM_MM, Layout, layout_text
from paint3d.calligraphy.metrics import Likeness, compare, copybook_mask, painted_mask
from paint3d.calligraphy.page.laying import PlacedPiece, lay_page
from paint3d.calligraphy.page.opening import set_in
from paint3d.calligraphy.page.page import Composer, Page
from paint3d.calligraphy.planning import on_paper
from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import MeshError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import EmSquare, SurfaceChart, SurfaceFrame, frame_at, make_chart, unroll
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.pose.brush_pose import BrushPath, object_poses
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Copybook", "CopybookBlock", "CopybookMark", "Ghost"]

_REACH = 0.15  # ems that a chart goes beyond the em square, for what strays
_NODES_PER_EM = 24.0
_STEP = 1.0 / 96.0  # ems between two points of a ghost
_LIFT_MM = 0.05  # above the surface, so that a ghost is seen
_BLANK = "口"  # stands where nothing is said
_LIFTED_S = 0.06  # from one stroke of a recording to the next, at least
_LOOKED_AT = 24  # points of a stroke, at most
_ALL_AROUND = 0.2  # length of the mean of directions below which squares go around a body
_MANY, _SPARSE = 2000, 4  # samples, of which then every fourth is looked at

_LEFT, _RIGHT = ((-1.0, -1.0), (-1.0, 1.0)), ((1.0, -1.0), (1.0, 1.0))
_BOTTOM, _TOP = ((-1.0, -1.0), (1.0, -1.0)), ((-1.0, 1.0), (1.0, 1.0))
_FRAME = (_LEFT, _TOP, _RIGHT, _BOTTOM)
_CROSS = (((-1.0, 0.0), (1.0, 0.0)), ((0.0, -1.0), (0.0, 1.0)))
_DIAGONALS = (((-1.0, -1.0), (1.0, 1.0)), ((-1.0, 1.0), (1.0, -1.0)))
_THIRDS = tuple(
    way
    for at in (-1.0 / 3.0, 1.0 / 3.0)
    for way in (((-1.0, at), (1.0, at)), ((at, -1.0), (at, 1.0)))
)
_GRID_LINES = {
    "frame": _FRAME, "tian": (*_FRAME, *_CROSS), "mi": (*_FRAME, *_CROSS, *_DIAGONALS),
    "jiu": (*_FRAME, *_THIRDS),
}  # fmt: skip


@dataclass(eq=False)
class Ghost:
    """A character of a copybook, or a piece of a page.

    Attributes
    ----------
    glyph : Glyph
    square : EmSquare
        Or the box of a piece.
    strokes : list of Stroke
        What was painted for it so far; one that has several of its strokes, so often.
    """

    glyph: Glyph
    square: EmSquare
    surface: ClosestPoints = field(repr=False)
    strokes: list[Stroke] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The character."""
        return self.glyph.text

    @property
    def is_written(self) -> bool:
        """True if it has as many strokes as its glyph."""
        return len(self.strokes) >= len(self.glyph.strokes)

    @property
    def seconds(self) -> float:
        """From the first stroke's first sample to the last one's last, s; 0 before."""
        if not self.strokes:
            return 0.0
        last = self.strokes[-1].samples[-1].time_ns
        return (last - self.strokes[0].samples[0].time_ns) * 1e-9

    @cached_property
    def outlines(self) -> tuple[AnyArray, ...]:
        """Closed lines (N, 3) around strokes and holes, mm, a little above the surface."""
        strokes = self.glyph.strokes
        rings = [ring for stroke in strokes for ring in (stroke.outline, *stroke.holes)]
        return tuple(self._raise_line(ring, closed=True) for ring in rings)

    @cached_property
    def medians(self) -> tuple[AnyArray, ...]:
        """The strokes' centre lines (N, 3) in writing order, mm."""
        return tuple(self._raise_line(stroke.median, closed=False) for stroke in self.glyph.strokes)

    @cached_property
    def frame(self) -> AnyArray:
        """The rim (N, 3) of the square or box, closed, mm."""
        corners = self.half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        return self._lay_on_surface(_densify(corners, True, _STEP * self.square.em_mm))

    @property
    def half(self) -> AnyArray:
        """Half of the width and the height (2,) of the square or box, mm."""
        return 0.5 * np.array([self.square.width_mm, self.square.height_mm])

    def _mm_from_middle(self, points: AnyArray) -> AnyArray:
        """Glyph units (N, 2) as mm from the middle of the square or box."""
        em = self.square.em_mm
        return on_paper(points, em) - on_paper(np.array([self.glyph.middle]), em)

    def _raise_line(self, line: AnyArray, closed: bool) -> AnyArray:
        return self._lay_on_surface(
            _densify(self._mm_from_middle(line), closed, _STEP * self.square.em_mm)
        )

    def _lay_on_surface(self, xy: AnyArray) -> AnyArray:
        chart = self.chart
        xy = np.clip(xy, -chart.reach, chart.reach)
        return chart.points(xy) + _LIFT_MM * chart.normals(xy)

    @cached_property
    def chart(self) -> SurfaceChart:
        """The surface around the square; only the square where there is no more."""
        em, square = self.square.em_mm, self.square
        wide, high = (self.half + _REACH * em).tolist()
        try:
            return make_chart(self.surface, square.chart.frame, wide, high, em / _NODES_PER_EM)
        except MeshError:
            return square.chart

    def compare(self, surface: PaintedSurface) -> Likeness | None:
        """Likeness of the painting in the square to the glyph; None where nothing is painted.

        All paint there counts, of all layers.
        """
        side = self._side
        faces = surface.paint_mesh.leaf_faces()
        coverage = surface.painted_coverage()
        faces = faces[(coverage[faces] > 0.0).any(axis=1)]
        vertices = surface.paint_mesh.vertices
        used = np.unique(faces)
        away = np.linalg.norm(vertices[used] - self.chart.frame.origin, axis=1)
        used = used[away < 1.5 * side]
        points = np.full((len(coverage), 2), np.nan)
        if len(used):
            points[used] = unroll(self.chart, vertices[used].astype(np.float64))
        faces = faces[np.isfinite(points[faces]).all(axis=(1, 2))]
        painted = painted_mask(points + 0.5 * side, coverage, faces, side)
        return compare(painted, self._wanted_mask) if painted.any() else None

    @property
    def _side(self) -> float:
        """Side of the square that the painting is compared in, mm: an em, or what a box needs."""
        return max(self.square.em_mm, self.square.width_mm, self.square.height_mm)

    @cached_property
    def _wanted_mask(self) -> NDArray[np.bool_]:
        def placed(ring: AnyArray) -> AnyArray:
            return self._mm_from_middle(ring) + 0.5 * self._side

        strokes = self.glyph.strokes
        holes = [[placed(hole) for hole in stroke.holes] for stroke in strokes]
        return copybook_mask([placed(stroke.outline) for stroke in strokes], self._side, holes)


@dataclass(frozen=True)
class CopybookMark:
    """Mark that a stroke gets from a copybook.

    Attributes
    ----------
    place : int
        Of its character.
    text : str
    n_strokes : int
        Painted for the character so far.
    likeness : Likeness or None
        Once it is written.
    seconds : float
        From the character's first sample to its last, s.
    """

    place: int
    text: str
    n_strokes: int
    likeness: Likeness | None
    seconds: float


@dataclass(frozen=True, eq=False)
class CopybookBlock:
    """The box around a text.

    Attributes
    ----------
    frame : SurfaceFrame
        In the middle, its y axis up for the text.
    corners : (4, 3) float64
        Upper left, upper right, lower right, lower left, mm.
    """

    frame: SurfaceFrame
    corners: AnyArray

    @classmethod
    def of(cls, surface: ClosestPoints, squares: Sequence[EmSquare]) -> CopybookBlock:
        """The block of squares or boxes."""
        frames = [square.chart.frame for square in squares]
        points = np.concatenate([square.points.reshape(-1, 3) for square in squares])
        if np.linalg.norm(np.mean([frame.x_axis for frame in frames], axis=0)) < _ALL_AROUND:
            frames = frames[:1]  # their middle is within the body
        middle = np.mean([frame.origin for frame in frames], axis=0)
        frame = frame_at(surface, middle, np.mean([frame.y_axis for frame in frames], axis=0))
        flat = (points - frame.origin) @ np.stack([frame.x_axis, frame.y_axis], axis=1)
        low, high = flat.min(axis=0), flat.max(axis=0)
        wanted = [(low[0], high[1]), high, (high[0], low[1]), low]
        near = [int(np.argmin(((flat - corner) ** 2).sum(axis=1))) for corner in wanted]
        return cls(frame, points[near])


class Copybook:
    """A text, a drawing or strokes as ghosts on an object.

    Parameters
    ----------
    mesh : TriangleMesh
        The object.
    text : str or Composer
        In characters that are known or that a font of the system has, where line breaks start a
        new column or row; or a page.
    em_mm : float
        Side of the characters' squares, 2 to 1000 mm.
    layout : Layout, optional
    folder : path, optional
        Of glyphs, as `open_glyphs` takes it.
    is_grid : bool
        Whether the text only says how many squares there are.

    Attributes
    ----------
    ghosts : tuple of Ghost
    squares : tuple of EmSquare
        Of all characters or pieces, also where there is nothing to be written.
    lines : str
        The text with a line break after each column or row; empty of a page.
    block : CopybookBlock
    marks : dict of int to CopybookMark
        Of characters by their index, the last of each.
    page : Page or None
        As it was composed; None of known characters.
    from_fonts : dict of str to str
        Characters that are taken from fonts of the system, by the font's name.

    Raises
    ------
    InputError
        If the text is empty, has unknown characters or does not fit.
    MeshError
        If there is no place for a character.
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        text: str | Composer,
        em_mm: float = 30.0,
        layout: Layout | None = None,
        folder: str | None = None,
        *,
        is_grid: bool = False,
    ) -> None:
        em_mm = as_number(em_mm, "size (mm)", LEAST_EM_MM, MOST_EM_MM)
        surface = ClosestPoints(mesh)
        self.page: Page | None = None
        self.from_fonts: dict[str, str] = {}
        self.lines = ""
        if is_grid:
            squares = layout_text(surface, str(text), em_mm, layout)
            placed = [PlacedPiece(Glyph("", ()), one.square) for one in squares]
        elif isinstance(text, str):
            source = with_fallback(open_glyphs(folder), text)
            if isinstance(source, FallbackGlyphs):
                self.from_fonts = source.characters
            glyphs = load_glyphs(source, "".join(text.split()))
            squares = layout_text(surface, text, em_mm, layout)
            placed = [PlacedPiece(glyphs[one.text], one.square) for one in squares]
            lines = "".join(
                ("\n" if k and one.line != squares[k - 1].line else "") + one.text
                for k, one in enumerate(squares)
            )
            self.lines = lines
        else:
            self.page, placed = lay_page(surface, text, em_mm, layout)
        self._surface = surface
        self._counted: dict[int, _Counted] = {}  # strokes by their id
        self._keeping = threading.Lock()  # held to change what is counted, or to copy it
        self.squares = tuple(one.square for one in placed)
        self.marks: dict[int, CopybookMark] = {}
        self.ghosts = tuple(
            Ghost(one.glyph, one.square, surface) for one in placed if one.glyph.strokes
        )

    @classmethod
    def of(cls, mesh: TriangleMesh, laid: LaidText, folder: str | None = None) -> Copybook:
        """The copybook of a text that is laid on an object; see the constructor."""
        if not laid.text.strip():
            across, down = laid.cells
            n_lines, length = (across, down) if laid.order == "columns" else (down, across)
            blanks = "\n".join([_BLANK * length] * n_lines)
            return cls(mesh, blanks, laid.em_mm, laid.layout, is_grid=True)
        text: str | Composer = laid.text
        if laid.font:
            text = set_in(laid.text, laid.font, columns=laid.order == "columns")
        elif has_letters(laid.text):
            whole = set_whole(open_glyphs(folder), laid.text, laid.order, around=laid.around)
            text = laid.text if whole is None else whole
        return cls(mesh, text, laid.em_mm, laid.layout, folder)

    @cached_property
    def block(self) -> CopybookBlock:
        """The box around it."""
        return CopybookBlock.of(self._surface, self.squares)

    def grid(self, kind: str, columns: bool, *, unwritten: bool = False) -> list[AnyArray]:
        """Lines (K, 3), mm, of one of the `GRIDS` around all characters, or those to be written."""
        segments = _GRID_LINES.get(kind, ())
        if kind == "columns":
            segments = (_LEFT, _RIGHT) if columns else (_TOP, _BOTTOM)
        done = {id(ghost.square) for ghost in self.ghosts if unwritten and ghost.is_written}
        lines = []
        for square in self.squares:
            if id(square) in done:
                continue
            half = 0.5 * np.array([square.width_mm, square.height_mm])
            for segment in segments:
                xy = _densify(half * np.array(segment), False, _STEP * square.em_mm)
                lines.append(square.chart.points(xy) + _LIFT_MM * square.chart.normals(xy))
        return lines

    @property
    def next(self) -> int | None:
        """Index of the first character that is not written yet; None when all are."""
        return next((k for k, ghost in enumerate(self.ghosts) if not ghost.is_written), None)

    def _find_character(self, path: AnyArray) -> int | None:
        """The character in whose square most of a path (N, 3) lies; None where in none."""
        if not self.ghosts:
            return None
        feet = self._surface.find(path[:: -(-len(path) // _LOOKED_AT)]).points
        counts = [_count_inside(ghost, feet) for ghost in self.ghosts]
        best = int(np.argmax(counts))
        return best if counts[best] > 0 else None

    def note(self, stroke: Stroke, surface: PaintedSurface) -> CopybookMark | None:
        """Take a stroke that was painted; None where it belongs to no character."""
        indices = self._count(stroke, is_over=True).indices
        if not indices:
            return None
        index = indices[-1]
        ghost = self.ghosts[index]
        stroke.tags |= {"character": ghost.text, "place": index}
        likeness = ghost.compare(surface) if ghost.is_written else None
        mark = CopybookMark(index, ghost.text, len(ghost.strokes), likeness, ghost.seconds)
        with self._keeping:
            self.marks[index] = mark
        return mark

    def begin_after(self, strokes: Sequence[Stroke]) -> None:
        """Count none of these strokes: they were there before the copybook."""
        for stroke in strokes:
            self._counted[id(stroke)] = _Counted(stroke, len(stroke.samples))

    def go_on_from(self, other: Copybook) -> None:
        """Take over the counts of another copybook of the same characters at the same positions."""
        with other._keeping:
            self.marks = dict(other.marks)
            self._counted = {
                k: replace(one, indices=list(one.indices)) for k, one in other._counted.items()
            }
            for ghost, before in zip(self.ghosts, other.ghosts, strict=True):
                ghost.strokes = list(before.strokes)

    def follow(self, strokes: Sequence[Stroke], current: Stroke | None = None) -> None:
        """Count the strokes that are there, and forget those that were undone.

        Of one that goes on, `current`, what it was lifted after is counted.
        """
        there = {id(stroke) for stroke in strokes}
        if current is not None:
            there.add(id(current))
        if not self._counted.keys() <= there:
            with self._keeping:
                self._counted = {k: one for k, one in self._counted.items() if k in there}
                for index, ghost in enumerate(self.ghosts):
                    ghost.strokes = [stroke for stroke in ghost.strokes if id(stroke) in there]
                    if not ghost.is_written:
                        self.marks.pop(index, None)
        for stroke in strokes:
            self._count(stroke, is_over=True)
        if current is not None:
            self._count(current, is_over=False)

    def _count(self, stroke: Stroke, *, is_over: bool) -> _Counted:
        """Give what a stroke has painted since it was counted last to its characters."""
        counted = self._counted.get(id(stroke)) or _Counted(stroke)
        samples = stroke.samples[counted.n_samples :]
        if not samples or stroke.tags.get(ERASES):
            return counted
        step = 1 if len(samples) < _MANY else _SPARSE
        # the way, not the root: that of a brush that leans is over another character
        path = object_poses(samples[::step])
        runs, n_looked = _split_by_lifts(path, is_over=is_over)
        nearest = [self._find_character(path.points[first:last]) for first, last in runs]
        indices = [index for index in nearest if index is not None]
        with self._keeping:
            self._counted[id(stroke)] = counted
            counted.n_samples += min(step * n_looked, len(samples))
            counted.indices += indices
            for index in indices:
                self.ghosts[index].strokes.append(stroke)
        return counted


@dataclass(eq=False)
class _Counted:
    """A stroke and what it was counted for: its characters' indices, and its samples so far."""

    stroke: Stroke  # held: its id stands for it
    n_samples: int = 0
    indices: list[int] = field(default_factory=list)


def _split_by_lifts(path: BrushPath, *, is_over: bool) -> tuple[list[tuple[int, int]], int]:
    """From where to before where the brush is down, and up to where that is known.

    It is one stroke as long as the brush is lifted for moments only.
    """
    n = len(path)
    if path.pressure is None:
        return ([(0, n)], n) if is_over else ([], 0)
    down = np.flatnonzero(path.pressure > 0.0)
    if not len(down):
        return [], n if is_over else 0
    lifted = np.flatnonzero(np.diff(path.time_s[down]) > _LIFTED_S)
    firsts, lasts = down[np.append(0, lifted + 1)], down[np.append(lifted, len(down) - 1)]
    runs = [(int(first), int(last) + 1) for first, last in zip(firsts, lasts, strict=True)]
    if not is_over and path.time_s[-1] - path.time_s[lasts[-1]] <= _LIFTED_S:
        return runs[:-1], runs[-1][0]
    return runs, n


def _count_inside(ghost: Ghost, points: AnyArray) -> int:
    """Number of points that lie in a character's square."""
    em = ghost.square.em_mm
    near = np.linalg.norm(points - ghost.chart.frame.origin, axis=1) < 2.0 * ghost.half.max()
    if not near.any():
        return 0
    xy = ghost.chart.coordinates(points[near], most_off=0.05 * em)
    return int(np.count_nonzero((np.abs(xy) <= ghost.half).all(axis=1)))


def _densify(line: AnyArray, closed: bool, step: float) -> AnyArray:
    """Points along a line (N, 2) at most a step apart, with its own corners."""
    from shapely import LineString, get_coordinates, segmentize

    corners = np.concatenate([line, line[:1]]) if closed else line
    points: AnyArray = get_coordinates(segmentize(LineString(corners), step))
    return points
