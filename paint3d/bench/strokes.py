"""Meshes and strokes to measure on, and their painting: grids, dabs along a Lissajous figure.

The figure is the one that painting programs are compared on: 3 to 2, all over a square grid, one
dab every 5 ms. Footprints are brought to size by the spacing of the mesh, never by the brush: what
runs is a brush as it ships, upright and fully pressed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from paint3d.bench.stopwatch import Times, timed_once
from paint3d.brush.bending import tuft_on
from paint3d.brush.footprint import Footprint, make_footprint
from paint3d.brush.presets import load_brush
from paint3d.brush.spec import BrushSpec
from paint3d.colour.materials import load_material
from paint3d.core.arrays import AnyArray
from paint3d.core.quaternion import quaternions_from_matrices
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "FRAME_HZ",
    "Dab",
    "LiveTimes",
    "figure_for",
    "frames_of",
    "make_dab",
    "make_grid",
    "play",
    "play_live",
    "record_dabs",
    "refined_surface",
]

DAB_S = 0.005
"""Time from one dab to the next, s."""
_COARSE_MM = 1.6  # resolution that refining begins with
_MARGIN = 1.05  # of the footprint's radius: what the figure keeps from the border of the mesh


@dataclass(frozen=True)
class Dab:
    """A brush standing upright on a plane, and the footprint it leaves."""

    brush: BrushSpec
    pressure: float
    footprint: Footprint

    @property
    def radius(self) -> float:
        """Radius of the disc of the same area, mm."""
        return math.sqrt(self.footprint.area / math.pi)

    @property
    def middle(self) -> float:
        """Distance of the footprint's middle from the pen along the bend, mm."""
        return 0.5 * float(self.footprint.reach[0] + self.footprint.reach[-1])

    @property
    def root_height(self) -> float:
        """Height of the tuft's root over the plane, mm."""
        return self.brush.length_mm - self.pressure * self.brush.full_press_mm


def make_dab(brush: str = "full", pressure: float = 1.0) -> Dab:
    """Make the dab of a brush as it ships, on porcelain, the default material of surfaces.

    Raises
    ------
    UnknownNameError, BrushError
        For a brush that is not known, or a pressure that leaves no footprint.
    """
    spec = load_brush(brush)
    tuft = tuft_on(spec, load_material("porcelain"))
    footprint = make_footprint(tuft, pressure * spec.full_press_mm, 0.5 * math.pi).rounded()
    return Dab(spec, pressure, footprint)


def make_grid(n_vertices: int, spacing: float) -> TriangleMesh:
    """Make a square of about so many vertices in z = 0, centred on the origin, facing +z.

    Parameters
    ----------
    n_vertices : int
        At least 4; the next square number is taken.
    spacing : float
        Between neighbours, mm.
    """
    side = math.ceil(math.sqrt(n_vertices))
    line = (np.arange(side) - 0.5 * (side - 1)) * spacing
    y, x = (axis.ravel() for axis in np.meshgrid(line, line, indexing="ij"))
    ids = np.arange(side * side, dtype=np.int32).reshape(side, side)
    a, b, c, d = (
        ids[rows, columns].ravel()
        for rows, columns in (
            (slice(None, -1), slice(None, -1)),
            (slice(None, -1), slice(1, None)),
            (slice(1, None), slice(1, None)),
            (slice(1, None), slice(None, -1)),
        )
    )
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return TriangleMesh(np.stack([x, y, np.zeros_like(x)], axis=1), faces, name="grid")


def refined_surface(mesh: TriangleMesh, n_vertices: int) -> PaintedSurface:
    """Make a surface that is refined all over to at least so many vertices.

    Not many more on an uneven mesh; on an even one all triangles are halved together.
    """
    resolution = _COARSE_MM
    while True:
        surface = PaintedSurface(mesh, resolution=resolution)
        surface.refine_all()
        if surface.n_vertices >= n_vertices:
            return surface
        lacking = (surface.n_vertices / n_vertices) ** 0.5
        resolution *= max(0.35, min(0.97, 0.995 * lacking))


def lissajous(n_dabs: int, half_width: float) -> AnyArray:
    """Compute dab centres (N, 2) on the 3 to 2 figure of half width `half_width`, mm."""
    turn = np.linspace(0.0, 2.0 * math.pi, n_dabs, endpoint=False)
    return half_width * np.stack([np.sin(3.0 * turn + 0.3), np.sin(2.0 * turn)], axis=1)


def figure_for(mesh: TriangleMesh, radius: float, n_dabs: int) -> AnyArray:
    """Compute dab centres (N, 3), mm, all over a square in the xy plane centred on the origin."""
    half_width = float(mesh.bounds[1, 0]) - _MARGIN * radius
    return np.column_stack([lissajous(n_dabs, half_width), np.zeros(n_dabs)])


def record_dabs(dab: Dab, centres: ArrayLike, normal: ArrayLike = (0.0, 0.0, 1.0)) -> Recording:
    """Record one stroke with one sample a dab, `DAB_S` apart.

    Parameters
    ----------
    dab : Dab
    centres : (N, 3) array_like
        Where the middles of the footprints come to lie, mm.
    normal : (3,) array_like
        Of the plane they lie in. The tuft bends along the x axis laid into it (or along y or z
        where that is farther from the normal).
    """
    points = np.asarray(centres, dtype=np.float64)
    up = np.asarray(normal, dtype=np.float64) / np.linalg.norm(normal)
    axis = np.eye(3)[np.argmin(np.abs(up))]
    along = axis - (axis @ up) * up
    along /= np.linalg.norm(along)
    turn = quaternions_from_matrices(np.stack([along, np.cross(up, along), up], axis=1))
    n = len(points)
    return Recording(
        time_ns=(np.arange(n) * round(DAB_S * 1e9)).astype(np.int64),
        position=points + dab.root_height * up - dab.middle * along,
        orientation=np.tile(turn, (n, 1)),
        pressure=np.full(n, dab.pressure),
    )


# ---- Painting them -------------------------------------------------------------------------------

FRAME_HZ = 30.0


@dataclass(frozen=True)
class LiveTimes:
    """Cost of a stroke, and how much of it the colours of a recording took (wall, s)."""

    whole: Times
    colour_s: float

    def best(self, other: LiveTimes) -> LiveTimes:
        """Return the smaller of each."""
        return LiveTimes(self.whole.best(other.whole), min(self.colour_s, other.colour_s))


def frames_of(recording: Recording) -> list[list[DeviceSample]]:
    """Divide the samples by frames of the stroke's own time, as a live device gives them."""
    seconds = (recording.time_ns - recording.time_ns[0]) * 1e-9
    frame = np.floor(seconds * FRAME_HZ).astype(np.int64)
    frames: list[list[DeviceSample]] = [[] for _ in range(int(frame[-1]) + 1)]
    for at, sample in zip(frame, recording.samples(), strict=True):
        frames[at].append(sample)
    return frames


def play(painter: Painter, recording: Recording) -> LiveTimes:
    """Paint a recording, colours included; the brush is dipped before."""
    return _timed(painter, lambda: painter.replay(recording, frame_rate=FRAME_HZ))


def play_live(painter: Painter, frames: list[list[DeviceSample]]) -> LiveTimes:
    """Paint frames of samples as fast as possible, colours included."""

    def paint() -> None:
        for samples in frames:
            painter.advance(samples)
            painter.surface.refresh()
        painter.finish()
        painter.surface.refresh()

    return _timed(painter, paint)


def _timed(painter: Painter, paint: Callable[[], None]) -> LiveTimes:
    painter.dip()
    painter.surface.refresh()
    colour_before = painter.seconds["colour"]
    whole = timed_once(paint)
    return LiveTimes(whole, painter.seconds["colour"] - colour_before)
