"""Colours of vertices in the forms that text and tables have them, as sRGB codes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["COLOUR_NAMES", "colour_codes", "colour_shares"]

COLOUR_NAMES = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
"""Of the columns in which a PLY has colours, the first that it has are taken."""

ROUNDING = 1e-6  # above 1
BYTE, WORD, LONG = 255, 65_535, 4_294_967_295
OVERSHOOT = 2  # times the range: codes up to there are a bit too bright, not of the next range
BRIGHT = 16  # fractions up to here are too bright: as codes they would all be nearly black


def colour_codes(
    values: AnyArray, expected: int | None = None
) -> tuple[NDArray[np.uint8] | None, tuple[str, ...]]:
    """Return colours (V, 3) of any type as sRGB codes, and what was done to them.

    See `colour_shares`.
    """
    if values.dtype == np.uint8 or not values.size:
        return np.ascontiguousarray(values, np.uint8), ()
    shares, notes = colour_shares(values, expected)
    return None if shares is None else np.floor(BYTE * shares + 0.5).astype(np.uint8), notes


def colour_shares(
    values: AnyArray, expected: int | None = None
) -> tuple[NDArray[np.float64] | None, tuple[str, ...]]:
    """Return colours of any type from 0 to 1, and what was done to them.

    Whether the numbers run to 1, 255, 65,535 or 2^32 - 1 is told by the numbers themselves: many
    programs write codes of a byte as integers or floats of another size. A note says so where it
    is not the range that is expected. Colours that are not finite become white; what is a little
    out of the range is brought to its end.

    Parameters
    ----------
    values : (V, 3) array
    expected : int, optional
        Where the range ends by what the format says: by default at 1 for floats, at the largest
        number for integers.

    Returns
    -------
    (V, 3) float64, or None
        None where most colours are out of the range.
    tuple of str
    """
    is_integer = values.dtype.kind in "iu"
    if expected is None:
        expected = int(np.iinfo(values.dtype).max) if is_integer else 1
    if values.dtype == np.int8 and values.size and values.min() < 0:
        values = values.view(np.uint8)  # bytes whose type was given a wrong name
    values = values.astype(np.float64)
    if not values.size:
        return values, ()
    known = np.asarray(np.isfinite(values).all(axis=1))
    if not known.any():
        return None, ("left out: its vertex colours, none of which is a number",)
    notes: tuple[str, ...] = ()
    if not known.all():
        notes += (
            f"{(~known).sum():,} of {len(known):,} vertex colours are no numbers: made white",
        )
    good = values[known]
    end = _end_of_range(good, is_integer, expected)
    outside = ((good < 0.0) | (good > end + ROUNDING)).any(axis=1)
    if 2 * outside.sum() > len(good):
        what = f"most of which are not within 0 to {end:,}"
        return None, (f"left out: its vertex colours, {what}",)
    if end != expected and good.any():
        notes += (f"its vertex colours are taken as 0 to {end:,}",)
    if outside.any():
        much = f"{outside.sum():,} of {len(known):,} vertex colours"
        notes += (f"{much} are not within 0 to {end:,}: brought to the nearest that is",)
    return np.where(known[:, None], np.clip(values / end, 0.0, 1.0), 1.0), notes


def _end_of_range(good: NDArray[np.float64], is_integer: bool, expected: int) -> int:
    """Where the range of finite colours ends: at 1, 255, 65,535 or 2^32 - 1."""
    highest = good.max()
    if not is_integer:
        are_codes = highest > 1.0 + ROUNDING
        if (good != np.floor(good)).any():  # a few fractions above 1 are just too bright
            are_codes = highest > BRIGHT and np.median(good[good > 0.0]) > 1.0
        if not are_codes:
            return 1
    if highest <= OVERSHOOT * BYTE:
        return BYTE
    return WORD if highest <= OVERSHOOT * WORD or expected != LONG else LONG
