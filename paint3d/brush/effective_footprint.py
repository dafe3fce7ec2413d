"""Effective points, zones and techniques of a footprint in motion (Guo 2015, section 3)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from paint3d.brush.footprint import Footprint
from paint3d.core.arrays import as_array
from paint3d.core.types import AnyArray
from paint3d.errors import BrushError

__all__ = ["back_zone", "effective_points", "front_zone", "stroke_width", "technique"]

_ALIGNED = math.radians(15.0)  # how far off the pure techniques their names still hold


def _tangent_indices(polygon: AnyArray, direction: AnyArray) -> tuple[int, int]:
    across = polygon @ np.array([-direction[1], direction[0]])
    return int(np.argmax(across)), int(np.argmin(across))


def effective_points(footprint: Footprint, direction: ArrayLike) -> tuple[AnyArray, AnyArray]:
    """Where the two lines parallel to the motion touch the outline: A on the left, B on the right.

    Parameters
    ----------
    footprint : Footprint
        Not empty.
    direction : (2,) array_like
        Of the motion on the plane, any length but 0.

    Returns
    -------
    a, b : (2,) float64
        mm, from P'_m.

    Raises
    ------
    BrushError
        If nothing touches, or the direction has no length.
    """
    polygon = _polygon(footprint)
    left, right = _tangent_indices(polygon, _unit(direction))
    return polygon[left], polygon[right]


def front_zone(footprint: Footprint, direction: ArrayLike) -> AnyArray:
    """The f zone: the outline (K, 2) ahead of the chord from B to A; raises as effective_points."""
    return _zone(footprint, _unit(direction))


def back_zone(footprint: Footprint, direction: ArrayLike) -> AnyArray:
    """The b zone: the outline (K, 2) behind the chord from A to B; raises as effective_points."""
    return _zone(footprint, -_unit(direction))


def stroke_width(footprint: Footprint, direction: ArrayLike) -> float:
    """Width of the stroke that the footprint paints, mm; raises as effective_points."""
    heading = _unit(direction)
    a, b = effective_points(footprint, heading)
    return float((a - b) @ np.array([-heading[1], heading[0]]))


def technique(footprint: Footprint, direction: ArrayLike) -> str:
    """Name of the technique: zhongfeng, cefeng or pianfeng, or "tip first" (Guo 2015, 3.1).

    It follows from the angle between the bend direction and the motion: 180 degrees is Zhongfeng
    (the tip trails in the middle of the stroke), 90 degrees is Pianfeng, between them lies Cefeng.
    Below 75 degrees the tip leads, which the paper does not name.

    Raises
    ------
    BrushError
        If the direction has no length.
    """
    heading = _unit(direction)
    bend = np.array([math.cos(footprint.azimuth), math.sin(footprint.azimuth)])
    angle = math.acos(min(max(float(heading @ bend), -1.0), 1.0))
    if angle >= math.pi - _ALIGNED:
        return "zhongfeng"
    if angle > 0.5 * math.pi + _ALIGNED:
        return "cefeng"
    return "pianfeng" if angle >= 0.5 * math.pi - _ALIGNED else "tip first"


def _polygon(footprint: Footprint) -> AnyArray:
    if footprint.is_empty:
        raise BrushError("the footprint is empty; expected a tuft that touches the plane")
    return footprint.polygon()


def _zone(footprint: Footprint, heading: AnyArray) -> AnyArray:
    """Outline points from left to right effective point, clockwise, that is around the front."""
    polygon = _polygon(footprint)
    left, right = _tangent_indices(polygon, heading)
    count = (right - left) % len(polygon) + 1
    return polygon[(left + np.arange(count)) % len(polygon)]


def _unit(direction: ArrayLike) -> AnyArray:
    """The direction (2,) with length 1; BrushError where it has none."""
    vector = as_array(direction, "direction", (2,), error=BrushError)
    norm = math.hypot(vector[0], vector[1])
    if norm < 1e-12:
        raise BrushError("direction has no length; expected a direction of motion")
    return vector / norm
