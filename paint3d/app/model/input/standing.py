"""How a brush stands over the place that a pointer means: its lean, and where its root is."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from paint3d.brush.bending import build_tuft
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.tuft import (
    OUTLINE_CAPACITY,
    SCRATCH_SIZE,
    Tuft,
    greatest_descent,
    trace_outline,
)
from paint3d.core.arrays import AnyArray, as_array, as_number, length_of

__all__ = ["any_tangent", "held_over", "lean_of", "root_over", "turned_with"]

_MOST_LEAN = math.radians(60.0)
_STEEPEST_TILT = 85.0  # degrees that a tablet may say


def lean_of(
    normal: AnyArray,
    right: Sequence[float] | AnyArray | None,
    up: Sequence[float] | AnyArray | None,
    x_tilt: float,
    y_tilt: float,
) -> AnyArray:
    """Up the handle: the surface's normal, leaned over as the pen leans in the picture.

    Parameters
    ----------
    normal : (3,)
        Of the surface, unit.
    right, up : (3,) or None
        The picture's axes; None: the pen has no tilt.
    x_tilt, y_tilt : float
        Degrees that the pen leans to the right, and towards the user (down in the picture).

    Returns
    -------
    (3,) float64
        Unit, at most 60 degrees from the normal.
    """
    if right is None or up is None or not (x_tilt or y_tilt):
        return normal
    x, y = (math.tan(math.radians(_limited(t))) for t in (x_tilt, y_tilt))
    aside = x * as_array(right, "right", (3,)) - y * as_array(up, "up", (3,))
    aside = aside - (aside @ normal) * normal
    length = length_of(aside)
    if length < 1e-9:
        return normal
    angle = min(math.atan(length), _MOST_LEAN)
    return math.cos(angle) * normal + math.sin(angle) / length * aside


def held_over(lean: AnyArray, normal: AnyArray) -> AnyArray:
    """A handle's direction, where it is farther than 60 degrees from a normal turned towards it.

    Parameters
    ----------
    lean, normal : (3,)
        Unit.
    """
    along = float(lean @ normal)
    if along >= math.cos(_MOST_LEAN) - 1e-9:
        return lean
    aside = any_tangent(normal, lean)
    return math.cos(_MOST_LEAN) * normal + math.sin(_MOST_LEAN) * aside


def turned_with(before: AnyArray, after: AnyArray, vector: AnyArray) -> AnyArray:
    """A vector that is turned as one normal turns into another, the shortest way.

    Parameters
    ----------
    before, after : (3,)
        Unit; where they are opposite, the vector stays as it is.
    vector : (3,)
    """
    both = before + after
    share = 0.5 * float(both @ both)  # 1 + the cosine between them
    if share < 1e-9:
        return vector
    return vector - float(both @ vector) / share * both + 2.0 * float(before @ vector) * after


def root_over(
    brush: BrushSpec,
    place: AnyArray,
    normal: AnyArray,
    bend: AnyArray,
    handle: AnyArray,
    pressure: float,
) -> AnyArray:
    """Where the tuft's root is when the middle of its footprint lies at a place, on a plane there.

    Painting asks for the place and not for the root (`DeviceSample.contact`); the root is what a
    recording says besides, and a program that knows no places paints by it.

    Parameters
    ----------
    brush : BrushSpec
    place, normal : (3,)
        On the surface, mm, and the unit normal there.
    bend : (3,)
        Unit, along the surface, from the root's foot to the tip.
    handle : (3,)
        Unit, up the handle.
    pressure : float
        0 to 1; 0: the straight tuft's tip is at the place.

    Returns
    -------
    (3,) float64
        mm.
    """
    if pressure <= 0.0:
        return place + brush.length_mm * handle
    upright, ahead = float(handle @ normal), float(handle @ bend)
    tilt = math.acos(min(1.0, max(0.0, -ahead)))
    tuft = build_tuft(brush)
    descent = min(pressure * tuft.full_press, greatest_descent(tuft, max(tilt, tuft.lowest_tilt)))
    foot = place - _middle_reach(tuft, descent, tilt, pressure) * bend
    height = max(0.0, brush.length_mm * upright - descent)
    aside = handle - upright * normal - min(0.0, ahead) * bend  # what is no lean along the bend
    result: AnyArray = foot + height * normal + brush.length_mm * aside
    return result


def _middle_reach(tuft: Tuft, descent: float, tilt: float, pressure: float) -> float:
    """How far along the bend the middle of a footprint lies from the foot, mm; 0 for none."""
    reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    n = trace_outline(tuft, descent, tilt, pressure, np.empty(SCRATCH_SIZE), reach, half)
    return 0.5 * float(reach[0] + reach[n - 1]) if n else 0.0


def _limited(degrees: float) -> float:
    angle = as_number(degrees, "tilt (degrees)")
    return min(max(angle, -_STEEPEST_TILT), _STEEPEST_TILT)


def any_tangent(normal: AnyArray, wanted: AnyArray) -> AnyArray:
    """The unit vector across the normal that is nearest to the wanted one."""
    for candidate in (wanted, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])):
        across = candidate - (candidate @ normal) * normal
        length = length_of(across)
        if length > 1e-9 * max(1.0, length_of(candidate)):
            result: AnyArray = across / length
            return result
    return np.array([0.0, 0.0, 1.0])
