"""How much water an ink needs to become lighter by even steps: a scale for sliders."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from paint3d.app.window.previews import Ink, ink_coat, sorted_parts
from paint3d.colour.difference import lab_from_srgb
from paint3d.colour.pigments import WATER

__all__ = ["MOST_WATER", "position_of", "water_at"]

MOST_WATER = 0.98
"""Of a mixture that is still called an ink."""
_STEPS = 33
_LEAST_RISE = 1.0  # of L*, below which water is not seen: white inks
_DIGITS = 3


def water_at(inks: Mapping[Ink, float], position: float) -> float:
    """The share of water with which a coat of an ink is so light.

    Parameters
    ----------
    inks : mapping
        Parts of inks, none of them water.
    position : float
        From 0, the ink alone, to 1, the ink with `MOST_WATER`: L* on xuan rises evenly with it.
    """
    positions, shares = _scale(sorted_parts(inks))
    return round(float(np.interp(position, positions, shares)), _DIGITS)


def position_of(inks: Mapping[Ink, float], water: float) -> float:
    """Where a share of water stands on the scale, 0 to 1; see `water_at`."""
    positions, shares = _scale(sorted_parts(inks))
    return float(np.interp(water, shares, positions))


@lru_cache(maxsize=64)
def _scale(
    inks: tuple[tuple[Ink, float], ...],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions (N,) from 0 to 1, and the shares of water (N,) that stand there."""
    shares = 1.0 - np.geomspace(1.0, 1.0 - MOST_WATER, _STEPS)
    total = sum(part for _, part in inks)
    ink: dict[Ink, float] = {one: part / total for one, part in inks}
    coats = [
        ink_coat({**{one: part * (1.0 - water) for one, part in ink.items()}, WATER: water})
        for water in shares
    ]
    light = np.maximum.accumulate(lab_from_srgb(np.array(coats) / 255.0)[:, 0])
    evenly = np.linspace(0.0, 1.0, _STEPS)
    rise = light[-1] - light[0]
    if rise < _LEAST_RISE:
        return evenly, shares
    # a little of the even steps, so that no two shares stand at one place
    return 0.98 * (light - light[0]) / rise + 0.02 * evenly, shares
