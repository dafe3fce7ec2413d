"""Compression of two tables of a tuft's bent shapes: differences to a guess from its spine.

`Tuft.reach` and `Tuft.openness` follow from `Tuft.spine` up to rounding, by tangents of its angles.
The page guesses them by sums, products and quotients alone, which round alike everywhere, and
adds the difference: 70 kB a brush instead of 500 (`web/src/brush/shape_guess.ts`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from paint3d.brush.bending import LEAST_COSINE
from paint3d.core.arrays import AnyArray

__all__ = ["differences"]

_TERMS = 12  # of a sine or a cosine: to the last digit up to a right angle


def differences(tuft: Mapping[str, AnyArray], length_mm: float) -> dict[str, AnyArray]:
    """Compute the differences of `reach` and `openness` to their guesses, uint32 of their shapes.

    They count float32 numbers in the order of their bits; a difference n is stored as 2 n, or
    -2 n - 1 if it is negative.
    """
    along, up, angle = np.moveaxis(tuft["spine"].astype(np.float64), 2, 0)
    square = angle * angle
    cosine = np.maximum(_series(square, 0), LEAST_COSINE)
    reach = along - up * (angle * _series(square, 1)) / cosine
    chord = (2.0 * up / cosine).astype(np.float32)
    gap = chord[..., 1:] / (tuft["diameters"] / length_mm)[1:]
    gap = np.concatenate([gap[..., :1], gap], axis=-1)
    guesses = {"reach": reach, "openness": gap / (1.0 + gap)}
    return {name: _difference(tuft[name], guess) for name, guess in guesses.items()}


def _series(square: AnyArray, first: int) -> AnyArray:
    """Sum 1 - x^2 / (1 + first)(2 + first) + .., of a cosine (first 0) or a sine over x (1)."""
    result = np.ones_like(square)
    for k in range(_TERMS, 0, -1):
        result = 1.0 - result * (square / float((2 * k + first - 1) * (2 * k + first)))
    return result


def _difference(table: AnyArray, guess: AnyArray) -> NDArray[np.uint32]:
    bits = [np.ascontiguousarray(a, np.float32).view(np.int32).astype(np.int64)
            for a in (table, guess)]  # fmt: skip
    n = bits[0] - bits[1]
    return np.where(n < 0, -2 * n - 1, 2 * n).astype(np.uint32)
