"""The form of a brush: its tuft as the model bends it, its handle, and its outline on the surface.

Points are in the frame of the bend plane until they are placed: `along` from the root's foot to the
tip, `up` along the plane's normal, `side` across (`brush_engine.tuft`). The sections are the
papers' (Guo 2017, Eqs. 2, 3, 6): ellipses about the bent spine, wide across and thin in the bend
plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.contact import Contact
from paint3d.brush_engine.tuft import (
    OUTLINE_CAPACITY,
    SCRATCH_SIZE,
    STATIONS,
    Tuft,
    trace_outline,
    trace_spine,
)
from paint3d.core.arrays import cross
from paint3d.core.types import AnyArray
from paint3d.view.kernels.rings import ring_normals

__all__ = ["AROUND", "BrushStand", "grid_faces", "grid_normals", "handle_rings", "tuft_rings"]

AROUND = 44  # points around a section of the tuft, and of the handle
_HAIR_RELIEF = 0.05  # of the radius: how far hairs stand out of a section
_GATHERED = 0.5  # of the length from the root, over which the spread fades
_POINTED = 0.07  # of the length: the more, the finer the tip of a tuft that hangs free
_LIFT = 0.12  # mm that the lowest hairs are drawn above the surface, not to flicker with it
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
    """How a brush stands somewhere: touching the surface, above it, or far from it.

    Attributes
    ----------
    root : (3,) float64
        mm; where the tuft meets the ferrule.
    axes : (3, 3) float64
        Rows: along, side and up of the bend plane.
    origin : (3,) float64
        Where along and up are counted from, mm.
    descent, tilt, pressure : float
        mm, rad, 0 to 1.
    handle : (3,) float64
        Unit, up the handle.
    """

    root: NDArray[np.float64]
    axes: NDArray[np.float64]
    origin: NDArray[np.float64]
    descent: float
    tilt: float
    pressure: float
    handle: NDArray[np.float64]

    @classmethod
    def of(cls, tuft: Tuft, root: AnyArray, axes: AnyArray, contact: Contact | None) -> BrushStand:
        """Return how the brush of a pose stands.

        Parameters
        ----------
        tuft : Tuft
        root : (3,)
            The pose's position, mm.
        axes : (3, 3)
            Columns x, y, z of the pose: z is up the handle, x is the commanded bend.
        contact : Contact or None
            Of that pose.
        """
        x, y, z = np.asarray(axes, np.float64).T
        if contact is None or contact.area <= 0.0:
            frame = np.stack([x, -y, z])
            return cls(root, frame, root - tuft.length * z, 0.0, 0.5 * np.pi, 0.0, z)
        side = cross(contact.normal, contact.bend)
        frame = np.stack([contact.bend, side, contact.normal])
        tilt = contact.tilt
        height = tuft.length * np.sin(tilt) - contact.descent
        stand = contact.origin + height * contact.normal
        return cls(stand, frame, contact.origin, contact.descent, tilt, contact.pressure, z)

    @property
    def touches(self) -> bool:
        """Whether the tuft is bent by the surface."""
        return self.descent > 0.0

    def place(self, points: AnyArray) -> AnyArray:
        """Points (..., 3), along, side and up, in the object's frame (mm)."""
        return self.origin + points @ self.axes

    def outline(self, tuft: Tuft) -> AnyArray:
        """(N, 3) mm: the footprint's outline in the plane, all around; empty where none."""
        reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
        scratch = np.empty(SCRATCH_SIZE)
        n = trace_outline(tuft, self.descent, self.tilt, self.pressure, scratch, reach, half)
        sides = np.concatenate([half[:n], -half[:n][::-1]])
        along = np.concatenate([reach[:n], reach[:n][::-1]])
        return self.place(np.stack([along, sides, np.zeros(2 * n)], axis=1))


def tuft_rings(tuft: Tuft, stand: BrushStand) -> tuple[AnyArray, AnyArray]:
    """The surface of the tuft, hair by hair.

    Returns
    -------
    points : (R, AROUND, 3) float64
        mm, the tip's ring first; a ring on the surface is flattened by it.
    arc : (R,) float64
        How far up the tuft each ring is, 0 to 1.
    """
    arc = tuft.arcs
    if stand.touches:
        along, up, angle = spine = np.empty((3, STATIONS))
        trace_spine(tuft, stand.descent, stand.tilt, spine)
    else:
        along, up, angle = np.zeros_like(arc), arc, np.full_like(arc, 0.5 * np.pi)
    radius = 0.5 * tuft.diameters
    if not stand.touches:  # wet hairs that hang free draw together to a point
        share = arc / tuft.length
        radius = radius * (1.0 + _POINTED) * share / (share + _POINTED)
    # In the model all but the last segment spread alike; what does not touch is drawn gathered.
    fade = np.clip((1.0 - arc / tuft.length) / _GATHERED, 0.0, 1.0)
    fade = fade * fade * (3.0 - 2.0 * fade)
    spread = 1.0 + tuft.spread * stand.pressure * fade
    turn = 2.0 * np.pi * np.arange(AROUND) / AROUND
    relief = 1.0 + _HAIR_RELIEF * (_hair_noise() - 0.5) * np.sqrt(np.maximum(0.0, fade))[:, None]
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
    if stand.touches:
        points[..., 2] = np.maximum(points[..., 2], _LIFT)
    return stand.place(points), arc / tuft.length


@cache
def _hair_noise() -> AnyArray:
    """(AROUND,) in [0, 1]: which hairs stand out, always the same."""
    return np.random.default_rng(5).random(AROUND)


def handle_rings(tuft: Tuft, stand: BrushStand) -> tuple[AnyArray, AnyArray]:
    """The ferrule and the handle.

    Returns
    -------
    points : (R, AROUND, 3) float64, mm
    colours : (R, AROUND, 3) float64
        sRGB, 0 to 255.
    """
    profile = np.array(_HANDLE)
    length = min(max(tuft.length, 22.0), 46.0)  # a small brush's handle is no toy
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
    """(L, 3) int32: triangles between rings, which close around; always the same array."""
    ring = np.arange(columns)
    after = (ring + 1) % columns
    below = columns * np.arange(rows - 1)[:, None]
    a, b = below + ring, below + after
    c, d = a + columns, b + columns
    faces = np.stack([np.stack([a, b, d], axis=-1), np.stack([a, d, c], axis=-1)], axis=2)
    return faces.reshape(-1, 3).astype(np.int32)


def grid_normals(points: AnyArray) -> NDArray[np.float32]:
    """(R, AROUND, 3) float32: unit normals of rings of points, outward."""
    normals = np.empty(points.shape, np.float32)
    ring_normals(np.ascontiguousarray(points, np.float64), normals)
    return normals
