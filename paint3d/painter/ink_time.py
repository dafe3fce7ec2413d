"""Fixed time steps of ink that spreads while the hand paints.

A step ends at every multiple of its length on the samples' clock, and is taken before the first
sample of that time or later. A stroke that ended before it is painted first, to its end; of one
that goes on, the last two samples still wait for their successors. So the state of the ink follows
from the samples alone: the same live, delivered late, or replayed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from paint3d.device.sample import DeviceSample
from paint3d.pose.brush_pose import joined_samples, object_poses

__all__ = ["INK_STEP_NS", "INK_STEP_S", "LOOKAHEAD", "Pauses", "ink_steps_until", "is_lifted"]

INK_STEP_S = 0.05
"""Length of a time step, s."""
INK_STEP_NS = 50_000_000
LOOKAHEAD = 2
"""Samples that must be known beyond an interval before it is painted."""


def ink_steps_until(time_ns: int) -> int:
    """Count the time steps that have ended at a time, from the clock's zero."""
    return time_ns // INK_STEP_NS


def is_lifted(samples: Sequence[DeviceSample]) -> bool:
    """Return whether the pen was up between any two consecutive samples."""
    return not joined_samples(object_poses(samples))[1:].all()


class Pauses:
    """The samples at which painting pauses for time steps of the ink.

    Parameters
    ----------
    time_ns : (N,) int64
    joined : (N,) bool
        See `joined_samples`.
    first : int
        All steps before the samples up to this one are taken already.

    Attributes
    ----------
    passed : int
        The same by now, as `until` goes on.
    """

    def __init__(self, time_ns: NDArray[np.int64], joined: NDArray[np.bool_], first: int) -> None:
        due = np.diff(time_ns // INK_STEP_NS)
        self._before = np.flatnonzero(due) + 1
        self._before = self._before[self._before > first]
        came_down = np.maximum.accumulate(np.where(joined, 0, np.arange(len(joined))))
        self._stops = np.maximum(self._before - LOOKAHEAD, came_down[self._before]) - 1
        self._steps = due[self._before - 1]
        self._next = 0
        self.passed = first

    def until(self, stop: int) -> Iterator[tuple[int, int]]:
        """Yield samples to paint up to, none after `stop`, and the number of steps to take then."""
        last = int(np.searchsorted(self._stops, stop, side="right"))
        for k in range(self._next, last):
            self._next, self.passed = k + 1, int(self._before[k])
            yield int(self._stops[k]), int(self._steps[k])
