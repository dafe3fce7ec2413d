"""A scale of water for sliders, on which an ink becomes lighter by even steps."""

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
"""Greatest fraction of water of a mixture that still counts as ink."""
_STEPS = 33
_LEAST_RISE = 1.0  # of L*, below which water is not seen: white inks
_DIGITS = 3


def water_at(inks: Mapping[Ink, float], position: float) -> float:
    """Return the fraction of water with which a coat of an ink is so light.

    Parameters
    ----------
    inks : mapping
        Parts of inks, none of them water.
    position : float
        From 0, the ink alone, to 1, the ink with `MOST_WATER`: L* on xuan rises evenly with it.
    """
    positions, fractions = _scale(sorted_parts(inks))
    return round(float(np.interp(position, positions, fractions)), _DIGITS)


def position_of(inks: Mapping[Ink, float], water: float) -> float:
    """Return the position of a fraction of water on the scale, 0 to 1; see `water_at`."""
    positions, fractions = _scale(sorted_parts(inks))
    return float(np.interp(water, fractions, positions))


@lru_cache(maxsize=64)
def _scale(
    inks: tuple[tuple[Ink, float], ...],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return positions (N,) from 0 to 1, and the fractions of water (N,) there."""
    fractions = 1.0 - np.geomspace(1.0, 1.0 - MOST_WATER, _STEPS)
    total = sum(part for _, part in inks)
    ink: dict[Ink, float] = {one: part / total for one, part in inks}
    coats = [
        ink_coat({**{one: part * (1.0 - water) for one, part in ink.items()}, WATER: water})
        for water in fractions
    ]
    light = np.maximum.accumulate(lab_from_srgb(np.array(coats) / 255.0)[:, 0])
    evenly = np.linspace(0.0, 1.0, _STEPS)
    rise = light[-1] - light[0]
    if rise < _LEAST_RISE:
        return evenly, fractions
    # a little of the even steps, so that no two fractions have one position
    return 0.98 * (light - light[0]) / rise + 0.02 * evenly, fractions
