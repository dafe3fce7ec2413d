"""Tables of bent hairs over tilt and height: from the bending energy, and as measured.

Both hold, for 25 tilts from 30 to 90 degrees and 129 descents (even in the square root, 0 to 62 %
of the upright height), the points of a hair of length 1 at the fixed arc lengths `ARCS` from the
tip: x from the root's foot along the bend, z over the plane, and the angle to the plane.

*energy*: the least-energy shapes of the brush (`brush.bending`). *measured*: twelve shapes of a
real brush, published in the FastBrush thesis, as cubic Bezier curves from the root along the handle
to the tip along the paper; or the shapes of one's own brush, measured so. What FastBrush's program
got wrong is mended: between the measured handle angles (its own are 0 and 45 degrees) and between
the measured heights everything is interpolated, beyond the last angle its shapes hold; heights
count from where the straight hair first touches; the tip's offset counts from where the handle's
axis meets the paper, at every angle, so that nothing jumps as the handle leaves the upright; and a
curve longer or shorter than the hair is cut, or laid on along the paper, to the hair's own length.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import BendingTable
from paint3d.brush.bristle_spec import ShapeRows
from paint3d.brush_engine.bristles.bend import ARCS, SAMPLES
from paint3d.core.types import AnyArray

__all__ = ["MEASURED", "energy_shapes", "measured_shapes"]

MEASURED: ShapeRows = (
    (0.0, 1.00, 0.0, 0.0, 1.0, 0.0, 0.0),
    (0.0, 0.96, 0.12, 0.06, 0.98, 0.10, 0.0),
    (0.0, 0.83, 0.32, 0.10, 0.60, 0.42, 0.0),
    (0.0, 0.56, 0.62, 0.20, 0.41, 0.71, 10.0),
    (0.0, 0.42, 0.78, 0.26, 0.38, 0.68, 15.0),
    (0.0, 0.29, 0.93, 0.45, 0.30, 0.54, 22.0),
    (45.0, 1.00, 0.0, 0.0, 1.0, 0.0, 0.0),
    (45.0, 0.97, 0.03, 0.0, 1.0, 0.0, 0.0),
    (45.0, 0.85, 0.012, 0.01, 0.94, 0.0, 0.0),
    (45.0, 0.68, 0.26, 0.01, 0.80, 0.0, 0.0),
    (45.0, 0.54, 0.38, 0.01, 0.64, 0.0, 5.0),
    (45.0, 0.24, 0.52, 0.01, 0.26, 0.0, 15.0),
)
"""The shapes of FastBrush (KTH thesis), in rows of `bristle_spec.SHAPE_COLUMNS`."""

_FINE = 400  # points of a curve that is measured along


def energy_shapes(table: BendingTable) -> tuple[AnyArray, AnyArray]:
    """Shapes (T, D, 3 SAMPLES) float32 and fans (T, D, 2) float32 of a bending table.

    The fans are 0: how a tuft spreads is the brush's own law (Guo 2017, Eq. 2).
    """
    shapes = [_along(table.arcs, values) for values in table.spine]
    fans = np.zeros((*table.angles.shape[:2], 2), np.float32)
    return np.ascontiguousarray(np.concatenate(shapes, axis=-1), np.float32), fans


def _along(joints: AnyArray, values: AnyArray) -> AnyArray:
    """Values at joints (..., M + 1), linear between them, at `ARCS` (..., SAMPLES)."""
    place = np.clip(np.searchsorted(joints, ARCS, side="right") - 1, 0, len(joints) - 2)
    share = (ARCS - joints[place]) / np.diff(joints)[place]
    result: AnyArray = (1.0 - share) * values[..., place] + share * values[..., place + 1]
    return result


def measured_shapes(
    tilts: NDArray[np.float64], fractions: NDArray[np.float64], rows: ShapeRows = MEASURED
) -> tuple[AnyArray, AnyArray]:
    """Shapes (T, D, 3 SAMPLES) and fans (T, D, 2) float32 of a measured brush.

    Parameters
    ----------
    tilts : (T,) float64
        Handle to plane, rad.
    fractions : (D,) float64
        Descent over the straight hair's height.
    rows : tuple of tuples of float
        Measured shapes as `bristle_spec.shape_rows` has them. Between angles and between heights
        they are interpolated; beyond the first and the last, these hold.
    """
    shapes = np.empty((len(tilts), len(fractions), 3 * SAMPLES), np.float32)
    fans = np.empty((len(tilts), len(fractions), 2), np.float32)
    angles = sorted({row[0] for row in rows})
    for i, tilt in enumerate(tilts):
        angle = min(max(90.0 - math.degrees(tilt), angles[0]), angles[-1])
        after = next(a for a in angles if a >= angle)
        before = max(a for a in angles if a <= angle)
        lean = (angle - before) / (after - before) if after > before else 0.0
        for k, fraction in enumerate(fractions):
            upright, leaning = (_measured_at(rows, a, 1.0 - fraction) for a in (before, after))
            offset, imprint, upper, lower, fan = (1.0 - lean) * upright + lean * leaning
            height = math.sin(tilt) * (1.0 - fraction)
            shapes[i, k] = _bezier_hair(tilt, height, offset, upper, lower)
            fans[i, k] = math.radians(0.5 * fan), imprint
    return shapes, fans


def _measured_at(rows: ShapeRows, angle: float, height: float) -> AnyArray:
    known = np.array([row[1:] for row in rows if row[0] == angle])[::-1]
    return np.array([np.interp(height, known[:, 0], known[:, c]) for c in range(1, 6)])


def _bezier_hair(tilt: float, height: float, offset: float, upper: float, lower: float) -> AnyArray:
    """x, z and angle at `ARCS` of a hair of length 1 along the curve, never under the paper."""
    tip = height / math.tan(tilt) + offset
    corners = np.array(
        [
            [0.0, height],
            [upper * math.cos(tilt), height - upper * math.sin(tilt)],
            [tip - lower, 0.0],
            [tip, 0.0],
        ]
    )
    t = np.linspace(0.0, 1.0, _FINE)[:, None]
    weights = ((1.0 - t) ** 3, 3.0 * t * (1.0 - t) ** 2, 3.0 * t**2 * (1.0 - t), t**3)
    points = sum(w * corner for w, corner in zip(weights, corners, strict=True))
    points[:, 1] = np.maximum(points[:, 1], 0.0)
    laid_on = points[-1] + np.array([2.0, 0.0])  # what is left lies on the paper
    points = np.vstack([points, laid_on])
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    fine = np.linspace(0.0, 1.0, _FINE)  # from the root
    x, z = np.interp(fine, way, points[:, 0]), np.interp(fine, way, points[:, 1])
    angle = np.arctan2(-np.gradient(z, fine), np.gradient(x, fine))
    from_root = 1.0 - ARCS
    return np.concatenate([np.interp(from_root, fine, values) for values in (x, z, angle)])
