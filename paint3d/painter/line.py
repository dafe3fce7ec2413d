"""Recording of a line along a surface, as a hand would draw it."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number, dots_of
from paint3d.core.polyline import arc_lengths, interpolate
from paint3d.core.quaternion import quaternions_from_matrices
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.placement import place, upwards

__all__ = ["record_line"]

_RATE_HZ = 250.0
_STEP_MM = 0.5  # between two samples, at most
_FINE_STEPS = 16  # between two points given as U,V
_MOST_SAMPLES = 10_000_000
_MOST_TILT_DEG = 60.0


def record_line(
    surface: ClosestPoints,
    points: ArrayLike,
    pressure: ArrayLike = 0.5,
    tilt: ArrayLike = 0.0,
    *,
    length_mm: float,
    speed: float = 60.0,
    side: str | None = None,
    header: Mapping[str, object] | None = None,
) -> Recording:
    """Record a line that is drawn on a surface.

    Parameters
    ----------
    surface : ClosestPoints
    points : (N, 3) or (N, 2) array_like
        mm, moved to the closest points of the surface, or U,V as `place` takes them. Two points at
        least, joined by straight lines that lie on the surface.
    pressure, tilt : float or (M,) array_like
        Pressure, 0 to 1, and the handle's lean, degrees off the surface's normal in the direction
        of the line (below 0: against it), up to 60; several are spread evenly along the line and
        joined smoothly.
    length_mm : float
        Of the tuft: how far its root is from the surface.
    speed : float
        mm/s.
    side : str, optional
        Of U,V; see `place`.
    header : mapping, optional
        More entries for the recording's header.

    Raises
    ------
    InputError
        If there are fewer than two points apart from each other, or a number is out of range.
    MeshError
        If there is no surface at U,V.
    """
    corners = _corners(surface, points, side)
    speed = as_number(speed, "speed (mm/s)", 1e-3, 1e5)
    reach = arc_lengths(corners)
    apart = np.diff(reach, prepend=-1.0) > 0.0
    corners, reach = corners[apart], reach[apart]
    if len(corners) < 2:
        raise InputError(
            "{n} points that are apart; expected two for a line at least",
            n=len(corners),
        )
    n = 1 + math.ceil(reach[-1] / min(_STEP_MM, speed / _RATE_HZ))
    if n > _MOST_SAMPLES:
        raise InputError(
            "a line of {last:.0f} mm has {n:,} samples; expected fewer",
            last=reach[-1],
            n=n,
        )
    n = max(n, 4)
    along = np.linspace(0.0, reach[-1], n)
    nearest = surface.find(interpolate(along, reach, corners))
    feet, normals = nearest.points, nearest.normals
    lean = np.radians(_spread(tilt, "tilt (degrees)", n, -_MOST_TILT_DEG, _MOST_TILT_DEG))
    ahead = _directions(feet, normals)
    up = np.cos(lean)[:, None] * normals + np.sin(lean)[:, None] * ahead
    bend = -ahead + dots_of(ahead, up)[:, None] * up  # the tip trails behind
    bend /= np.linalg.norm(bend, axis=1)[:, None]
    frames = np.stack([bend, np.cross(up, bend), up], axis=-1)
    return Recording(
        np.round(1e9 * along / speed).astype(np.int64),
        feet + length_mm * up,
        quaternions_from_matrices(frames),
        _spread(pressure, "pressure", n, 0.0, 1.0),
        contact=feet,
        header={"object": surface.mesh.name, **(header or {})},
    )


def _corners(surface: ClosestPoints, points: ArrayLike, side: str | None) -> AnyArray:
    """Compute the line's corners (N, 3), mm."""
    try:
        given = np.asarray(points, np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.ndim == 2 and given.shape[1] == 3:
        return as_array(given, "points", (None, 3))
    if given.ndim != 2 or given.shape[1] != 2:
        raise InputError(
            "points have shape {given_shape}; expected (N, 3) in mm or (N, 2) of U,V",
            given_shape=given.shape,
        )
    uv = as_array(given, "points", (None, 2))
    at = np.linspace(0, len(uv) - 1, max(1, (len(uv) - 1) * _FINE_STEPS + 1))
    fine = interpolate(at, np.arange(len(uv)), uv)
    return np.array([place(surface, one, side).origin for one in fine])


def _spread(values: ArrayLike, what: str, n: int, least: float, most: float) -> NDArray[np.float64]:
    """Return values (n,) spread evenly along the line."""
    if np.ndim(values) == 0:
        return np.full(n, as_number(values, what, least, most))
    given = as_array(values, what, (None,))
    if not len(given) or given.min() < least or given.max() > most:
        got = f"{given.min():g} to {given.max():g}" if len(given) else "none"
        raise InputError(
            "{what} is {got}; expected {least:g} to {most:g}",
            what=what,
            got=got,
            least=least,
            most=most,
        )
    if len(given) == 1:
        return np.full(n, given[0])
    from scipy.interpolate import PchipInterpolator  # takes .2 s to import

    # monotone, without a kink: a value never leaves the range of its two neighbours
    smooth = PchipInterpolator(np.linspace(0.0, 1.0, len(given)), given)
    return np.asarray(smooth(np.linspace(0.0, 1.0, n)), np.float64).clip(least, most)


def _directions(feet: AnyArray, normals: AnyArray) -> AnyArray:
    """Compute unit directions (N, 3) of a path along a surface, in its tangent planes."""
    steps = np.gradient(feet, axis=0)
    steps -= dots_of(steps, normals)[:, None] * normals
    lengths = np.linalg.norm(steps, axis=1)
    still = lengths < 1e-9
    if still.all():
        return np.array([np.cross(upwards(normal), normal) for normal in normals])
    index = np.arange(len(steps))
    for axis in steps.T:  # where the path stands still it keeps its direction
        axis[still] = np.interp(index[still], index[~still], axis[~still])
    steps -= dots_of(steps, normals)[:, None] * normals
    unit: AnyArray = steps / np.linalg.norm(steps, axis=1)[:, None]
    return unit
