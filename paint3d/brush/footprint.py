"""Footprint of a bent tuft on the plane of the paper (Guo 2017, Eqs. 6-9), at rest and in motion.

In motion it has effective points, zones and a technique (Guo 2015, section 3).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, round_tip, trace_outline
from paint3d.brush_engine.tuft import Tuft, greatest_descent
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import BrushError

__all__ = [
    "Footprint",
    "back_zone",
    "effective_points",
    "front_zone",
    "make_footprint",
    "stroke_width",
    "technique",
]


@dataclasses.dataclass(frozen=True, slots=True)
class Footprint:
    """Outline of the contact on the plane, symmetric about the bend direction.

    Parameters
    ----------
    reach : (N,) float64
        Signed distances from P'_m along the bend direction, mm, strictly falling from the tip to
        M_d; empty where nothing touches.
    half_width : (N,) float64
        Half the width there, mm; zero at both ends.
    azimuth : float
        alpha, rad, from the x axis of the plane to the bend direction P'_m P_0.

    Raises
    ------
    BrushError
        If the arrays do not describe such an outline.
    """

    reach: NDArray[np.float64]
    half_width: NDArray[np.float64]
    azimuth: float

    def __post_init__(self) -> None:
        reach = as_array(self.reach, "reach", (None,), error=BrushError).copy()
        half_width = as_array(self.half_width, "half_width", reach.shape, error=BrushError).copy()
        azimuth = as_number(self.azimuth, "azimuth", error=BrushError)
        if not (np.diff(reach) < 0.0).all():
            raise BrushError("reach does not fall strictly; expected the tip first")
        if (half_width < 0.0).any() or (reach.size and half_width[[0, -1]].any()):
            raise BrushError("half_width must not be negative, and must be 0 at both ends")
        reach.setflags(write=False)
        half_width.setflags(write=False)
        object.__setattr__(self, "reach", reach)
        object.__setattr__(self, "half_width", half_width)
        object.__setattr__(self, "azimuth", azimuth)

    @property
    def is_empty(self) -> bool:
        """True if nothing touches the plane."""
        return self.reach.size == 0

    @property
    def length(self) -> float:
        """From the tip to M_d, mm."""
        return 0.0 if self.is_empty else float(self.reach[0] - self.reach[-1])

    @property
    def width(self) -> float:
        """Across the bend direction at the widest, mm."""
        return 0.0 if self.is_empty else 2.0 * float(self.half_width.max())

    @property
    def area(self) -> float:
        """mm2, of the polygon."""
        return -2.0 * float(np.trapezoid(self.half_width, self.reach))

    def rounded(self) -> Footprint:
        """Return it with its tip as the ink's meniscus rounds it, which is what is painted."""
        reach, half_width = self.reach.copy(), self.half_width.copy()
        if reach.size:
            round_tip(reach, half_width, len(reach))
        return Footprint(reach, half_width, self.azimuth)

    def polygon(self) -> AnyArray:
        """Closed outline (K, 2), mm, about P'_m: tip, W side, M_d, W' side (Eqs. 7, 9).

        Runs clockwise and does not repeat its first point; K = 2 N - 2, or 0 where nothing touches.
        """
        if self.is_empty:
            return np.empty((0, 2))
        cosine, sine = math.cos(self.azimuth), math.sin(self.azimuth)
        along = np.concatenate([self.reach, self.reach[-2:0:-1]])
        across = np.concatenate([self.half_width, -self.half_width[-2:0:-1]])
        x = along * cosine + across * sine
        y = along * sine - across * cosine
        return np.stack([x, y], axis=1)


def make_footprint(
    tuft: Tuft, descent: float, tilt: float, azimuth: float = 0.0, pe: float | None = None
) -> Footprint:
    """Compute the footprint of a pressed tuft.

    Parameters
    ----------
    tuft : Tuft
        From `paint3d.brush.bending.build_tuft`.
    descent : float
        D_s, how far the root came down after the tip touched, mm; 0 to 62 % of LE sin(tilt).
    tilt : float
        theta between holder and plane, rad, pi/6 to pi/2.
    azimuth : float
        alpha of the bend direction, rad.
    pe : float, optional
        Pressure coefficient, 0 to 1; by default from the descent by Eq. 4.

    Returns
    -------
    footprint : Footprint
        Empty where the tip's sections do not reach the plane.

    Raises
    ------
    BrushError
        If a number is outside its range.

    Notes
    -----
    About 40 us, mostly checks; kernels call `trace_outline`, which takes about 1.2 us.
    """
    tilt = as_number(tilt, "tilt", tuft.lowest_tilt - 1e-12, 0.5 * math.pi + 1e-12, BrushError)
    deepest = greatest_descent(tuft, tilt)
    descent = as_number(descent, "descent", 0.0, deepest * (1.0 + 1e-12), BrushError)
    if pe is None:
        pe = min(tuft.spring * descent / tuft.max_force, 1.0)
    pe = as_number(pe, "pe", 0.0, 1.0, BrushError)
    reach, half_width = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    n = trace_outline(tuft, descent, tilt, pe, np.empty(SCRATCH_SIZE), reach, half_width)
    return Footprint(reach[:n], half_width[:n], azimuth)


# ---- In motion -----------------------------------------------------------------------------------

_ALIGNED = math.radians(15.0)  # tolerance of the pure techniques


def _tangent_indices(polygon: AnyArray, direction: AnyArray) -> tuple[int, int]:
    """Indices of the outermost points to the left and right of a direction of motion."""
    across = polygon @ np.array([-direction[1], direction[0]])
    return int(np.argmax(across)), int(np.argmin(across))


def effective_points(footprint: Footprint, direction: ArrayLike) -> tuple[AnyArray, AnyArray]:
    """Points where lines parallel to the motion touch the outline: A on the left, B on the right.

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
    """Outline points (K, 2) from the left to the right effective point, clockwise: the front."""
    polygon = _polygon(footprint)
    left, right = _tangent_indices(polygon, heading)
    count = (right - left) % len(polygon) + 1
    return polygon[(left + np.arange(count)) % len(polygon)]


def _unit(direction: ArrayLike) -> AnyArray:
    """Normalise a direction (2,); BrushError if it has no length."""
    vector = as_array(direction, "direction", (2,), error=BrushError)
    norm = math.hypot(vector[0], vector[1])
    if norm < 1e-12:
        raise BrushError("direction has no length; expected a direction of motion")
    return vector / norm
