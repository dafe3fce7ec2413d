"""One brush in other sizes: everything that is a length, an area or a volume goes along."""

from __future__ import annotations

import dataclasses

from paint3d.brush.spec import BrushSpec
from paint3d.core.arrays import as_number
from paint3d.errors import BrushError

__all__ = ["resized", "scaled", "size_limits", "stepped"]

_STEP = 2.0 ** (1.0 / 4.0)  # of one press of [ or ]
_LENGTHS = (5.0, 200.0)  # mm, of `BrushSpec`
_MOST_TRANSFER = 1.0


def size_limits(brush: BrushSpec) -> tuple[float, float]:
    """The least and the greatest length (mm) that a brush can be scaled to."""
    finest = brush.length_mm * (brush.transfer_per_mm / _MOST_TRANSFER) ** 0.5
    least = max(_LENGTHS[0], finest, brush.length_mm * (1.0 / brush.load) ** (1.0 / 3.0))
    return least, _LENGTHS[1]


def scaled(brush: BrushSpec, factor: float) -> BrushSpec:
    """A brush of the same shape and hair, so many times as large.

    Lengths grow with the factor, the ink that it holds with its cube, and what it leaves on an
    area stays the same: so the share given per mm falls with the square.

    Raises
    ------
    BrushError
        If the brush would be shorter than 5 mm or longer than 200 mm, or cannot hold ink.
    """
    factor = as_number(factor, "brush size (factor)", 1e-3, 1e3, BrushError)
    return resized(brush, factor * brush.length_mm)


def resized(brush: BrushSpec, length_mm: float) -> BrushSpec:
    """A brush of the same shape and hair, its tuft so long; see `scaled`.

    Raises
    ------
    BrushError
        See `scaled`.
    """
    length = as_number(length_mm, "brush length (mm)", *size_limits(brush), BrushError)
    length = round(length, 3)
    factor = length / brush.length_mm
    plain = brush.name.split(" @")[0]
    return dataclasses.replace(
        brush,
        name=f"{plain} @{length:g} mm",
        length_mm=length,
        root_diameter_mm=factor * brush.root_diameter_mm,
        tip_segment_mm=factor * brush.tip_segment_mm,
        point_mm=factor * brush.point_mm,
        full_press_mm=factor * brush.full_press_mm,
        load=factor**3 * brush.load,
        transfer_per_mm=brush.transfer_per_mm / factor**2,
    )


def stepped(brush: BrushSpec, steps: int) -> BrushSpec:
    """A brush some presses of ] (or, below 0, of [) larger, as far as it goes."""
    least, most = size_limits(brush)
    return resized(brush, min(max(brush.length_mm * _STEP**steps, least), most))
