"""How a pen leans: tilts along x and y, or altitude and azimuth, to its orientation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["orientation_from_tilt"]

_STEEPEST = math.radians(89.0)


def orientation_from_tilt(tilt_x: float, tilt_y: float, twist: float = 0.0) -> NDArray[np.float64]:
    """pad_from_pen (4,) of a pen that leans by these angles.

    The handle leans towards +x by `tilt_x` and towards +y by `tilt_y` (rad, seen along the other
    axis), so its direction is (tan tilt_x, tan tilt_y, 1), as in W3C Pointer Events. The tip
    bends away from the lean; an upright pen's bends along -x. `twist` turns the pen about its
    own axis, anticlockwise seen from above, and the bend with it.
    """
    lean_x = math.tan(min(max(tilt_x, -_STEEPEST), _STEEPEST))
    lean_y = math.tan(min(max(tilt_y, -_STEEPEST), _STEEPEST))
    azimuth = math.atan2(lean_y, lean_x) if (lean_x, lean_y) != (0.0, 0.0) else 0.0
    half_lean = 0.5 * math.atan(math.hypot(lean_x, lean_y))
    # Rz(azimuth) Ry(lean) Rz(pi + twist), in half angles
    turn, sway = azimuth + math.pi + twist, azimuth - math.pi - twist
    return np.array(
        [
            math.cos(half_lean) * math.cos(0.5 * turn),
            -math.sin(half_lean) * math.sin(0.5 * sway),
            math.sin(half_lean) * math.cos(0.5 * sway),
            math.cos(half_lean) * math.sin(0.5 * turn),
        ]
    )
