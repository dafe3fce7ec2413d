"""Where on an object a sheet is put: by fractions of its size, or by a direction."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.arrays import as_array, as_number
from paint3d.errors import InputError, MeshError
from paint3d.mesh.chart import SurfaceFrame, frame_at
from paint3d.mesh.closest import ClosestPoints

__all__ = ["is_flat", "place"]

_FLAT = 0.35
"""An object lower than this share of its smaller width is written on from above."""


def is_flat(surface: ClosestPoints) -> bool:
    """Whether an object is painted from above (a plate) rather than from the side (a vase)."""
    low, high = surface.mesh.bounds
    width, depth, height = high - low
    return bool(height < _FLAT * min(width, depth))


def place(
    surface: ClosestPoints, at: ArrayLike | Sequence[float], up: ArrayLike | None = None
) -> SurfaceFrame:
    """A frame on the outside of an object.

    Parameters
    ----------
    surface : ClosestPoints
    at : (2,) or (3,) array_like
        Two fractions (u, v) in [0, 1]. On a flat object they run along x and y of its bounding
        box, seen from above. On others u is the turn about the vertical axis, counter-clockwise
        seen from above, with 0.5 at the front (-y), and v the height from bottom to top.
        Three numbers are a direction from the object's middle: the outermost point that way.
    up : (3,) array_like, optional
        What shall be upwards; by default +z, or +y where the surface is nearly horizontal.

    Raises
    ------
    InputError
        If `at` has another length or a fraction is outside [0, 1].
    MeshError
        If there is no surface at that place.
    """
    values = np.asarray(at, dtype=np.float64)
    if values.shape not in ((2,), (3,)):
        raise InputError(f"at has shape {values.shape}; expected u, v or a direction x, y, z")
    outside, inward = _ray(surface, as_array(values, "at", values.shape))
    hits = surface.cast(outside[None], inward[None])
    if not hits.hit[0]:
        raise MeshError(
            f"{surface.mesh.name}: there is no surface at {values.tolist()}; expected another place"
        )
    point = hits.points[0]
    if up is None:
        normal = surface.find(point[None]).normals[0]
        up = (0.0, 0.0, 1.0) if abs(normal[2]) < 0.9 else (0.0, 1.0, 0.0)
    return frame_at(surface, point, up)


def _ray(surface: ClosestPoints, at: NDArray) -> tuple[NDArray, NDArray]:
    """Start, outside the object, and unit direction of the ray that finds the place."""
    low, high = surface.mesh.bounds
    middle, far = 0.5 * (low + high), float(np.linalg.norm(high - low)) + 1.0
    if len(at) == 3:
        length = np.linalg.norm(at)
        if length == 0.0:
            raise InputError("at is the direction (0, 0, 0); expected a length above 0")
        return middle + far * at / length, -at / length
    u = as_number(float(at[0]), "u", 0.0, 1.0)
    v = as_number(float(at[1]), "v", 0.0, 1.0)
    if is_flat(surface):
        down = np.array([0.0, 0.0, -1.0])
        start = np.array([low[0] + u * (high[0] - low[0]), low[1] + v * (high[1] - low[1]), 0.0])
        start[2] = high[2] + far
        return start, down
    turn = 2.0 * math.pi * (u - 0.5) - 0.5 * math.pi
    outward = np.array([math.cos(turn), math.sin(turn), 0.0])
    level = np.array([middle[0], middle[1], low[2] + v * (high[2] - low[2])])
    return level + far * outward, -outward
