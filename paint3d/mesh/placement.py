"""Positions on an object, by fractions of its size or a direction, and lines of one bearing."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from threading import Lock

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number, length_of
from paint3d.core.polyline import interpolate
from paint3d.errors import InputError, MeshError, Message
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceFrame, frame_at, frame_near
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "FACES",
    "SIDES",
    "SurfaceLine",
    "Upright",
    "is_flat",
    "place",
    "ring",
    "turns_of",
    "upwards",
    "walk",
]

SIDES = ("outside", "inside", "top", "bottom")
"""The sides from which a position on an object is seen."""

FACES = {"front": 0.0, "right": 0.25, "back": 0.5, "left": 0.75}
"""Parts of the outside, and the turns by which their middles lie right of the front's. Of a flat
object the front is its top and the back its bottom."""

_FLAT = 0.35
"""An object lower than this fraction of its smaller width is written on from above."""


def is_flat(surface: ClosestPoints) -> bool:
    """Return whether an object is painted from above (a plate), not from the side (a vase)."""
    low, high = surface.mesh.bounds
    width, depth, height = high - low
    return bool(height < _FLAT * min(width, depth))


def upwards(normal: AnyArray) -> NDArray[np.float64]:
    """Return the up direction of paper with a normal (3,): +z, or +y where it nearly lies flat."""
    return np.array([0.0, 0.0, 1.0] if abs(normal[2]) < 0.9 else [0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Upright:
    """Which way is up all over a surface, for what is written on it.

    Attributes
    ----------
    up : (3,) array_like
        The direction, any length but zero.
    apex : (3,) array_like, optional
        A point, mm, that is down from everywhere instead, as where the ribs of a fan meet.
    turn : float
        By which up is then turned to the left, seen from outside, radians.
    """

    up: AnyArray
    apex: AnyArray | None = None
    turn: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "up", as_array(self.up, "up", (3,)))
        if self.apex is not None:
            object.__setattr__(self, "apex", as_array(self.apex, "apex", (3,)))

    def frame(self, surface: ClosestPoints, point: ArrayLike) -> SurfaceFrame:
        """Return the frame at the closest point to `point` (3,), mm.

        Raises
        ------
        InputError
            If the surface lies level there.
        """
        return self.frame_near(surface, as_array(point, "point", (3,)))

    def frame_near(self, surface: ClosestPoints, point: NDArray[np.float64]) -> SurfaceFrame:
        """Return the same for a point that is known to be finite."""
        up = self.up if self.apex is None else point - self.apex
        frame = frame_near(surface, point, up)
        if self.turn == 0.0:
            return frame
        along, across = math.cos(self.turn), math.sin(self.turn)
        x_axis = along * frame.x_axis + across * frame.y_axis
        y_axis = along * frame.y_axis - across * frame.x_axis
        return SurfaceFrame(frame.origin, x_axis, y_axis, frame.normal)


def place(
    surface: ClosestPoints,
    at: ArrayLike | Sequence[float],
    side: str | None = None,
) -> SurfaceFrame:
    """Return a frame on an object: up is +z, or +y where its surface is nearly horizontal.

    Parameters
    ----------
    surface : ClosestPoints
    at : (2,) or (3,) array_like
        Two fractions (u, v) in [0, 1]. Seen from the top or the bottom they run along x and y of
        the bounding box. Seen from the outside or the inside u is the turn about the vertical
        axis of the body (see `body_axis`; a handle does not count), counter-clockwise seen from
        above, with 0.5 at the front (-y), and v the height from bottom to top. Three numbers are a
        direction from the middle of that axis, to the outermost point along it or, on the inside,
        the first; a side of the `FACES` takes none.
    side : {"outside", "inside", "top", "bottom", "front", "right", "back", "left"}, optional
        The side it is seen from; by default the top of a flat object and the outside of others.
        In the middle of one of the `FACES` u is 0.5.

    Raises
    ------
    InputError
        If `at` has another length, a fraction is outside [0, 1], the side is not known, or a face
        is given with a direction.
    MeshError
        If there is no surface at that place, or it shows its back there.
    """
    if side is None:
        side = "top" if is_flat(surface) else "outside"
    if side not in (*SIDES, *FACES):
        raise InputError(
            "side is {side!r}; expected one of {sides}",
            side=side,
            sides=", ".join((*SIDES, *FACES)),
        )
    asked, values = side, np.asarray(at, dtype=np.float64)
    asked_at = values.tolist()
    if side in FACES:
        if values.shape == (3,):
            raise InputError(
                "at is a direction and side is {side!r}; expected u, v on that face", side=side
            )
        if is_flat(surface):
            if side not in ("front", "back"):
                raise InputError(
                    "{object} lies flat; expected its front, which is its top, or its back",
                    object=surface.mesh.name,
                )
            side = "top" if side == "front" else "bottom"
        else:
            if values.shape == (2,) and 0.0 <= values[0] <= 1.0:
                values = np.array([(values[0] + FACES[side]) % 1.0, values[1]])
            side = "outside"
    if values.shape not in ((2,), (3,)):
        raise InputError(
            "at has shape {values_shape}; expected u, v or a direction x, y, z",
            values_shape=values.shape,
        )
    start, ray = _ray(surface, as_array(values, "at", values.shape), side)
    hits = surface.cast(start[None], ray[None])
    where = Message("at {place} seen from the {side}", place=asked_at, side=asked)
    if not hits.hit[0]:
        raise MeshError(
            "{object}: there is no surface {where}; expected another place",
            object=surface.mesh.name,
            where=where,
        )
    point = hits.points[0]
    normal = surface.find(point[None]).normals[0]
    if normal @ ray >= 0.0:
        raise MeshError(
            "{object}: {where} the surface faces away; expected another place",
            object=surface.mesh.name,
            where=where,
        )
    return frame_at(surface, point, upwards(normal))


def ring(surface: ClosestPoints, v: float, side: str, n: int = 180) -> NDArray[np.float64]:
    """Points (n, 3), mm, once around an object at a height, as `place` finds them.

    Parameters
    ----------
    surface : ClosestPoints
    v : float
        The height, 0 to 1.
    side : {"outside", "inside"}
    n : int
        From u = 0 on, evenly; NaN where there is no surface, or it shows its back.
    """
    rays = [_ray(surface, np.array([k / n, v]), side) for k in range(n)]
    start, way = (np.array(parts) for parts in zip(*rays, strict=True))
    hits = surface.cast(start, way)
    points = np.where(hits.hit[:, None], hits.points, np.nan)
    seen = np.flatnonzero(hits.hit)
    if len(seen):
        normals = surface.find(points[seen]).normals
        points[seen[(normals * way[seen]).sum(axis=1) >= 0.0]] = np.nan
    return points


def turns_of(mesh: TriangleMesh, points: AnyArray) -> NDArray[np.float64]:
    """The U (N,) of points (N, 3): the turns about the axis of the body, as `place` counts them."""
    x, y = (points[:, :2] - np.asarray(mesh.body_axis)).T
    turns: NDArray[np.float64] = (np.arctan2(y, x) / (2.0 * math.pi) + 0.75) % 1.0
    return turns


def _ray(surface: ClosestPoints, at: AnyArray, side: str) -> tuple[AnyArray, AnyArray]:
    """Return start and unit direction of the ray to a position, from outside or the axis."""
    low, high = surface.mesh.bounds
    far = float(np.linalg.norm(high - low)) + 1.0
    middle = np.array([*surface.mesh.body_axis, 0.5 * (low[2] + high[2])])
    if len(at) == 3:
        length = np.linalg.norm(at)
        if length == 0.0:
            raise InputError("at is the direction (0, 0, 0); expected a length above 0")
        direction = at / length
        if side == "inside":
            return middle, direction
        return middle + far * direction, -direction
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
# Text runs along such lines: rows lie level and columns hang straight, whatever the geodesics do.

_STEPS_PER_SIZE = 150  # steps over the object's diagonal, at least
_LEAST_ADVANCE = 0.5  # of a step: below, the surface has ended
_LONGEST_SIZES = 8.0  # diagonals: a line that neither ends nor closes is cut off there


class SurfaceLine:
    """A line on a surface, traced only as far as it is queried.

    Made by `walk`. Several threads may query one line.
    """

    def __init__(self, begin: Callable[[], Iterator[tuple[AnyArray, float, bool]]]) -> None:
        self._begin, self._lock = begin, Lock()
        self._restart()
        self.reaches(0.0)

    def _restart(self) -> None:
        self._steps = self._begin()
        self._points: list[AnyArray] = []
        self._arc_lengths: list[float] = []
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
        """Length of the line, mm."""
        self.reaches(math.inf)
        return self._arc_lengths[-1]

    def reaches(self, distance: float) -> bool:
        """Return whether the line is at least so long, mm; traces it no further than needed."""
        with self._lock:
            while not self._arc_lengths or self._arc_lengths[-1] < distance:
                try:
                    step = next(self._steps, None)
                except BaseException:  # an interrupted generator cannot go on
                    self._restart()
                    raise
                if step is None:
                    return False
                point, length, self._closed = step
                self._points.append(point)
                self._arc_lengths.append(length)
        return True

    def at(self, distance: float) -> NDArray[np.float64]:
        """Return the point (3,) after `distance` mm; a closed line repeats.

        Raises
        ------
        InputError
            If an open line is shorter, or the distance is not finite.
        """
        if not (distance >= 0.0 and self.reaches(distance)):
            if not (self.closed and math.isfinite(distance)):
                raise InputError(
                    "the line is {length:.1f} mm long; expected {distance:.1f} mm",
                    length=self.length,
                    distance=distance,
                )
            distance %= self.length
        j = max(0, bisect_left(self._arc_lengths, distance) - 1)
        ends, points = self._arc_lengths[j : j + 2], np.array(self._points[j : j + 2])
        return interpolate(distance, np.array(ends), points)


def walk(
    surface: ClosestPoints,
    start: SurfaceFrame,
    up: ArrayLike | Upright,
    bearing: tuple[float, float],
    most_mm: float | None = None,
    step_mm: float = 1.0,
) -> SurfaceLine:
    """Follow a bearing until the surface ends, the line closes, or it is long enough.

    Parameters
    ----------
    surface : ClosestPoints
    start : SurfaceFrame
        From `frame_at` with the same `up`, or from `Upright.frame`.
    up : (3,) array_like or Upright
        The up direction everywhere.
    bearing : (float, float)
        Direction in the frame of every point: (1, 0) goes right along a level line, (0, 1) climbs.
    most_mm : float, optional
        Length at which to stop, or a step farther.
    step_mm : float
        Length of a step; at most a 150th of the object's diagonal is taken.

    Notes
    -----
    Two closest points a step, of about 30 us each.
    """
    upright = up if isinstance(up, Upright) else Upright(as_array(up, "up", (3,)))
    low, high = surface.mesh.bounds
    size = float(np.linalg.norm(high - low))
    step = min(step_mm, size / _STEPS_PER_SIZE)
    most = _LONGEST_SIZES * size if most_mm is None else most_mm
    return SurfaceLine(partial(_points_along, surface, start, upright, bearing, most, step))


def _points_along(
    surface: ClosestPoints,
    start: SurfaceFrame,
    up: Upright,
    bearing: tuple[float, float],
    most: float,
    step: float,
) -> Iterator[tuple[AnyArray, float, bool]]:
    """Yield each point (3,), the first too, its arc length, mm, and whether the line has closed."""
    frame, length = start, 0.0
    shortest, began = step / 30.0, start.origin
    yield began, length, False
    while length < most:
        following = _step(surface, frame, up, bearing, step)
        if following is None:
            step *= 0.5
            if step < shortest:
                return
            continue
        before, frame = frame.origin, following
        onward = length + length_of(frame.origin - before)
        home = length_of(frame.origin - began)
        if onward > 4.0 * step and home < 0.75 * step and frame.normal @ start.normal > 0.5:
            yield began, length + float(np.linalg.norm(before - began)), True
            return
        length = onward
        yield frame.origin, length, False


def _step(
    surface: ClosestPoints,
    frame: SurfaceFrame,
    up: Upright,
    bearing: tuple[float, float],
    step: float,
) -> SurfaceFrame | None:
    """Return the frame one step on by the midpoint rule; None where surface or bearing end."""
    at = frame
    for fraction in (0.5, 1.0):
        heading = bearing[0] * at.x_axis + bearing[1] * at.y_axis
        try:
            at = up.frame_near(surface, frame.origin + fraction * step * heading)
        except InputError:  # up is along the normal: no bearing here
            return None
    onward = bearing[0] * at.x_axis + bearing[1] * at.y_axis
    advance = (at.origin - frame.origin) @ heading
    kept_on = advance >= _LEAST_ADVANCE * step and onward @ heading > 0.0
    return at if kept_on and at.normal @ frame.normal > 0.0 else None
