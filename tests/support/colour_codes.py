"""Error of 8-bit sRGB in comparisons of colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.core.arrays import AnyArray

__all__ = ["worth_of_one_code"]


def worth_of_one_code(codes: AnyArray) -> NDArray[np.float64]:
    """The greatest dE00 (N,) of codes (N, 3) uint8 to those that differ by one in one channel.

    It is .5 in a dark grey and up to 1.1 in the blackest inks.
    """
    lab, worth = lab_from_srgb(codes), np.zeros(len(codes))
    for channel in range(3):
        beside = codes.astype(int)
        beside[:, channel] += np.where(beside[:, channel] < 255, 1, -1)
        worth = np.maximum(worth, delta_e(lab, lab_from_srgb(beside.astype(np.uint8))))
    return worth
