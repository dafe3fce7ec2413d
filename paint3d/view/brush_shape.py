"""The shape of a brush: its tuft as the model bends it, its handle, and its outline on the surface.

Points are in the frame of the bend plane until they are placed: `along` from the root's foot to the
tip, `up` along the plane's normal, `side` across (`brush_engine.tuft`). The sections are the
papers' (Guo 2017, Eqs. 2, 3, 6): ellipses about the bent spine, wide across and thin in the bend
plane. The part on the surface is then deformed to the painted outline, which differs where the tuft
lies in a heap or its hairs are displaced; the deformation fades towards the root. Hairs that have
parted are drawn apart.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.bristles.bend import Bristles
from paint3d.brush_engine.footprint import PROFILE_CELLS
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, trace_outline
from paint3d.brush_engine.tuft import STATIONS, Tuft, greatest_descent, trace_spine
from paint3d.colour.materials import Material, load_material
from paint3d.colour.pigments import Pigment
from paint3d.core.arrays import AnyArray, cross
from paint3d.device.sample import DeviceSample
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.kernels.drape import ring_normals
from paint3d.view.pressed_tuft import Clumps, PressedTuft

__all__ = [
    "AROUND",
    "MOST_LINES",
    "PRESSES",
    "BrushStand",
    "SingleHairs",
    "draw_brush",
    "draw_footprints",
    "draw_stroke",
    "grid_faces",
    "grid_normals",
    "handle_rings",
    "torn_faces",
    "tuft_rings",
]

AROUND = 44  # points around a section of the tuft, and of the handle
_HAIR_RELIEF = (0.05, 0.2)  # relief of hairs on a section: fraction of the radius, at most mm
_GATHERED = 0.5  # fraction of the length from the root over which the spread fades
_POINTED = 0.07  # fraction of the length: the larger, the finer the tip of a free tuft
_OUTLINE_POINTS = 33  # on either side, from the heel to the tip
_TORN = 0.25  # mm: columns of different points further apart than this are not joined
_OWN_SECTION = 0.8  # mm between points at which each has a section of its own
_MOST_WIDENED = 12.0  # greatest widening, near the ends, where the sections' outline has no width
_FOOT = 0.6  # mm over the plane below which points are deformed to the outline
_LIFT = 0.12  # mm of the lowest hairs above the surface, against z-fighting
_HANDLE = (  # distance up the handle over the tuft's length, radius over the root's, material
    (-0.04, 1.00, 0), (-0.02, 1.10, 0), (0.10, 1.14, 0), (0.32, 1.02, 0), (0.34, 0.93, 0),
    (0.36, 0.86, 1), (0.60, 0.80, 1), (1.10, 0.78, 1), (1.12, 0.81, 2), (1.15, 0.81, 2),
    (1.18, 0.77, 1), (1.70, 0.75, 1), (2.20, 0.73, 1), (2.22, 0.76, 2), (2.25, 0.76, 2),
    (2.28, 0.72, 1), (3.10, 0.68, 1), (3.12, 0.72, 0), (3.30, 0.70, 0), (3.35, 0.55, 0),
    (3.37, 0.02, 0),
)  # fmt: skip
_PARTS = np.array([[44, 30, 24], [196, 158, 104], [150, 108, 62]], np.float64)  # horn, bamboo, node


@dataclass(frozen=True, eq=False)
class BrushStand:
    """The pose of a brush: touching the surface, above it, or far from it.

    Attributes
    ----------
    root : (3,) float64
        mm; where the tuft meets the ferrule.
    axes : (3, 3) float64
        Rows: along, side and up of the bend plane.
    origin : (3,) float64
        Origin of along and up, mm.
    descent, tilt, pressure : float
        mm, rad, 0 to 1.
    handle : (3,) float64
        Unit, up the handle.
    pressed : PressedTuft or None
        The tuft on the surface; None if it does not touch it.
    """

    root: NDArray[np.float64]
    axes: NDArray[np.float64]
    origin: NDArray[np.float64]
    descent: float
    tilt: float
    pressure: float
    handle: NDArray[np.float64]
    pressed: PressedTuft | None = None

    @classmethod
    def of(
        cls, tuft: Tuft, root: AnyArray, axes: AnyArray, pressed: PressedTuft | None
    ) -> BrushStand:
        """Return the stand of a brush in a pose.

        Parameters
        ----------
        tuft : Tuft
        root : (3,)
            The pose's position, mm.
        axes : (3, 3)
            Columns x, y, z of the pose: z is up the handle, x is the commanded bend.
        pressed : PressedTuft or None
            The tuft in that pose.
        """
        x, y, z = np.asarray(axes, np.float64).T
        if pressed is None:
            frame = np.stack([x, -y, z])
            return cls(root, frame, root - tuft.length * z, 0.0, 0.5 * np.pi, 0.0, z)
        side = cross(pressed.normal, pressed.bend)
        frame = np.stack([pressed.bend, side, pressed.normal])
        tilt, origin, descent = pressed.tilt, pressed.origin, pressed.descent
        stand = origin + (tuft.length * np.sin(tilt) - descent) * pressed.normal
        return cls(stand, frame, origin, descent, tilt, pressed.pressure, z, pressed)

    @property
    def touches(self) -> bool:
        """Whether the tuft is bent by the surface."""
        return self.pressed is not None

    def place(self, points: AnyArray) -> AnyArray:
        """Transform points (..., 3) of along, side and up to the object's frame, mm."""
        return self.origin + points @ self.axes

    def outline(self) -> AnyArray:
        """Return the closed outline (N, 3) of the footprint in the plane, mm; empty if none."""
        if self.pressed is None:
            return np.empty((0, 3))
        pressed = self.pressed
        even = np.linspace(pressed.heel, pressed.tip, PROFILE_CELLS + 1)
        t = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, _OUTLINE_POINTS))  # denser at the ends
        reach = pressed.heel + t * (pressed.tip - pressed.heel)
        half = np.interp(reach, even, pressed.half_widths)
        sides = np.concatenate([half[::-1], -half])
        along = np.concatenate([reach[::-1], reach])
        return self.place(np.stack([along, sides, np.zeros(2 * len(half))], axis=1))


def tuft_rings(tuft: Tuft, stand: BrushStand) -> tuple[AnyArray, AnyArray]:
    """Return the surface of the tuft as rings.

    Returns
    -------
    points : (R, AROUND, 3) float64
        mm, the tip's ring first; a ring on the surface is flattened by it.
    arc : (R,) float64
        Arc length of each ring from the tip, 0 to 1.
    """
    arc = tuft.arcs
    if stand.touches:
        along, up, angle = spine = np.empty((3, STATIONS))
        trace_spine(tuft, stand.descent, stand.tilt, spine)
    else:
        along, up, angle = np.zeros_like(arc), arc, np.full_like(arc, 0.5 * np.pi)
    radius = 0.5 * tuft.diameters
    if not stand.touches:  # free wet hairs gather to a point
        t = arc / tuft.length
        radius = radius * (1.0 + _POINTED) * t / (t + _POINTED)
    pressed = stand.pressed
    lying = 0.0 if pressed is None else _lying_fraction(tuft, stand, (along, up, angle))
    # In the model all but the last segment spread equally; the part in the air is drawn gathered.
    gathered = min(_GATHERED, 1.0 - lying)
    fade = np.clip((1.0 - arc / tuft.length) / gathered, 0.0, 1.0)
    fade = fade * fade * (3.0 - 2.0 * fade)
    spread = 1.0 + (0.0 if pressed is None else pressed.spread * stand.pressure * fade)
    turn = 2.0 * np.pi * np.arange(AROUND) / AROUND
    rough = np.minimum(_HAIR_RELIEF[0], _HAIR_RELIEF[1] / np.maximum(radius * spread, 1e-9))
    relief = 1.0 + (_hair_noise() - 0.5) * (rough * np.sqrt(np.maximum(0.0, fade)))[:, None]
    minor = (radius / spread)[:, None] * np.cos(turn) * relief
    major = (radius * spread)[:, None] * np.sin(turn) * relief
    points = np.stack(
        [
            along[:, None] + minor * np.sin(angle)[:, None],
            major,
            up[:, None] + minor * np.cos(angle)[:, None],
        ],
        axis=2,
    )
    if pressed is not None:
        weight = 1.0 - np.clip((arc / tuft.length - lying) / max(1.0 - lying, 1e-6), 0.0, 1.0)
        weight = weight * weight * (3.0 - 2.0 * weight)
        _fit_to_outline(points, weight, _model_outline(tuft, stand), pressed)
        _turn_to_handle(points, 1.0 - weight, stand)
        if pressed.clumps is not None:
            _part(points, arc / tuft.length, pressed.clumps)
        points[..., 2] = np.maximum(points[..., 2], _LIFT)
    return stand.place(points), arc / tuft.length


def _lying_fraction(
    tuft: Tuft, stand: BrushStand, spine: tuple[AnyArray, AnyArray, AnyArray]
) -> float:
    """Return the fraction of the tuft's length, from the tip, whose underside lies on the plane."""
    assert stand.pressed is not None, "it touches"
    _, up, angle = spine
    spread = 1.0 + stand.pressed.spread * stand.pressure
    lies = up <= 0.5 * tuft.diameters / spread * np.abs(np.cos(angle))
    last = np.flatnonzero(~lies)
    return float(tuft.arcs[last[0] if len(last) else -1] / tuft.length)


def _model_outline(tuft: Tuft, stand: BrushStand) -> tuple[AnyArray, AnyArray]:
    """Return reach and half width (mm), heel first, of the outline of the model's sections."""
    reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    assert stand.pressed is not None, "it touches"
    driven = tuft._replace(spread=stand.pressed.spread)
    scratch = np.empty(SCRATCH_SIZE)
    n = trace_outline(driven, stand.descent, stand.tilt, stand.pressure, scratch, reach, half)
    return reach[:n][::-1], half[:n][::-1]


def _fit_to_outline(
    points: AnyArray, weight: AnyArray, model: tuple[AnyArray, AnyArray], pressed: PressedTuft
) -> None:
    """Deform rings (R, AROUND, 3) from the model's outline to the painted one, by weights (R,)."""
    reach, half = model
    if not len(reach):
        return
    low, high = float(reach[0]), float(reach[-1])
    even = np.linspace(low, high, PROFILE_CELLS + 1)
    wider = pressed.half_widths / np.maximum(np.interp(even, reach, half), 1e-3)
    wider[0], wider[-1] = wider[1], wider[-2]
    whole = float(pressed.half_widths.max() / half.max())
    scale = (pressed.tip - pressed.heel) / (high - low)
    x, height = points[..., 0], points[..., 2]
    moved = pressed.heel + scale * (np.maximum(x, low) - low) + np.minimum(x - low, 0.0)
    foot = np.clip(1.0 - height / _FOOT, 0.0, 1.0) * (x >= low)
    times = whole + foot * (np.interp(x, even, np.minimum(wider, _MOST_WIDENED)) - whole)
    points[..., 0] = x + weight[:, None] * (moved - x)
    points[..., 1] *= 1.0 + weight[:, None] * (times - 1.0)


def _turn_to_handle(points: AnyArray, weight: AnyArray, stand: BrushStand) -> None:
    """Rotate sections (R, AROUND, 3) about their middles towards the handle, by weights (R,).

    The model bends a tuft in one plane, which does not contain a handle that leans sideways: the
    spine stays in place, and the section at the root is made to fit the ferrule.
    """
    root = np.array([-np.cos(stand.tilt), 0.0, np.sin(stand.tilt)])
    handle = stand.axes @ stand.handle
    axis = cross(root, handle)
    sine, cosine = float(np.linalg.norm(axis)), float(root @ handle)
    turned = np.flatnonzero(weight > 0.0)
    if sine < 1e-6 or not len(turned):
        return
    axis /= sine
    angle = (weight[turned] * np.arctan2(sine, cosine))[:, None, None]
    middle = points[turned].mean(axis=1, keepdims=True)
    arm = points[turned] - middle
    x, y, z = axis
    across = arm @ np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # axis x arm
    along = (arm @ axis)[..., None] * axis
    # Rodrigues' rotation formula
    points[turned] = middle + along + np.cos(angle) * (arm - along) + np.sin(angle) * across


def _part(points: AnyArray, arc: AnyArray, clumps: Clumps) -> None:
    """Pull hairs (R, AROUND, 3) to the middles of their clumps and points, within the outline.

    As `brush_engine.bristles.bend` moves hairs, by the arc length of their rings (R,); the
    permanent bend is measured from the tip, where the stamp has it. Points get sections of their
    own.
    """
    free = 1.0 - arc
    points[..., 1] += (clumps.set_y * (free * free - 1.0))[:, None]
    points[..., 0] += (clumps.set_x * (free * free - 1.0))[:, None] * (arc > 0.0)[:, None]
    pull, at, _ = _pulls(clumps)
    aside = np.minimum(1.0, 1.6 * free) * np.abs(points[..., 1]).max(axis=1)
    points[..., 1] += aside[:, None] * pull
    apart = np.minimum(1.0, aside * clumps.pulls[2] / _OWN_SECTION)[:, None]
    thin = 1.0 - apart * (1.0 - np.sqrt(1.0 - at * at))
    for axis in (0, 2):
        middle = points[..., axis].mean(axis=1, keepdims=True)
        points[..., axis] = middle + thin * (points[..., axis] - middle)


def _pulls(clumps: Clumps) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return the displacement of each column (AROUND,), in half widths of the tuft; its position in
    its point, -1 to 1; and whether the next column belongs to another point."""
    even = _even_places()
    cells = clumps.middles.shape[1]
    cell = np.minimum(cells - 1, ((even + 1.0) * 0.5 * cells).astype(int))
    large, small, point = clumps.middles[:, cell] - even
    pull = clumps.pulls @ np.stack([large, small, point])
    rim = np.where(even > 0.0, pull[np.argmax(even)], pull[np.argmin(even)])
    ends = np.append(np.flatnonzero(np.diff(clumps.middles[2])) + 1, cells)
    which = np.searchsorted(ends, cell, side="right")
    edges = 2.0 * np.concatenate([[0], ends]) / cells - 1.0
    low, high = edges[which], edges[which + 1]
    at = np.clip((2.0 * even - low - high) / (high - low), -1.0, 1.0)
    return pull - np.abs(even) * rim, at, which != np.roll(which, -1)


@cache
def _even_places() -> AnyArray:
    """Return the positions (AROUND,) of columns across an evenly spread tuft, -1 to 1."""
    b = np.sin(2.0 * np.pi * np.arange(AROUND) / AROUND)
    side = np.minimum(np.abs(b), 1.0)
    even = np.arcsin(side) + side * np.sqrt(1.0 - side * side)
    result: AnyArray = np.sign(b) * 2.0 / np.pi * even
    return result


@cache
def _hair_noise() -> AnyArray:
    """Return the relief (AROUND,) of each column of hairs in [0, 1], always the same."""
    return np.random.default_rng(5).random(AROUND)


def handle_rings(tuft: Tuft, stand: BrushStand) -> tuple[AnyArray, AnyArray]:
    """Return the ferrule and the handle as rings.

    Returns
    -------
    points : (R, AROUND, 3) float64, mm
    colours : (R, AROUND, 3) float64
        sRGB, 0 to 255.
    """
    profile = np.array(_HANDLE)
    length = min(max(tuft.length, 22.0), 46.0)  # keeps a small brush's handle of a real size
    thick = 0.5 * max(tuft.diameters[-1], 0.14 * length)
    ahead = np.array([1.0, 0.0, 0.0]) if abs(stand.handle[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = cross(stand.handle, ahead)
    x /= np.linalg.norm(x)
    y = cross(stand.handle, x)
    turn = 2.0 * np.pi * np.arange(AROUND) / AROUND
    circle = np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y
    slim = np.where(profile[:, 0] < 0.35, 0.5 * tuft.diameters[-1], thick)
    radius = profile[:, 1] * slim
    centre = stand.root + (profile[:, 0] * length)[:, None] * stand.handle
    points = centre[:, None, :] + radius[:, None, None] * circle[None]
    colours = np.repeat(_PARTS[profile[:, 2].astype(int)][:, None], AROUND, axis=1)
    grain = 1.0 + 0.06 * (_hair_noise() - 0.5)
    return points, colours * grain[None, :, None]


@cache
def grid_faces(rows: int, columns: int = AROUND) -> NDArray[np.int32]:
    """Return the triangles (L, 3) int32 between closed rings; always the same array."""
    ring = np.arange(columns)
    after = (ring + 1) % columns
    below = columns * np.arange(rows - 1)[:, None]
    a, b = below + ring, below + after
    c, d = a + columns, b + columns
    faces = np.stack([np.stack([a, b, d], axis=-1), np.stack([a, d, c], axis=-1)], axis=2)
    return faces.reshape(-1, 3).astype(np.int32)


def torn_faces(tuft: Tuft, pressed: PressedTuft) -> NDArray[np.int32] | None:
    """Return the triangles between a tuft's rings, without those across splits; None: all."""
    clumps = pressed.clumps
    if clumps is None:
        return None
    pull, _, ends = _pulls(clumps)
    apart = np.abs(np.roll(pull, -1) - pull) * ends
    wide = 0.5 * tuft.diameters * (1.0 + pressed.spread * pressed.pressure)
    free = np.minimum(1.0, 1.6 * (1.0 - tuft.arcs / tuft.length))
    torn = (free * wide)[:, None] * apart > _TORN
    if not torn.any():
        return None
    whole = np.repeat(~torn[:-1].ravel(), 2)
    result: NDArray[np.int32] = grid_faces(len(wide))[whole]
    return result


def grid_normals(points: AnyArray) -> NDArray[np.float32]:
    """Return outward unit normals (R, AROUND, 3) float32 of rings of points."""
    normals = np.empty(points.shape, np.float32)
    ring_normals(np.ascontiguousarray(points, np.float64), normals)
    return normals


# ---- Single hairs --------------------------------------------------------------------------------
# The single hairs of a tuft as lines that follow the shape of the tuft.
#
# Hairs stand in the ferrule as `paint3d.brush.bristles` places them; along the tuft each keeps its
# position in the section, so that it is bent, spread, parted and laid on the surface as the tuft's
# rings are. A hair that is shorter than the longest ends above the tip.


MOST_LINES = 400
"""Greatest number of hairs drawn, evenly chosen over the section."""

_STATIONS = 11  # points of a line
_CROWDED = 1.6  # exponent that crowds them towards the tip, where hairs bend most


class SingleHairs:
    """Lines for the hairs of one tuft.

    Parameters
    ----------
    tuft : Tuft
    bristles : Bristles
    around : int
        Points of a ring of the tuft.

    Attributes
    ----------
    count : int
        Number of lines.
    line_mm : float
        Width of a line, mm: that of the hairs it stands for, side by side.
    """

    def __init__(self, tuft: Tuft, bristles: Bristles, around: int) -> None:
        n = min(bristles.count, MOST_LINES)
        chosen = np.linspace(0.0, bristles.count - 1.0, n).round().astype(np.int64)
        a, b = (bristles.places[k].reshape(-1)[chosen] for k in range(2))
        lengths = bristles.lengths.reshape(-1)[chosen].astype(np.float64)
        self.count = n
        self.line_mm = 2.0 * float(bristles.hair_mm) * bristles.count / n
        out = np.hypot(a, b).astype(np.float64)[:, None]
        turn = np.mod(np.arctan2(b, a) / (2.0 * np.pi), 1.0) * around
        column = np.minimum(turn.astype(np.int64), around - 1)[:, None]
        beside, aside = (column + 1) % around, turn[:, None] - column
        arcs = tuft.arcs / tuft.length
        shares = np.linspace(0.0, 1.0, _STATIONS) ** _CROWDED
        self.arc = 1.0 - lengths[:, None] * (1.0 - shares)  # (n, S), from the tip
        place = np.interp(self.arc, arcs, np.arange(len(arcs), dtype=np.float64))
        row = np.minimum(place.astype(np.int64), len(arcs) - 2)
        up = place - row
        rim = [(row + k, c) for k in (0, 1) for c in (column, beside)]
        corners = np.stack([r * around + c for r, c in rim], axis=-1)
        weights = np.stack([w * v for w in (1.0 - up, up) for v in (1.0 - aside, aside)], axis=-1)
        self._corners, self._weights = corners, (out[..., None] * weights).astype(np.float32)
        self._rows = np.stack([row, row + 1], axis=-1)
        self._shares = np.stack([1.0 - up, up], axis=-1).astype(np.float32)
        self._inner = (1.0 - out).astype(np.float32)[..., None]

    def points(self, rings: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return the points of the lines, and outward directions there.

        Parameters
        ----------
        rings : (R, around, 3)
            The tuft, the tip's ring first, mm.

        Returns
        -------
        points : (n, S, 3) float32
            From tip to root, mm.
        outward : (n, S, 3) float32
            From the middle of the tuft, of length 1 at most.
        """
        flat = rings.reshape(-1, 3).astype(np.float32)
        middles = rings.mean(axis=1).astype(np.float32)
        middle = np.einsum("nsk,nskc->nsc", self._shares, middles[self._rows])
        rim = np.einsum("nsk,nskc->nsc", self._weights, flat[self._corners])
        points = rim + self._inner * middle
        apart = points - middle
        length = np.sqrt(np.einsum("nsc,nsc->ns", apart, apart))[..., None]
        return points, (1.0 - self._inner) * apart / np.maximum(length, 1e-6)


# ---- Pictures of a brush -------------------------------------------------------------------------
# The footprints of a brush at several pressures, and a stroke painted by the engine itself.


Ink = str | Pigment

PRESSES = (0.15, 0.4, 0.7, 1.0)
"""Pressures at which footprints are drawn."""

_COLUMNS, _ROWS = 264, 84
_SHEET_LENGTHS = 4.4  # tuft lengths across the sheet
_SAMPLES = 90
_PRESS = np.array([0.0, 0.62, 0.40, 0.36, 0.50, 0.78, 0.68, 0.34, 0.08, 0.0])
_NO_TURN = np.array([1.0, 0.0, 0.0, 0.0])
_PAPER, _INK = np.array([250, 248, 243]), np.array([42, 40, 44])
_FINER = 4  # supersampling along each axis


def draw_stroke(
    brush: BrushSpec,
    ink: Ink | Mapping[Ink, float],
    material: str | Material = "xuan",
    columns: int = _COLUMNS,
) -> NDArray[np.uint8]:
    """Paint a stroke from left to right, pressed twice and lifted slowly: (H, W, 3) uint8.

    Cost: 0.1 s at 264 columns, and the brush's table the first time.

    Parameters
    ----------
    brush : BrushSpec
    ink : str, Pigment, or mapping of these to parts
    material : str or Material
        Of the sheet, which is 4.4 tuft lengths wide.
    columns : int
        W; H is 84 / 264 of it.

    Raises
    ------
    UnknownNameError, InputError
        For an ink or a material that is not known.
    """
    rows = round(columns * _ROWS / _COLUMNS)
    width = _SHEET_LENGTHS * brush.length_mm
    made_of = load_material(material) if isinstance(material, str) else material
    surface = PaintedSurface(_sheet(width, columns, rows), None, made_of)
    painter = Painter(surface, brush, ink, azimuth="dragged")
    painter.advance(_samples(brush, width))
    painter.finish()
    order = np.argsort(surface.paint_mesh.source_vertices[: rows * columns])
    return surface.srgb[order].reshape(rows, columns, 3)[::-1].copy()


def _sheet(width: float, columns: int, rows: int) -> TriangleMesh:
    step = width / (columns - 1)
    y, x = np.mgrid[:rows, :columns]
    centred = np.stack([x - (columns - 1) / 2, y - (rows - 1) / 2, np.zeros_like(x)], axis=-1)
    faces = grid_faces(rows, columns)
    return TriangleMesh((centred.reshape(-1, 3) * step).astype(np.float32), faces)


def _samples(brush: BrushSpec, width: float) -> list[DeviceSample]:
    t = np.linspace(0.0, 1.0, _SAMPLES)
    pressure = np.interp(t, np.linspace(0.0, 1.0, len(_PRESS)), _PRESS)
    pressure[[0, -1]] = 0.0
    x = width * (-0.40 + 0.80 * t)
    y = 0.055 * width * np.sin(1.9 * np.pi * t)
    samples = []
    for k in range(_SAMPLES):
        position = np.array([x[k], y[k], brush.length_mm])
        time_ns, press = 8_000_000 * (k + 1), float(pressure[k])
        samples.append(DeviceSample(time_ns, position, _NO_TURN, press, 0, np.zeros(3), _NO_TURN))
    return samples


def draw_footprints(
    brush: BrushSpec, columns: int = 240, presses: Sequence[float] = PRESSES
) -> NDArray[np.uint8]:
    """Draw the footprints of an upright brush, each over the larger ones: (W, W, 3) uint8.

    The tip is on the left. The picture is 1.3 tuft lengths wide, so that brushes of one length can
    be compared.

    Parameters
    ----------
    brush : BrushSpec
    columns : int
        W.
    presses : sequence of float
        Ascending pressures, 0 to 1.
    """
    tuft = build_tuft(brush)
    n = _FINER * columns
    half = 0.65 * brush.length_mm
    position = (np.arange(n) + 0.5) / n * 2.0 * half - half
    shade = np.zeros((n, n))
    deepest = greatest_descent(tuft, 0.5 * math.pi)
    for k, pe in reversed(list(enumerate(presses))):
        descent = min(pe * tuft.full_press, deepest)
        footprint = make_footprint(tuft, descent, 0.5 * math.pi, 0.0, pe)
        if footprint.is_empty:
            continue
        reach, width = footprint.reach[::-1], footprint.half_width[::-1]
        # The picture's middle is half way between the root's foot and the tip at full pressure.
        along = 0.25 * brush.length_mm - position
        across = np.interp(along, reach, width, left=-1.0, right=-1.0)
        shade[np.abs(position)[:, None] < across[None, :]] = 1.0 - 0.8 * k / len(presses)
    mean = shade.reshape(columns, _FINER, columns, _FINER).mean(axis=(1, 3))[..., None]
    return np.asarray(np.rint(_PAPER + mean * (_INK - _PAPER)), np.uint8)


def draw_brush(brush: BrushSpec, ink: Ink | Mapping[Ink, float], rows: int = 240) -> AnyArray:
    """Draw footprints on the left and a stroke on xuan on the right: (H, W, 3) uint8."""
    stroke = draw_stroke(brush, ink, columns=round(rows * _COLUMNS / _ROWS))[:rows]
    picture: AnyArray = np.concatenate([draw_footprints(brush, len(stroke)), stroke], axis=1)
    return picture
