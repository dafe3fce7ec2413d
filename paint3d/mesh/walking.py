"""Lines on a surface that keep their bearing: level ones, and those that climb or fall.

Text runs along them: on a body the rows lie level and the columns hang straight, whatever the
geodesics would do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.errors import InputError
from paint3d.mesh.chart import SurfaceFrame, frame_at
from paint3d.mesh.closest_points import ClosestPoints

__all__ = ["SurfaceLine", "walk"]

_STEPS_PER_SIZE = 150  # steps over the object's diagonal, at least
_LEAST_ADVANCE = 0.5
_LONGEST_SIZES = 8.0  # diagonals after which a line that neither ends nor closes is left


@dataclass(frozen=True, eq=False)
class SurfaceLine:
    """A line on a surface as M points.

    Attributes
    ----------
    points : (M, 3) float64
        mm; the first is where the line started.
    way : (M,) float64
        Length up to each point, mm.
    closed : bool
        Whether the line came back to its start; `way[-1]` is then the length of the ring.
    """

    points: NDArray[np.float64]
    way: NDArray[np.float64]
    closed: bool

    @property
    def length(self) -> float:
        """How far the line goes, mm."""
        return float(self.way[-1])

    def at(self, distance: float) -> NDArray[np.float64]:
        """The point (3,) after so many mm; on a closed line any number goes.

        Raises
        ------
        InputError
            If an open line is shorter.
        """
        if self.closed:
            distance %= self.length
        if not 0.0 <= distance <= self.length:
            raise InputError(f"the line is {self.length:.1f} mm long; expected {distance:.1f} mm")
        return np.array([np.interp(distance, self.way, self.points[:, k]) for k in range(3)])


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
    low, high = surface.mesh.bounds
    size = float(np.linalg.norm(high - low))
    step = min(step_mm, size / _STEPS_PER_SIZE)
    most = _LONGEST_SIZES * size if most_mm is None else most_mm
    frame, points, way = start, [start.origin], [0.0]
    shortest = step / 30.0
    while way[-1] < most:
        following = _step(surface, frame, up, bearing, step)
        if following is None:
            step *= 0.5
            if step < shortest:
                break
            continue
        frame = following
        way.append(way[-1] + float(np.linalg.norm(frame.origin - points[-1])))
        points.append(frame.origin)
        home = float(np.linalg.norm(frame.origin - points[0]))
        if way[-1] > 4.0 * step and home < 0.75 * step and frame.normal @ start.normal > 0.5:
            points[-1], way[-1] = points[0], way[-2] + float(np.linalg.norm(points[-2] - points[0]))
            return SurfaceLine(np.array(points), np.array(way), True)
    return SurfaceLine(np.array(points), np.array(way), False)


def _step(
    surface: ClosestPoints,
    frame: SurfaceFrame,
    up: ArrayLike,
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
