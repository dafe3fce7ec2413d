"""Planning for a tuft that the paper turns: the inverse of the drag law, and the law itself.

The contact Q lies at the slack l(D_s) from the handle's foot H and moves towards H alone. A
footprint's centre lies between them, at its reach from H: if the centre shall follow a line, Q
follows the centre at the distance that is left, and H stands ahead of both. How the tuft really
turns is then asked of the law itself, and the footprints are fitted to that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.tuft import drag_along
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.kernels import planning as kernels
from paint3d.core.filters import gaussian_filter1d, maximum_filter1d, minimum_filter1d
from paint3d.core.types import AnyArray

__all__ = ["Pulled", "pull"]

_ROUNDS = 3  # of fitting footprints and pulling them along: the slack depends on the footprint
_SETTLING = 6.0  # slacks of way in which the light tip turns into the direction it is pulled
_SHORTEST = 0.15  # of the slack: how near the centre's line may lead the contact
_REVERSAL = 2.4  # rad of turn within the slack: the brush rises to its tip to turn over


class Pulled(NamedTuple):
    """A dragged course of N poses; see `StrokePath`."""

    handle: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    centre: NDArray[np.float64]
    level: NDArray[np.float64]


def pull(
    wanted: NDArray[np.float64],
    footprints: FootprintTable,
    target: kernels.Target,
    start: float,
) -> Pulled:
    """Lead the brush so that its footprints' centres follow a line.

    Parameters
    ----------
    wanted : (N, 2) float64
        The line, mm, at even steps.
    footprints : FootprintTable
    target : Target
        The outline, the table's footprints, and how far these may leave it.
    start : float
        Where the tuft points when it lands, rad.
    """
    light = _light_poses(wanted, float(footprints.slack[0]))
    level = np.zeros(len(wanted))
    for _ in range(_ROUNDS):
        reach, slack = footprints.centroid_at(level), footprints.slack_at(level)
        ahead = np.minimum(reach, (1.0 - _SHORTEST) * slack)
        bend = _follow(wanted, slack - ahead, start)
        handle = wanted - ahead[:, None] * bend
        azimuth = _turned(handle, slack, start)
        tuft = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
        centre = handle + reach[:, None] * tuft
        fitting = np.empty(len(wanted))
        kernels.fit_levels(target, centre, azimuth, fitting)
        level = _steady(np.where(light, np.minimum(fitting, 0.0), fitting))
    return Pulled(handle, azimuth, centre, level)


def _light_poses(wanted: AnyArray, slack: float) -> NDArray[np.bool_]:
    """Where only the tip touches: as the brush lands, and where the line turns back (N,)."""
    steps = np.diff(wanted, axis=0)
    length = np.linalg.norm(steps, axis=1)
    way = np.r_[0.0, np.cumsum(length)]
    light = way < _SETTLING * slack
    per_slack = max(1, round(_SETTLING * slack / max(float(length.mean()), 1e-12)))
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    heading = np.r_[heading, heading[-1]]
    size = 2 * per_slack + 1
    turn = maximum_filter1d(heading, size, mode="nearest")
    turn -= minimum_filter1d(heading, size, mode="nearest")
    result: NDArray[np.bool_] = light | (turn > _REVERSAL)
    return result


def _follow(line: AnyArray, slack: AnyArray, start: float) -> NDArray[np.float64]:
    """Directions (N, 2) of what is pulled along a line at a distance (N,)."""
    first = slack[0] * np.array([np.cos(start), np.sin(start)])
    pulled = np.empty_like(line)
    drag_along(line, slack, first[0], first[1], pulled)
    bend = pulled - line
    result: NDArray[np.float64] = bend / np.maximum(
        np.linalg.norm(bend, axis=1, keepdims=True), 1e-12
    )
    return result


def _turned(handle: AnyArray, slack: AnyArray, start: float) -> NDArray[np.float64]:
    """Azimuth (N,), rad, that the law gives under a track of the handle."""
    bend = _follow(handle, slack, start)
    return np.unwrap(np.arctan2(bend[:, 1], bend[:, 0]))


def _steady(level: AnyArray) -> NDArray[np.float64]:
    """Levels that rise and fall gently and stay on the paper; never above what fits."""
    most = np.maximum(level, 0.0)
    low = minimum_filter1d(most, 7, mode="nearest")
    result: NDArray[np.float64] = np.minimum(
        gaussian_filter1d(low, 1.5, truncate=2.0, mode="nearest"), most
    )
    return result
