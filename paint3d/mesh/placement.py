"""Where on an object a sheet is put: by fractions of its size, or by a direction."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import as_array, as_number
from paint3d.core.types import AnyArray
from paint3d.errors import InputError, MeshError
from paint3d.mesh.chart import SurfaceFrame, frame_at
from paint3d.mesh.closest_points import ClosestPoints

__all__ = ["SIDES", "is_flat", "place", "upwards"]

SIDES = ("outside", "inside", "top", "bottom")
"""From where a place on an object is looked at."""

_FLAT = 0.35
"""An object lower than this share of its smaller width is written on from above."""


def is_flat(surface: ClosestPoints) -> bool:
    """Whether an object is painted from above (a plate) rather than from the side (a vase)."""
    low, high = surface.mesh.bounds
    width, depth, height = high - low
    return bool(height < _FLAT * min(width, depth))


def upwards(normal: AnyArray) -> NDArray[np.float64]:
    """What is up on paper that lies along a normal (3,): +z, or +y where it nearly lies flat."""
    return np.array([0.0, 0.0, 1.0] if abs(normal[2]) < 0.9 else [0.0, 1.0, 0.0])


def place(
    surface: ClosestPoints,
    at: ArrayLike | Sequence[float],
    side: str | None = None,
) -> SurfaceFrame:
    """A frame on an object: up is +z, or +y where its surface is nearly horizontal.

    Parameters
    ----------
    surface : ClosestPoints
    at : (2,) or (3,) array_like
        Two fractions (u, v) in [0, 1]. Seen from the top or the bottom they run along x and y of
        the bounding box. Seen from the outside or the inside u is the turn about the vertical
        axis, counter-clockwise seen from above, with 0.5 at the front (-y), and v the height from
        bottom to top. Three numbers are a direction from the object's middle: the outermost point
        that way, or on the inside the first.
    side : {"outside", "inside", "top", "bottom"}, optional
        From where one looks; by default the top of a flat object and the outside of others.

    Raises
    ------
    InputError
        If `at` has another length, a fraction is outside [0, 1], or the side is not known.
    MeshError
        If there is no surface at that place, or it shows its back there.
    """
    if side is None:
        side = "top" if is_flat(surface) else "outside"
    if side not in SIDES:
        raise InputError(f"side is {side!r}; expected one of {', '.join(SIDES)}")
    values = np.asarray(at, dtype=np.float64)
    if values.shape not in ((2,), (3,)):
        raise InputError(f"at has shape {values.shape}; expected u, v or a direction x, y, z")
    start, ray = _ray(surface, as_array(values, "at", values.shape), side)
    hits = surface.cast(start[None], ray[None])
    where = f"at {values.tolist()} seen from the {side}"
    if not hits.hit[0]:
        raise MeshError(f"{surface.mesh.name}: there is no surface {where}; expected another place")
    point = hits.points[0]
    normal = surface.find(point[None]).normals[0]
    if normal @ ray >= 0.0:
        raise MeshError(f"{surface.mesh.name}: {where} the surface shows its back; try another")
    return frame_at(surface, point, upwards(normal))


def _ray(surface: ClosestPoints, at: AnyArray, side: str) -> tuple[AnyArray, AnyArray]:
    """Start and unit direction of the ray that finds the place, from outside or the axis."""
    low, high = surface.mesh.bounds
    middle, far = 0.5 * (low + high), float(np.linalg.norm(high - low)) + 1.0
    if len(at) == 3:
        length = np.linalg.norm(at)
        if length == 0.0:
            raise InputError("at is the direction (0, 0, 0); expected a length above 0")
        way = at / length
        return (middle, way) if side == "inside" else (middle + far * way, -way)
    u = as_number(float(at[0]), "u", 0.0, 1.0)
    v = as_number(float(at[1]), "v", 0.0, 1.0)
    if side in ("top", "bottom"):
        down = -1.0 if side == "top" else 1.0
        start = low + np.array([u, v, 0.5]) * (high - low)
        start[2] -= down * far
        return start, np.array([0.0, 0.0, down])
    turn = 2.0 * math.pi * (u - 0.5) - 0.5 * math.pi
    outward = np.array([math.cos(turn), math.sin(turn), 0.0])
    level = np.array([middle[0], middle[1], low[2] + v * (high[2] - low[2])])
    return (level, outward) if side == "inside" else (level + far * outward, -outward)
