"""Colours of vertices in the forms that text and tables have them, as sRGB codes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["COLOUR_NAMES", "colour_codes"]

COLOUR_NAMES = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
"""Of the columns in which a PLY has colours, the first that it has are taken."""

ROUNDING = 1e-6  # above 1
WHITE = 255


def colour_codes(values: AnyArray) -> tuple[NDArray[np.uint8] | None, tuple[str, ...]]:
    """Return sRGB colours (V, 3) of any type as codes, and what was done to them.

    Unsigned integers run over their whole range and floats from 0 to 1; where most floats are
    above that and all are whole numbers up to 255, they are taken as codes. Colours that are not
    finite become white; what is a little out of the range is brought to its end. None where most
    are out of it.

    Parameters
    ----------
    values : (V, 3) array
    """
    if values.dtype == np.uint8 or not values.size:
        return np.ascontiguousarray(values, np.uint8), ()
    if values.dtype.kind == "u":
        return _codes(values / float(np.iinfo(values.dtype).max)), ()
    values = values.astype(np.float64)
    known = np.asarray(np.isfinite(values).all(axis=1))
    if not known.any():
        return None, ("left out: its vertex colours, none of which is a number",)
    notes: tuple[str, ...] = ()
    if not known.all():
        notes += (
            f"{(~known).sum():,} of {len(known):,} vertex colours are no numbers: made white",
        )
    good = values[known]
    outside = ((good < 0.0) | (good > 1.0 + ROUNDING)).any(axis=1)
    if 2 * outside.sum() > len(good):
        if (good != np.floor(good)).any() or good.min() < 0 or good.max() > WHITE:
            return None, ("left out: its vertex colours, most of which are not within 0 to 1",)
        values = values / WHITE
        notes += ("its vertex colours are taken as 0 to 255",)
    elif outside.any():
        much = f"{outside.sum():,} of {len(known):,} vertex colours"
        notes += (f"{much} are not within 0 to 1: brought to the nearest that is",)
    return _codes(np.where(known[:, None], values, 1.0)), notes


def _codes(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.floor(WHITE * np.clip(values, 0.0, 1.0) + 0.5).astype(np.uint8)
