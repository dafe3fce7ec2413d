"""Writing characters and comparing what was painted with their copybook.

The way is the user's: glyph, plan, em square on the object, the recording of the handle, and a
painter that replays that recording alone. The score is taken from the painted surface, in the
surface's own coordinates around the character.
"""

from __future__ import annotations

import functools
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import choose_brush, load_brush
from paint3d.calligraphy.footprint_table import tabulate_footprints
from paint3d.calligraphy.glyph_sources import open_glyph_folder, open_glyphs
from paint3d.calligraphy.glyphs import Glyph
from paint3d.calligraphy.hand_motion import HandMotion, root_stretch, to_hand_motion
from paint3d.calligraphy.layout import Layout, layout_text
from paint3d.calligraphy.metrics import (
    Likeness,
    compare,
    copybook_mask,
    painted_mask,
)
from paint3d.calligraphy.path_fit import PlanSettings
from paint3d.calligraphy.planning import on_paper, plan_glyph
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.calligraphy.timing import Motion, Tempo, time_paths
from paint3d.colour.spectra import RGB_FROM_XYZ, decode_srgb
from paint3d.device.recorded import Recording
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import EmSquare, SurfaceChart, make_chart, unroll
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.found_strokes import Found, joined, score

__all__ = ["Copy", "Desk", "copy_character"]

_WIDEST = 0.2  # ems: the last footprint of the table
_NODES_PER_EM = 24.0  # finer, and the chart would follow the mesh's facets
_REACH = 0.15  # ems that the chart goes beyond the em square: there the handle may stand


@dataclass(frozen=True)
class Desk:
    """Object, brush and size that characters are written with.

    Attributes
    ----------
    glyphs : path
        An unpacked `hanzi-writer-data`.
    em_mm : float
        Side of the em square, mm.
    on : str
        An object's name or file.
    resolution_mm : float
        Of the painted surface, mm.
    brush : str, optional
        Preset; by default the one for the size.
    settings : PlanSettings
        Its azimuth is also the painter's.
    layout : Layout
        Where on the object.
    seen : bool
        Whether the painting's colours are compared, half-way from the ground to the ink in linear
        light, and not what is under paint.
    joined : {"shape", "template"}, optional
        Join the strokes of a character to one shape first, and write what is found in it: by the
        shape alone, or with the lines of the package `kanjivg`.
    """

    glyphs: Path | str
    em_mm: float = 100.0
    on: str = "plane"
    resolution_mm: float = 0.2
    brush: str | None = None
    settings: PlanSettings = field(default_factory=PlanSettings)
    layout: Layout = field(default_factory=Layout)
    seen: bool = False
    joined: str | None = None

    @property
    def brush_name(self) -> str:
        """The preset that is written with."""
        return self.brush or choose_brush(self.em_mm)


@dataclass(frozen=True, eq=False)
class Copy:
    """A character, written and compared.

    Attributes
    ----------
    text : str
    n_strokes : int
    likeness : Likeness
    seconds : float
        Processor time of planning and timing its strokes, s.
    fastest : tuple of float
        Greatest speed (mm/s), acceleration (mm/s2) and jerk (mm/s3) of the root, and turn rate
        (rad/s) of the pen, by differences of the recording.
    painted, wanted : (576, 576) bool
        The two rasters.
    found : Found, optional
        How the strokes found agree with the glyph's, and the processor time it took, s.
    """

    text: str
    n_strokes: int
    likeness: Likeness
    seconds: float
    fastest: tuple[float, float, float, float]
    painted: NDArray[np.bool_]
    wanted: NDArray[np.bool_]
    found: tuple[Found, float] | None = None


def copy_character(desk: Desk, text: str) -> Copy:
    """Write one character, from the plan to the paint, and compare it with its outlines.

    Raises
    ------
    Paint3DError
        If the character is unknown or cannot be written there.
    """
    glyph, found = open_glyph_folder(desk.glyphs).load(text), None
    if desk.joined is not None:
        glyph, found = _taken_apart(glyph, desk.joined)
    mesh, chart, square = _place(desk.on, desk.em_mm, desk.layout)
    tuft = build_tuft(load_brush(desk.brush_name))
    footprints = tabulate_footprints(tuft, _WIDEST * desk.em_mm)
    started = time.process_time()
    paths = plan_glyph(glyph, desk.em_mm, footprints, desk.settings)
    tempo = Tempo().slower(root_stretch(square.points, square.normals, tuft))
    motion = time_paths([paths], desk.em_mm, tempo)
    seconds = time.process_time() - started
    recording = _recorded(motion, to_hand_motion(motion, chart, desk.em_mm, tuft), desk)
    surface = PaintedSurface(mesh, desk.resolution_mm)
    Painter(surface, desk.brush_name, azimuth=desk.settings.azimuth).replay(recording)
    shown = _darkness(surface) if desk.seen else surface.coverage
    painted, wanted = _painted(surface, shown, chart, desk.em_mm), _wanted(glyph, desk.em_mm)
    likeness = compare(painted, wanted)
    n, fastest = len(glyph.strokes), _fastest(recording)
    return Copy(text, n, likeness, seconds, fastest, painted, wanted, found)


def _taken_apart(glyph: Glyph, by: str) -> tuple[Glyph, tuple[Found, float]]:
    """A glyph of the strokes that are found in the ink of all its strokes together."""
    ink = joined(glyph.strokes)
    template = open_glyphs(None).load(glyph.text) if by == "template" else None
    started = time.process_time()
    strokes = decompose(ink, template=template)
    seconds = time.process_time() - started
    return Glyph(glyph.text, tuple(strokes)), (score(strokes, glyph.strokes), seconds)


def _wanted(glyph: Glyph, em_mm: float) -> NDArray[np.bool_]:
    holes = [[on_paper(hole, em_mm) for hole in stroke.holes] for stroke in glyph.strokes]
    outlines = [on_paper(stroke.outline, em_mm) for stroke in glyph.strokes]
    return copybook_mask(outlines, em_mm, holes)


def _recorded(motion: Motion, hand: HandMotion, desk: Desk) -> Recording:
    """Return what the painter gets to know of it."""
    return Recording(
        np.round(motion.time_s * 1e9).astype(np.int64),
        hand.position,
        hand.orientation,
        np.minimum(hand.pressure, 1.0),
        hand.buttons,
        header={"brush": desk.brush_name, "azimuth": desk.settings.azimuth},
    )


def _darkness(surface: PaintedSurface) -> NDArray[np.float32]:
    """Compute darkness from ground, 0, to full ink, 1, in linear light of exported colours."""
    surface.refresh()
    light = decode_srgb(surface.srgb) @ np.linalg.inv(RGB_FROM_XYZ)[1]
    ground, ink = light.max(), np.median(light[surface.coverage >= 1.0])
    return np.clip((ground - light) / (ground - ink), 0.0, 1.0).astype(np.float32)


def _painted(
    surface: PaintedSurface, coverage: NDArray[np.float32], chart: SurfaceChart, em_mm: float
) -> NDArray[np.bool_]:
    """The raster of the painting in the chart around the character's em square."""
    faces = surface.paint_mesh.leaf_faces()
    faces = faces[(coverage[faces] > 0.0).any(axis=1)]
    used = np.unique(faces)
    points = np.full((len(coverage), 2), np.nan)
    points[used] = unroll(chart, surface.paint_mesh.vertices[used].astype(np.float64))
    return painted_mask(points + 0.5 * em_mm, coverage, faces, em_mm)


@functools.lru_cache(maxsize=4)
def _place(on: str, em_mm: float, layout: Layout) -> tuple[TriangleMesh, SurfaceChart, EmSquare]:
    """The object, and the chart and em square of a single character, whichever it is."""
    mesh = load_mesh(on)
    closest = ClosestPoints(mesh)
    square = layout_text(closest, "一", em_mm, layout)[0].square
    half = (0.5 + _REACH) * em_mm
    chart = make_chart(closest, square.chart.frame, half, half, em_mm / _NODES_PER_EM)
    return mesh, chart, square


def _fastest(recording: Recording) -> tuple[float, float, float, float]:
    """Greatest speed, acceleration, jerk and turn rate of a recording; mm, rad, s."""
    step = float(np.diff(recording.time_ns).mean()) * 1e-9
    rates, values = [], recording.position
    for _ in range(3):
        values = np.diff(values, axis=0) / step
        rates.append(float(np.linalg.norm(values, axis=1).max()))
    q = recording.orientation
    apart = np.linalg.norm(q[1:] - q[:-1], axis=1)
    turned = np.minimum(apart, np.linalg.norm(q[1:] + q[:-1], axis=1))
    return rates[0], rates[1], rates[2], float(4.0 * np.arcsin(0.5 * turned.max()) / step)
