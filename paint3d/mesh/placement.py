"""Where on an object a sheet is put: by fractions of its size, or by a direction."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from threading import Lock

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError, MeshError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceFrame, frame_at

__all__ = ["SIDES", "SurfaceLine", "is_flat", "place", "upwards", "walk"]

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


# ---- Lines that keep their bearing ---------------------------------------------------------------
# Lines on a surface that keep their bearing: level ones, and those that climb or fall.
#
# Text runs along them: on a body the rows lie level and the columns hang straight, whatever the
# geodesics would do.


_STEPS_PER_SIZE = 150  # steps over the object's diagonal, at least
_LEAST_ADVANCE = 0.5
_LONGEST_SIZES = 8.0  # diagonals after which a line that neither ends nor closes is left


class SurfaceLine:
    """A line on a surface, walked as far as is asked of it; all of it, at most.

    Made by `walk`. Threads may ask the same line.
    """

    def __init__(self, begin: Callable[[], Iterator[tuple[AnyArray, float, bool]]]) -> None:
        self._begin, self._lock = begin, Lock()
        self._start_over()
        self.reaches(0.0)

    def _start_over(self) -> None:
        self._steps = self._begin()
        self._points: list[AnyArray] = []
        self._way: list[float] = []
        self._closed = False

    @property
    def points(self) -> NDArray[np.float64]:
        """All its points (M, 3), mm; the first is where the line started."""
        self.reaches(math.inf)
        return np.array(self._points)

    @property
    def closed(self) -> bool:
        """Whether the line comes back to its start; its length is then that of the ring."""
        self.reaches(math.inf)
        return self._closed

    @property
    def length(self) -> float:
        """How far the line goes, mm."""
        self.reaches(math.inf)
        return self._way[-1]

    def reaches(self, distance: float) -> bool:
        """Whether the line is so long, mm; no more of it is walked than tells."""
        with self._lock:
            while not self._way or self._way[-1] < distance:
                try:
                    step = next(self._steps, None)
                except BaseException:  # what was interrupted in a step cannot go on from there
                    self._start_over()
                    raise
                if step is None:
                    return False
                point, way, self._closed = step
                self._points.append(point)
                self._way.append(way)
        return True

    def at(self, distance: float) -> NDArray[np.float64]:
        """The point (3,) after so many mm; on a closed line any number goes.

        Raises
        ------
        InputError
            If an open line is shorter, or the distance is not finite.
        """
        if not (distance >= 0.0 and self.reaches(distance)):
            if not (self.closed and math.isfinite(distance)):
                raise InputError(
                    f"the line is {self.length:.1f} mm long; expected {distance:.1f} mm"
                )
            distance %= self.length
        j = max(0, bisect_left(self._way, distance) - 1)
        way, points = self._way[j : j + 2], np.array(self._points[j : j + 2])
        return np.array([np.interp(distance, way, points[:, k]) for k in range(3)])


def walk(
    surface: ClosestPoints,
    start: SurfaceFrame,
    up: ArrayLike,
    bearing: tuple[float, float],
    most_mm: float | None = None,
    step_mm: float = 1.0,
) -> SurfaceLine:
    """Follow a bearing until the surface ends, the line closes, or it is long enough.

    Parameters
    ----------
    surface : ClosestPoints
    start : SurfaceFrame
        From `frame_at` with the same `up`.
    up : (3,) array_like
        What is upwards everywhere.
    bearing : (float, float)
        Direction in the frame of every point: (1, 0) goes right along a level line, (0, 1) climbs.
    most_mm : float, optional
        Where to stop, or a step farther.
    step_mm : float
        Length of a step; at most a 150th of the object's diagonal is taken.

    Notes
    -----
    Two closest points a step, of about 30 us each.
    """
    upwards = as_array(up, "up", (3,))
    low, high = surface.mesh.bounds
    size = float(np.linalg.norm(high - low))
    step = min(step_mm, size / _STEPS_PER_SIZE)
    most = _LONGEST_SIZES * size if most_mm is None else most_mm
    return SurfaceLine(partial(_points_along, surface, start, upwards, bearing, most, step))


def _points_along(
    surface: ClosestPoints,
    start: SurfaceFrame,
    up: AnyArray,
    bearing: tuple[float, float],
    most: float,
    step: float,
) -> Iterator[tuple[AnyArray, float, bool]]:
    """Each point (3,), the way to it, mm, and whether it is the start again, the first as well."""
    frame, way = start, 0.0
    shortest, began = step / 30.0, start.origin
    yield began, way, False
    while way < most:
        following = _step(surface, frame, up, bearing, step)
        if following is None:
            step *= 0.5
            if step < shortest:
                return
            continue
        before, frame = frame.origin, following
        onward = way + float(np.linalg.norm(frame.origin - before))
        home = float(np.linalg.norm(frame.origin - began))
        if onward > 4.0 * step and home < 0.75 * step and frame.normal @ start.normal > 0.5:
            yield began, way + float(np.linalg.norm(before - began)), True
            return
        way = onward
        yield frame.origin, way, False


def _step(
    surface: ClosestPoints,
    frame: SurfaceFrame,
    up: AnyArray,
    bearing: tuple[float, float],
    step: float,
) -> SurfaceFrame | None:
    """The frame one step on by the midpoint rule, or None where surface or bearing end."""
    at = frame
    for share in (0.5, 1.0):
        heading = bearing[0] * at.x_axis + bearing[1] * at.y_axis
        try:
            at = frame_at(surface, frame.origin + share * step * heading, up)
        except InputError:  # up has come to lie along the normal: no bearing here
            return None
    onward = bearing[0] * at.x_axis + bearing[1] * at.y_axis
    advance = (at.origin - frame.origin) @ heading
    kept_on = advance >= _LEAST_ADVANCE * step and onward @ heading > 0.0
    return at if kept_on and at.normal @ frame.normal > 0.0 else None
