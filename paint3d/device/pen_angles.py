"""How a pen leans: tilts along x and y, or altitude and azimuth, to its orientation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from paint3d.frames import quaternions_from_matrices

__all__ = ["orientation_from_tilt"]

_STEEPEST = math.radians(89.0)


def orientation_from_tilt(tilt_x: float, tilt_y: float, twist: float = 0.0) -> NDArray[np.float64]:
    """pad_from_pen (4,) of a pen that leans by these angles.

    The handle leans towards +x by `tilt_x` and towards +y by `tilt_y` (rad, seen along the other
    axis), so its direction is (tan tilt_x, tan tilt_y, 1), as in W3C Pointer Events. The tip
    bends away from the lean; an upright pen's tip bends along -x. `twist` turns the pen about its
    own axis, anticlockwise seen from above, and the bend with it.
    """
    lean_x = math.tan(min(max(tilt_x, -_STEEPEST), _STEEPEST))
    lean_y = math.tan(min(max(tilt_y, -_STEEPEST), _STEEPEST))
    up = np.array([lean_x, lean_y, 1.0])
    up /= np.linalg.norm(up)
    side = math.hypot(lean_x, lean_y)
    away = np.array([-lean_x, -lean_y, 0.0]) / side if side > 1e-9 else np.array([-1.0, 0.0, 0.0])
    bend = away - (away @ up) * up
    bend /= np.linalg.norm(bend)
    across = np.cross(up, bend)
    turned = math.cos(twist) * bend + math.sin(twist) * across
    frame = np.stack([turned, np.cross(up, turned), up], axis=1)
    return quaternions_from_matrices(frame[None])[0]
