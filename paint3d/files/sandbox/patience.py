"""How long a process is waited for: by what it does with its time, not by the clock.

On a busy machine a good file may take ten times as long as alone. What counts is the time that
the process computes, and the time in which it does not even want to: asleep, or blocked by a disk.
Waiting for a core counts as neither, nor does time in which nobody looked: whoever is stopped by
Ctrl+Z, or starved, was mostly not alone in it.
"""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path

__all__ = ["Watch"]

NANOSECOND = 1e-9
LONGEST_LOOK_S = 0.5  # of the clock, that one look accounts for


class Watch:
    """Watches a process from now on.

    Where the system does not tell how long processes wait for a core (others than Linux), all the
    time of the clock counts as idle.

    Parameters
    ----------
    process_id : int

    Attributes
    ----------
    computed : float
        Seconds of a core that it used, as far as was looked.
    idle : float
        Seconds of the clock in which none of its threads used or waited for a core; of the time
        since the last look no more than half a second.
    """

    def __init__(self, process_id: int) -> None:
        self._threads = Path(f"/proc/{process_id}/task")
        self._before: dict[str, tuple[float, float]] = {}
        self._looked = time.monotonic()
        self.computed = self.idle = 0.0

    def look(self) -> None:
        """Take account of the time since the last look."""
        now, times = time.monotonic(), self._times()
        wanting = 0.0
        for thread, (used, queued) in times.items():
            before = self._before.get(thread, (0.0, 0.0))
            self.computed += used - before[0]
            wanting = max(wanting, used - before[0] + queued - before[1])
        # a thread's waiting is told when it ends: the next look may take back what this one adds
        passed = min(now - self._looked, LONGEST_LOOK_S)
        self.idle = max(0.0, self.idle + passed - wanting)
        self._before, self._looked = times, now

    def _times(self) -> dict[str, tuple[float, float]]:
        """Seconds that each thread has used a core and waited for one."""
        times = {}
        with suppress(OSError):
            for thread in self._threads.iterdir():
                with suppress(OSError, ValueError):  # it may end meanwhile
                    words = (thread / "schedstat").read_text().split()
                    times[thread.name] = (NANOSECOND * int(words[0]), NANOSECOND * int(words[1]))
        return times
