"""Planning for a tuft that the paper turns: the inverse of the drag law, and the law itself.

The contact Q lies at the slack l(D_s) from the handle's foot H and moves towards H alone. A
footprint's centre lies between them, at its reach from H: if the centre shall follow a line, Q
follows the centre at the distance that is left, and H stands ahead of both. How the tuft really
turns, and where the paper holds its tip, is then asked of the laws themselves, and the footprints
are fitted to that. Deeper footprints are turned and tilted otherwise, so this goes on in rounds, in
each of which the levels follow by a fraction only.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d

from paint3d.brush_engine.drag import drag_along, hold_along
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.kernels import planning as kernels
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import arc_lengths, headings_of, unit_vectors

__all__ = ["TRIALS", "DraggedPath", "Lead", "pull", "refine_pull"]

_ROUNDS = 3  # of fitting footprints and pulling them along: the slack depends on the footprint
_FOLLOWS = 0.7  # fraction of a change of levels that a round follows
_MADE_UP = 0.8  # fraction of what the paper holds a tip aside that the handle makes up for
_TRIES = ((1.0, 0.7), (0.5, 0.5), (1.0, 0.4))  # of `refine_pull`: made up for, and followed
TRIALS = len(_TRIES)
_SETTLING = 6.0  # slacks of way in which the light tip turns into the direction it is pulled
_EVENED = 2.0  # poses over which the handle makes up for a tip that is held aside
_SHORTEST = 0.15  # of the slack: how near the centre's line may lead the contact
_REVERSAL = 2.4  # rad of turn within the slack: the brush rises to its tip to turn over


class Lead(NamedTuple):
    """Line that a dragged brush is led along, and the brush.

    Attributes
    ----------
    wanted : (N, 2) float64
        The line that the footprints' centres shall follow, mm, at even steps.
    footprints : FootprintTable
    target : Target
        The outline, the table's footprints, and how far these may leave it.
    start : float
        Where the tuft points when it lands, rad.
    level : (N,) float64
        Rows of the table that would fit if the tuft were turned as one likes.
    """

    wanted: NDArray[np.float64]
    footprints: FootprintTable
    target: kernels.Target
    start: float
    level: NDArray[np.float64]


class DraggedPath(NamedTuple):
    """A dragged path of N poses as it lies by the laws; see `StrokePath`."""

    handle: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    centre: NDArray[np.float64]
    level: NDArray[np.float64]
    share: NDArray[np.float64]


def pull(lead: Lead) -> DraggedPath:
    """Lead the brush so that its footprints' centres follow a line."""
    light = _light_poses(lead.wanted, float(lead.footprints.slack[0]))
    level, aside = _smooth_levels(np.where(light, 0.0, lead.level)), np.zeros_like(lead.wanted)
    for _ in range(_ROUNDS):
        path, free = _lay_poses(_lead_handle(lead, level, aside), level, lead)
        aside = _MADE_UP * _tip_offsets(path, free)
        level = level + _FOLLOWS * (_fit_levels(path, light, lead) - level)
    return _lay_poses(path.handle, level, lead)[0]


def refine_pull(lead: Lead, path: DraggedPath, trial: int) -> Iterator[DraggedPath]:
    """Refine a path iteratively: the handle compensates for the tip's offset on the paper.

    None of them is the better for sure: see which covers most. There are three trials, from 0.
    """
    made_up, follows = _TRIES[trial]
    light = _light_poses(lead.wanted, float(lead.footprints.slack[0]))
    level = path.level
    path, free = _lay_poses(path.handle, level, lead)
    for _ in range(_ROUNDS):
        aside = made_up * _tip_offsets(path, free)
        path, free = _lay_poses(_lead_handle(lead, level, aside), level, lead)
        level = level + follows * (_fit_levels(path, light, lead) - level)
        yield _lay_poses(path.handle, level, lead)[0]


def _lead_handle(lead: Lead, level: AnyArray, aside: AnyArray) -> NDArray[np.float64]:
    """Positions of the handle (N, 2), mm, at which free footprints follow the line."""
    reach, slack = lead.footprints.centroid_at(level), lead.footprints.slack_at(level)
    ahead = np.minimum(reach, (1.0 - _SHORTEST) * slack)
    bend = _follow(lead.wanted, slack - ahead, lead.start)
    result: NDArray[np.float64] = lead.wanted - ahead[:, None] * bend - aside
    return result


def _tip_offsets(path: DraggedPath, free: AnyArray) -> NDArray[np.float64]:
    """Offsets (N, 2), mm, by which the paper holds footprints off where they would be free."""
    off, ahead = path.centre - free, free - path.handle
    along = (off * ahead).sum(axis=1) / np.maximum((ahead**2).sum(axis=1), 1e-18)
    off = off - along[:, None] * ahead
    aside: NDArray[np.float64] = gaussian_filter1d(off, _EVENED, axis=0, mode="nearest")
    return aside


def _fit_levels(path: DraggedPath, light: NDArray[np.bool_], lead: Lead) -> NDArray[np.float64]:
    """Levels (N,) that fit where a path lies."""
    fitting = np.empty(len(path.level))
    kernels.fit_levels(lead.target, path.centre, path.azimuth, path.share, fitting)
    return _smooth_levels(np.where(light, np.minimum(fitting, 0.0), fitting))


def _light_poses(wanted: AnyArray, slack: float) -> NDArray[np.bool_]:
    """Samples (N,) where only the tip touches: as the brush lands, and at reversals of the line."""
    steps = np.diff(wanted, axis=0)
    light = arc_lengths(wanted) < _SETTLING * slack
    step = float(np.linalg.norm(steps, axis=1).mean())
    per_slack = max(1, round(_SETTLING * slack / max(step, 1e-12)))
    heading = headings_of(steps)
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


def _lay_poses(
    handle: AnyArray, level: AnyArray, lead: Lead
) -> tuple[DraggedPath, NDArray[np.float64]]:
    """Poses of footprints by the laws, and their centres (N, 2), mm, if their tips were free."""
    footprints = lead.footprints
    bend = _follow(handle, footprints.slack_at(level), lead.start)
    bent = headings_of(bend)
    heel, length = footprints.heel_at(level), footprints.length_at(level)
    holding = np.empty_like(handle)
    hold_along(handle, bent, footprints.descent_at(level), heel, length, holding)
    azimuth, share = bent + holding[:, 0], 1.0 - holding[:, 1] / length
    middle, under = footprints.centroid_at(level) - heel, handle + heel[:, None] * bend
    centre = under + (middle * share)[:, None] * unit_vectors(azimuth)
    return DraggedPath(handle, azimuth, centre, level, share), under + middle[:, None] * bend


def _smooth_levels(level: AnyArray) -> NDArray[np.float64]:
    """Levels that rise and fall gently and stay on the paper; never above what fits."""
    most = np.maximum(level, 0.0)
    low = minimum_filter1d(most, 7, mode="nearest")
    result: NDArray[np.float64] = np.minimum(
        gaussian_filter1d(low, 1.5, truncate=2.0, mode="nearest"), most
    )
    return result
