"""When a report was measured, from when it was read.

A report is read some time after it was measured: late when the reader was busy, and several at
once when they queued up. A device that measures at a steady rate and counts its reports lets us
undo that: the n-th report was measured n periods after the first, and never after it was read.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["ReportClock", "stamp"]

_RELOCK_NS = 50_000_000
_GAIN = 1.0 / 64.0
_WRAP = 1 << 16


@dataclass(frozen=True, slots=True)
class ReportClock:
    """What is known about a device's beat.

    Attributes
    ----------
    period_ns : float
        Between two measurements.
    last_ns : int
        Time given to the last report; 0 before the first.
    last_sequence : int
    lost : int
        Reports that never came, by their numbers.
    """

    period_ns: float
    last_ns: int = 0
    last_sequence: int = 0
    lost: int = 0


def stamp(clock: ReportClock, read_ns: int, sequence: int) -> tuple[int, ReportClock]:
    """The time at which a report was measured, and the clock after it.

    Parameters
    ----------
    clock : ReportClock
    read_ns : int
        When it was read; not earlier than the one before.
    sequence : int
        Its number, modulo 65536.

    Returns
    -------
    (int, ReportClock)
        The time is later than the last one, at most `read_ns` unless that were not later, and
        follows the steady beat; after a break of 50 ms the clock locks anew.
    """
    steps = (sequence - clock.last_sequence) % _WRAP
    expected = clock.last_ns + steps * clock.period_ns
    fresh = clock.last_ns == 0 or steps == 0 or steps > _WRAP // 2
    if fresh or read_ns - clock.last_ns > _RELOCK_NS + steps * clock.period_ns:
        at = max(read_ns, clock.last_ns + 1)
        return at, ReportClock(clock.period_ns, at, sequence, clock.lost)
    late = read_ns - expected
    at = round(expected + _GAIN * late if late > 0 else read_ns)
    at = max(at, clock.last_ns + 1)
    return at, ReportClock(clock.period_ns, at, sequence, clock.lost + steps - 1)
