"""Timing on a machine that others use too.

The best of several rounds is the figure least disturbed by others; competitors take turns within
one run, so that a busy minute meets all of them; CPU time leaves out the time others had the core,
though not the caches they emptied.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Times", "alternate", "best_of", "load_average", "taken_share", "timed_once"]


_PROCESSOR_TIMES = Path("/proc/stat")
_STEAL = 7  # a column of a processor's


@dataclass(frozen=True)
class Times:
    """Seconds by the clock on the wall, and of this thread on a core."""

    wall_s: float
    cpu_s: float

    def best(self, other: Times) -> Times:
        """The smaller of each."""
        return Times(min(self.wall_s, other.wall_s), min(self.cpu_s, other.cpu_s))


def timed_once(function: Callable[[], object]) -> Times:
    """Call a function once."""
    wall, cpu = time.perf_counter(), time.thread_time()
    function()
    return Times(time.perf_counter() - wall, time.thread_time() - cpu)


def best_of(
    rounds: int, function: Callable[[], object], before: Callable[[], object] | None = None
) -> Times:
    """The best of some rounds; `before` runs ahead of each and is not timed."""
    found = Times(float("inf"), float("inf"))
    for _ in range(rounds):
        if before is not None:
            before()
        found = found.best(timed_once(function))
    return found


def alternate(rounds: int, competitors: Mapping[str, Callable[[], object]]) -> dict[str, Times]:
    """Run competitors by turns; the best of each."""
    found = dict.fromkeys(competitors, Times(float("inf"), float("inf")))
    for _ in range(rounds):
        for name, function in competitors.items():
            found[name] = found[name].best(timed_once(function))
    return found


def load_average() -> float | None:
    """Processes that wanted to run over the last minute, or None where that is not known."""
    try:
        return round(os.getloadavg()[0], 2)
    except (AttributeError, OSError):
        return None


def taken_share() -> Callable[[], float | None]:
    """Begin to watch how much of this machine's time its host gives to other machines.

    Returns
    -------
    callable
        Called later, tells the share since, in [0, 1]; None where it is not known (the column
        "steal" of `/proc/stat`, proc(5): Linux only, and only where the host tells).
    """
    before = _processor_ticks()

    def share() -> float | None:
        after = _processor_ticks()
        if before is None or after is None or sum(after) <= sum(before):
            return None
        return (after[_STEAL] - before[_STEAL]) / (sum(after) - sum(before))

    return share


def _processor_ticks() -> list[int] | None:
    """Time of all processors since the machine started, by kind."""
    try:
        ticks = _PROCESSOR_TIMES.read_text(encoding="ascii").split("\n", 1)[0].split()
        own = [int(word) for word in ticks[1 : _STEAL + 2]]  # what follows is in them already
    except (OSError, ValueError):
        return None
    return own if len(own) > _STEAL else None
