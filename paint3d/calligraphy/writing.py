"""Writing on an object: glyphs, planned strokes, their boxes on the surface, one recording.

The recording of the handle holds everything: replaying it paints the text.
"""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.tuft import Tuft
from paint3d.calligraphy.dabs import loads_of
from paint3d.calligraphy.flying_white import (
    dryness_at,
    stations_of_motion,
)
from paint3d.calligraphy.footprint_table import FootprintTable, tabulate_footprints
from paint3d.calligraphy.glyph_sources import GlyphSource, load_glyphs
from paint3d.calligraphy.glyphs import EM_BOX, Glyph
from paint3d.calligraphy.hand_motion import (
    HandMotion,
    join_motions,
    move_between,
    root_stretch,
    to_hand_motion,
)
from paint3d.calligraphy.layout import LEAST_EM_MM, MOST_EM_MM, Layout, layout_text
from paint3d.calligraphy.page.laying import PlacedPiece, lay_page
from paint3d.calligraphy.page.page import Composer, Page
from paint3d.calligraphy.path_fit import PlanSettings, StrokePath
from paint3d.calligraphy.planning import on_paper, plan_glyph
from paint3d.calligraphy.processes import in_processes
from paint3d.calligraphy.timing import Motion, Tempo, time_paths
from paint3d.calligraphy.variation import vary_paths
from paint3d.core.arrays import AnyArray, as_number
from paint3d.device.recorded import Recording
from paint3d.errors import InputError, MeshError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SquareLimits, make_chart
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["WritingSettings", "Written", "plan_ahead", "write_page", "write_text"]

MOST_VARIATION = 3.0
MOST_HAND_SPEED = 4.0  # beyond, a planned way has accelerations that no hand reaches

_WIDEST = 0.2  # ems: the last footprint of the table
_NODES_PER_EM = 24.0
_STEPS_PER_EM = 64.0
_FINEST_MM = 0.25
_DECIMALS = {"position": 6, "orientation": 7, "pressure": 7}  # 1 nm: keeps the jerk unrounded
_MOST_STRETCH = 2.0
_MOST_PLANS = 500
_FEW = 3  # characters that are not worth starting processes for


@dataclass(frozen=True)
class WritingSettings:
    """Brush, size, planning and tempo of writing.

    Attributes
    ----------
    brush : BrushSpec
    em_mm : float
        Side of the em squares, mm.
    plan : PlanSettings
    tempo : Tempo
    variation : float
        0: every character as the copybook has it; 1: as a practised hand varies; at most 3.
    seed : int
        Of that variation, 0 or more: the same seed, text and settings give the same motion.
    hand_speed : float
        How many times as fast as planned it is written, 1 to 4: the same ways in less time.
    """

    brush: BrushSpec
    em_mm: float
    plan: PlanSettings = field(default_factory=PlanSettings)
    tempo: Tempo = field(default_factory=Tempo)
    variation: float = 0.0
    seed: int = 0
    hand_speed: float = 1.0


@dataclass(frozen=True, eq=False)
class Written:
    """A planned text: the recording of the hand, and where its characters lie.

    Attributes
    ----------
    recording : Recording
        In world space, the world being the object's frame.
    characters : list of dict
        ``{"text", "frame": {"origin", "x_axis", "y_axis", "em_mm"}}`` in writing order: a glyph
        unit (x, y) lies at origin + em_mm/1024 (x x_axis + (y + 124) y_axis), bent onto the
        surface. Pieces of a page have a ``"box"``, too: left, lower, right and upper side in glyph
        units; there the origin is the box's lower left corner.
    page : Page, optional
        As it was composed, where a page was written.
    dryness : (N,) float64, optional
        What fraction shall stay bare below the brush at each sample, 0 to 1; NaN where it is not
        known. None where no stroke says so.
    station : (N,) float64, optional
        Between which stations of the strokes' dryness each sample lies, counted from 0 through all
        strokes in writing order; NaN and None as there.
    stroke : (N,) int64, optional
        Which stroke is written at each sample, counted from 0 through all in writing order; -1
        between them. None where no stroke says how dry or how pale it is.
    strength : (N,) float64, optional
        How strong the ink is at each sample, see `GlyphStroke`; NaN between strokes. None where all
        is black.
    placed : tuple of PlacedPiece
        What was written, in writing order, and the squares or boxes that it lies in.
    """

    recording: Recording
    characters: list[dict[str, Any]]
    page: Page | None = None
    dryness: NDArray[np.float64] | None = None
    station: NDArray[np.float64] | None = None
    placed: tuple[PlacedPiece, ...] = ()
    strength: NDArray[np.float64] | None = None
    stroke: NDArray[np.int64] | None = None


def write_text(
    mesh: TriangleMesh,
    text: str,
    source: GlyphSource,
    settings: WritingSettings,
    layout: Layout | None = None,
    *,
    header: Mapping[str, object] | None = None,
    processes: int = 1,
    progress: Callable[[str, float], None] | None = None,
) -> Written:
    """Plan a text on an object.

    Parameters
    ----------
    mesh : TriangleMesh
    text : str
        Line breaks start a new column or row; other white space is passed over.
    source : GlyphSource
    settings : WritingSettings
    layout : Layout, optional
    header : mapping, optional
        More entries for the recording's header, such as the ink.
    processes : int
        How many to plan in at once; the result is the same to the bit. More than one needs a main
        module that can be imported, as `multiprocessing` does.
    progress : callable, optional
        Called with each character when it is planned, and the fraction done.

    Raises
    ------
    InputError
        If the text is empty, has unknown characters, does not fit, or a stroke cannot be written.
    MeshError
        If the surface has no place for a character.
    """
    as_number(settings.em_mm, "size", LEAST_EM_MM, MOST_EM_MM)
    glyphs = load_glyphs(source, "".join(text.split()))
    surface, limits = _surface_of(mesh), SquareLimits(room_mm=settings.brush.length_mm)
    characters = layout_text(surface, text, settings.em_mm, layout, limits)
    placed = [PlacedPiece(glyphs[one.text], one.square) for one in characters]
    entries = {"licence": f"{source.licence}. Motion: paint3d.", **(header or {})}
    return _write(surface, placed, settings, entries, processes, progress)


def write_page(
    mesh: TriangleMesh,
    composer: Composer,
    settings: WritingSettings,
    layout: Layout | None = None,
    *,
    header: Mapping[str, object] | None = None,
    processes: int = 1,
    progress: Callable[[str, float], None] | None = None,
) -> Written:
    """Plan a page on an object: a text in a font, a drawing, or a file of strokes.

    Parameters
    ----------
    mesh : TriangleMesh
    composer : Composer
    settings : WritingSettings
        Its em is the size of 1024 glyph units.
    layout, header, processes, progress
        As for `write_text`.

    Raises
    ------
    InputError
        If the page does not fit, or a stroke cannot be written.
    MeshError
        If the surface has no place for it.
    """
    as_number(settings.em_mm, "size", LEAST_EM_MM, MOST_EM_MM)
    surface, limits = _surface_of(mesh), SquareLimits(room_mm=settings.brush.length_mm)
    page, placed = lay_page(surface, composer, settings.em_mm, layout, limits)
    entries = {
        "licence": f"{page.licence}. Motion: paint3d.",
        "source": page.source,
        **(header or {}),
    }
    written = _write(surface, placed, settings, entries, processes, progress)
    return replace(written, page=page)


def _write(
    surface: ClosestPoints,
    placed: list[PlacedPiece],
    settings: WritingSettings,
    header: Mapping[str, object],
    processes: int,
    progress: Callable[[str, float], None] | None,
) -> Written:
    """Plan every glyph once, lay it wherever it stands, and join the motions."""
    as_number(settings.variation, "variation", 0.0, MOST_VARIATION)
    as_number(settings.hand_speed, "hand_speed", 1.0, MOST_HAND_SPEED)
    as_number(settings.seed, "seed", 0)
    tuft, footprints, settings = _prepare_tools(placed, settings)
    glyphs = {id(piece.glyph): piece.glyph for piece in placed}
    plans: dict[int, list[StrokePath]] = {}
    with closing(_plan_all(glyphs.values(), footprints, settings, processes)) as planned:
        for (key, glyph), paths in zip(glyphs.items(), planned, strict=True):
            plans[key] = paths
            if progress is not None:
                progress(glyph.text, len(plans) / len(glyphs))
    em_mm, varies = settings.em_mm, settings.variation > 0.0
    laid: list[HandMotion] = []
    motions: list[Motion] = []
    unvaried: dict[int, Motion] = {}
    keeps = any(one.dryness or one.strength < 1.0 for it in glyphs.values() for one in it.strokes)
    for k, piece in enumerate(placed):
        key, glyph = id(piece.glyph), piece.glyph
        if varies and not glyph.solid:
            middle, seed = on_paper(np.array(glyph.middle), em_mm), [settings.seed, k]
            paths = vary_paths(
                plans[key], middle, em_mm, settings.variation, seed, joined=glyph.joined
            )
            motion = time_paths([paths], em_mm, settings.tempo)
        else:  # once for all pieces; of a filled shape nothing is to stay bare
            if key not in unvaried:
                loads = loads_of(plans[key], em_mm, footprints) if glyph.solid else [plans[key]]
                unvaried[key] = time_paths(loads, em_mm, settings.tempo)
            motion = unvaried[key]
        laid.append(_lay_piece(surface, piece, motion, tuft, settings))
        if keeps:  # of a long text they are large
            motions.append(motion)
    characters = [_describe_piece(piece) for piece in placed]
    entries = {
        "brush": settings.brush.name,
        "object": surface.mesh.name,
        "licence": header["licence"],
        "azimuth": settings.plan.azimuth,
        **({"variation": settings.variation, "seed": settings.seed} if settings.variation else {}),
        **header,
        "characters": characters,
    }
    parts = laid[:1]
    for following in laid[1:]:
        parts += [move_between(parts[-1], following, surface, tuft, settings.tempo), following]
    hand = join_motions(parts)
    rate_hz = settings.tempo.rate_hz * settings.hand_speed
    recording = Recording(
        round(1e9 / rate_hz) * np.arange(len(hand.position), dtype=np.int64),
        _round_finite(hand.position, "position"),
        _round_finite(hand.orientation, "orientation"),
        np.minimum(_round_finite(hand.pressure, "pressure"), 1.0),
        hand.buttons,
        header={"devices": {"right": f"planned, {rate_hz:g} Hz"}, **entries},
    )
    written = Written(recording, characters, placed=tuple(placed))
    stations = partial(stations_of_motion, em_mm=settings.em_mm, footprints=footprints)
    return _with_ink_per_sample(written, motions, parts, stations)


def _prepare_tools(
    placed: Sequence[PlacedPiece], settings: WritingSettings
) -> tuple[Tuft, FootprintTable, WritingSettings]:
    """The tuft and its footprints, and the settings in the tempo that the surface asks for."""
    tuft = build_tuft(settings.brush)
    footprints = tabulate_footprints(tuft, _WIDEST * settings.em_mm)
    squares = [piece.square for piece in placed]
    stretch = max(root_stretch(square.points, square.normals, tuft) for square in squares)
    tempo = settings.tempo.slower(min(_MOST_STRETCH, stretch))  # rough spots count as 2
    return tuft, footprints, replace(settings, tempo=tempo)


def plan_ahead(placed: Sequence[PlacedPiece], settings: WritingSettings) -> Generator[None]:
    """Plan what lies on an object before it is to be written, glyph by glyph.

    In a process that gives way to others; what is planned then need not be planned by `write_text`
    and `write_page` any more. It may be ended at any time.
    """
    _, footprints, settings = _prepare_tools(placed, settings)
    glyphs = {id(piece.glyph): piece.glyph for piece in placed}
    with closing(_plan_all(glyphs.values(), footprints, settings, 1, apart=True)) as plans:
        for _ in plans:
            yield


def _with_ink_per_sample(
    written: Written,
    motions: Sequence[Motion],
    parts: Sequence[HandMotion],
    stations: Callable[[Motion, Glyph], NDArray[np.float64]],
) -> Written:
    """Recording of what is written, with how dry and how strong its strokes are."""
    glyphs = [piece.glyph for piece in written.placed]
    strokes = [stroke for glyph in glyphs for stroke in glyph.strokes]
    asked = [fraction for stroke in strokes for fraction in stroke.dryness]
    pale = any(stroke.strength < 1.0 for stroke in strokes)
    if not asked and not pale:
        return written

    own = []
    for glyph, motion in zip(glyphs, motions, strict=True):
        one = np.minimum(motion.stroke, len(glyph.strokes) - 1)  # dabs: the last one's
        own.append(np.where(one >= 0, one, np.nan))
    counted = _count_through(parts, own, [len(glyph.strokes) for glyph in glyphs])
    stroke = np.nan_to_num(counted, nan=-1.0).astype(np.int64)
    written = replace(written, stroke=stroke)
    if pale:
        strength = np.array([*(one.strength for one in strokes), np.nan])[stroke]
        written = replace(written, strength=strength)
    if asked:
        own = [stations(motion, glyph) for glyph, motion in zip(glyphs, motions, strict=True)]
        counts = [sum(len(one.dryness) for one in glyph.strokes) for glyph in glyphs]
        station = _count_through(parts, own, counts)
        dryness = dryness_at(station, np.array(asked))
        written = replace(written, dryness=dryness, station=station)
    return written


def _count_through(
    parts: Sequence[HandMotion], own: Sequence[NDArray[np.float64]], counts: Sequence[int]
) -> NDArray[np.float64]:
    """Counts of glyphs at their own samples, counted on through all of them (N,).

    Every other part is the move to the next glyph: NaN.
    """
    values, first = [np.full(len(part.pressure), np.nan) for part in parts], 0
    for k, (one, count) in enumerate(zip(own, counts, strict=True)):
        values[2 * k] = first + one
        first += count
    return np.concatenate(values)


@lru_cache(maxsize=1)
def _surface_of(mesh: TriangleMesh) -> ClosestPoints:
    """The mesh's closest points; the last are cached, as texts on one object often follow."""
    return ClosestPoints(mesh)


# -- planning -----------------------------------------------------------------------------------


class _Plans:
    """Strokes of glyphs that were planned before, the last ones used.

    Several threads may ask.
    """

    def __init__(self) -> None:
        self._cached: OrderedDict[bytes, list[StrokePath]] = OrderedDict()
        self._lock = threading.Lock()

    def find(self, key: bytes) -> list[StrokePath] | None:
        """The strokes of a key; None where it is not known."""
        with self._lock:
            if key in self._cached:
                self._cached.move_to_end(key)
            return self._cached.get(key)

    def keep(self, key: bytes, paths: list[StrokePath]) -> None:
        """Cache them, in place of those that were used least lately."""
        with self._lock:
            self._cached[key] = paths
            while len(self._cached) > _MOST_PLANS:
                self._cached.popitem(last=False)


_plans = _Plans()


def _plan_key(glyph: Glyph, settings: WritingSettings) -> bytes:
    """A digest of all that a glyph's planned strokes depend on."""
    words = repr((glyph.box, glyph.solid, settings.brush, settings.em_mm, settings.plan)).encode()
    digest = hashlib.sha256(words)
    for stroke in glyph.strokes:
        for ring in (stroke.outline, stroke.median, *stroke.holes):
            digest.update(repr(ring.shape).encode() + ring.tobytes())
    return digest.digest()


def _plan_all(
    glyphs: Collection[Glyph],
    footprints: FootprintTable,
    settings: WritingSettings,
    processes: int,
    *,
    apart: bool = False,
) -> Generator[list[StrokePath]]:
    """The planned strokes of glyphs in their order; few are planned here, stroke beside stroke.

    What was planned before is not planned again. With `apart` nothing is planned in this process.
    """
    keys = [_plan_key(glyph, settings) for glyph in glyphs]
    known = [_plans.find(key) for key in keys]
    lacking = [glyph for glyph, paths in zip(glyphs, known, strict=True) if paths is None]
    n = min(processes, len(lacking))
    if not apart and (n < 2 or len(lacking) < _FEW):
        made = (_plan_glyph(glyph, footprints, settings, processes) for glyph in lacking)
    else:
        work = partial(_plan_glyph, footprints=footprints, settings=settings)
        made = in_processes(work, lacking, n, is_patient=apart)
    with closing(made):
        for key, paths in zip(keys, known, strict=True):
            if paths is None:
                paths = next(made)
                _plans.keep(key, paths)
            yield paths


def _plan_glyph(
    glyph: Glyph, footprints: FootprintTable, settings: WritingSettings, threads: int = 1
) -> list[StrokePath]:
    return plan_glyph(glyph, settings.em_mm, footprints, settings.plan, threads)


# -- laying -------------------------------------------------------------------------------------


def _lay_piece(
    surface: ClosestPoints,
    piece: PlacedPiece,
    motion: Motion,
    tuft: Tuft,
    settings: WritingSettings,
) -> HandMotion:
    """A piece's motion on the surface; the chart reaches as far as the handle goes."""
    em, square = settings.em_mm, piece.square
    middle = on_paper(np.array(piece.glyph.middle), em)
    reach = np.abs(motion.handle - middle).max(axis=0)
    half = 0.5 * np.array([square.width_mm, square.height_mm])
    half_width, half_height = np.maximum(reach, half) + 0.01 * em
    step = max(_FINEST_MM, em / _STEPS_PER_EM)
    frame = square.chart.frame
    try:
        chart = make_chart(surface, frame, half_width, half_height, em / _NODES_PER_EM, step)
    except MeshError as cause:
        raise MeshError(
            "{glyph!r}: its strokes reach beyond where one can write ({cause}); expected a smaller "
            "size or another place",
            glyph=piece.glyph.text,
            cause=cause,
        ) from None
    return to_hand_motion(motion, chart, em, tuft, middle)


def _describe_piece(piece: PlacedPiece) -> dict[str, Any]:
    """A piece's entry in the report and in the recording's header."""
    square, box = piece.square, piece.glyph.box
    frame = square.chart.frame
    entry: dict[str, Any] = {
        "text": piece.glyph.text,
        "frame": {
            "origin": square.points[0, 0].round(4).tolist(),
            "x_axis": frame.x_axis.round(7).tolist(),
            "y_axis": frame.y_axis.round(7).tolist(),
            "em_mm": square.em_mm,
        },
    }
    return entry if box == EM_BOX else {**entry, "box": [round(side, 3) for side in box]}


def _round_finite(values: AnyArray, what: str) -> AnyArray:
    if not np.isfinite(values).all():
        raise InputError("the plan's {what} is not finite; expected numbers", what=what)
    return np.round(values, _DECIMALS[what])
