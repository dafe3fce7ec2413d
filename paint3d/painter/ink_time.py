"""The time that passes for ink that spreads while a hand paints: in equal pieces.

A piece ends whenever the hand's own clock has come to a multiple of its length, and passes before
the first sample that was made then or later. What a pen that was lifted has left is painted before;
where it goes on, the two samples that wait for others still wait. So what the ink meets follows
from the samples alone, and is the same while they are made, handed over late, and replayed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from paint3d.device.sample import DeviceSample
from paint3d.pose.brush_pose import joined_samples, object_poses

__all__ = ["LOOKAHEAD", "PIECE_NS", "PIECE_S", "Pauses", "is_lifted", "pieces_until"]

PIECE_S = 0.05
"""Of time that passes at once."""
PIECE_NS = 50_000_000
LOOKAHEAD = 2
"""Samples that must be known beyond an interval before it is painted."""


def pieces_until(time_ns: int) -> int:
    """How many pieces have ended at a time, counted from the clock's zero."""
    return time_ns // PIECE_NS


def is_lifted(samples: Sequence[DeviceSample]) -> bool:
    """Whether the pen was up between two of some samples that follow one another."""
    return not joined_samples(object_poses(samples))[1:].all()


class Pauses:
    """Where the painting of samples stops for the ink.

    Parameters
    ----------
    time_ns : (N,) int64
    joined : (N,) bool
        See `joined_samples`.
    first : int
        Before the samples up to this one all pieces have passed.

    Attributes
    ----------
    passed : int
        Before the samples up to this one they have by now.
    """

    def __init__(self, time_ns: NDArray[np.int64], joined: NDArray[np.bool_], first: int) -> None:
        due = np.diff(time_ns // PIECE_NS)
        self._before = np.flatnonzero(due) + 1
        self._before = self._before[self._before > first]
        came_down = np.maximum.accumulate(np.where(joined, 0, np.arange(len(joined))))
        self._stops = np.maximum(self._before - LOOKAHEAD, came_down[self._before]) - 1
        self._pieces = due[self._before - 1]
        self._next = 0
        self.passed = first

    def until(self, stop: int) -> Iterator[tuple[int, int]]:
        """Samples that are painted up to, none after `stop`, and the pieces that pass then."""
        last = int(np.searchsorted(self._stops, stop, side="right"))
        for k in range(self._next, last):
            self._next, self.passed = k + 1, int(self._before[k])
            yield int(self._stops[k]), int(self._pieces[k])
