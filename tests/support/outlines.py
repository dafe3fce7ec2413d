"""Outlines of pressed tufts, plainly: for laws that hold of the model's footprint."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, trace_outline
from paint3d.brush_engine.tuft import Tuft

UPRIGHT = 0.5 * math.pi


def outline_of(
    tuft: Tuft, descent: float, tilt: float = UPRIGHT, pe: float | None = None
) -> tuple[NDArray, NDArray]:
    """Reach and half width (mm) of the outline, tip first."""
    reach, half_width = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    pe = min(1.0, descent / tuft.full_press) if pe is None else pe
    n = trace_outline(tuft, descent, tilt, pe, np.empty(SCRATCH_SIZE), reach, half_width)
    return reach[:n], half_width[:n]


def sizes_of(tuft: Tuft, descents: NDArray, tilt: float = UPRIGHT) -> NDArray:
    """Area (mm2), width and length (mm) of the outline at every descent, (N, 3)."""
    sizes = []
    for descent in descents:
        reach, half = outline_of(tuft, float(descent), tilt)
        touches = len(reach) > 0
        area = -2.0 * np.trapezoid(half, reach)
        sizes.append((area, 2.0 * half.max(initial=0.0), np.ptp(reach) if touches else 0.0))
    return np.array(sizes)


def lift_off(tuft: Tuft, begins: float = 0.3, length_mm: float = 20.0) -> tuple[NDArray, NDArray]:
    """Places (mm) and half widths (mm) of a straight stroke that is lifted, the tip trailing.

    From place 0 on the press falls evenly from a share of the full one to nothing.
    """
    positions = np.arange(-2.0 * tuft.length, length_mm + 2.0, 0.02)
    widths = np.zeros_like(positions)
    reach, half = outline_of(tuft, begins * tuft.full_press)
    before = positions <= 0.0 - reach[half.argmax()]
    widths[before] = half.max()
    for fraction in np.linspace(0.0, 1.0, 2000):
        reach, half = outline_of(tuft, begins * tuft.full_press * (1.0 - fraction))
        if len(reach):
            passed = np.interp(positions, length_mm * fraction - reach, half, left=0.0, right=0.0)
            np.maximum(widths, passed, out=widths)
    return positions, widths
