"""Timing on a shared machine.

The best of several rounds is the figure least disturbed by others; competitors take turns within
one run, so that a busy minute affects all of them; CPU time excludes the time that others had the
core, though not the caches they emptied.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Times", "alternate", "best_of", "load_average", "timed_once", "watch_steal"]


_PROC_STAT = Path("/proc/stat")
_STEAL = 7  # column of a processor's times


@dataclass(frozen=True)
class Times:
    """Wall time, and CPU time of this thread, s."""

    wall_s: float
    cpu_s: float

    def best(self, other: Times) -> Times:
        """The smaller of each."""
        return Times(min(self.wall_s, other.wall_s), min(self.cpu_s, other.cpu_s))


def timed_once(function: Callable[[], object]) -> Times:
    """Time one call of a function."""
    wall, cpu = time.perf_counter(), time.thread_time()
    function()
    return Times(time.perf_counter() - wall, time.thread_time() - cpu)


def best_of(
    rounds: int, function: Callable[[], object], before: Callable[[], object] | None = None
) -> Times:
    """Return the best of some rounds; `before` runs before each and is not timed."""
    best = Times(float("inf"), float("inf"))
    for _ in range(rounds):
        if before is not None:
            before()
        best = best.best(timed_once(function))
    return best


def alternate(rounds: int, competitors: Mapping[str, Callable[[], object]]) -> dict[str, Times]:
    """Run competitors by turns; return the best times of each."""
    best = dict.fromkeys(competitors, Times(float("inf"), float("inf")))
    for _ in range(rounds):
        for name, function in competitors.items():
            best[name] = best[name].best(timed_once(function))
    return best


def load_average() -> float | None:
    """Return the mean number of runnable processes of the last minute; None if unknown."""
    try:
        return round(os.getloadavg()[0], 2)
    except (AttributeError, OSError):
        return None


def watch_steal(file: Path = _PROC_STAT) -> Callable[[], float | None]:
    """Begin to measure the fraction of this machine's time that its host gives to other machines.

    Parameters
    ----------
    file : Path
        As `/proc/stat`, proc(5).

    Returns
    -------
    callable
        Returns the fraction since, 0 to 1; None if unknown (Linux only, and only if the host
        reports it).
    """
    before = _processor_ticks(file)

    def fraction() -> float | None:
        after = _processor_ticks(file)
        if before is None or after is None or sum(after) <= sum(before):
            return None
        return (after[_STEAL] - before[_STEAL]) / (sum(after) - sum(before))

    return fraction


def _processor_ticks(file: Path) -> list[int] | None:
    """Read the time of all processors since the machine started, by kind; None if unknown."""
    try:
        ticks = file.read_text(encoding="ascii").split("\n", 1)[0].split()
        kinds = [int(word) for word in ticks[1 : _STEAL + 2]]  # guests' are in these already
    except (OSError, ValueError):
        return None
    return kinds if len(kinds) > _STEAL else None
