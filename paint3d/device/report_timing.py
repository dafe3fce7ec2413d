"""Times of a device's reports: rate, regularity, and when each was measured.

A report is read some time after it was measured, when the reader was busy, or several at once, when
they queued up. If the device measures at a steady rate and numbers its reports, the time of
measurement can be recovered: report n was measured n periods after the first, and never after it
was read.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ReportClock", "ReportRate", "lateness_ms", "measure_report_rate", "stamp"]

# ---- Rate and regularity -------------------------------------------------------------------------

_PAUSE_NS = 100_000_000
_WRAP = 1 << 16  # of the numbers of reports


@dataclass(frozen=True, slots=True)
class ReportRate:
    """Rate and regularity of a stream of reports.

    Attributes
    ----------
    n : int
        Reports.
    rate_hz : float
        One over the mean interval, without pauses of 100 ms and more; 0 if there is no interval.
    interval_p50_ms, interval_p99_ms, longest_ms : float
        Of the intervals between pauses; NaN if there are none.
    pauses : int
    """

    n: int
    rate_hz: float
    interval_p50_ms: float
    interval_p99_ms: float
    longest_ms: float
    pauses: int


def measure_report_rate(times_ns: ArrayLike) -> ReportRate:
    """Measure the rate of reports read at these times (N,), ns."""
    times = np.asarray(times_ns, dtype=np.int64)
    gaps = np.diff(times)
    within = gaps[gaps < _PAUSE_NS] * 1e-6
    if len(within) == 0:
        return ReportRate(len(times), 0.0, np.nan, np.nan, np.nan, len(gaps))
    mean = float(within.mean())
    p50, p99 = (float(p) for p in np.percentile(within, (50, 99)))
    longest = float(within.max())
    return ReportRate(
        len(times), 1e3 / max(mean, 1e-6), p50, p99, longest, int(len(gaps) - len(within))
    )


def lateness_ms(times_ns: ArrayLike, sequence: ArrayLike) -> NDArray[np.float64]:
    """Estimate how much later than a steady rate each report was read, (N,) ms.

    Parameters
    ----------
    times_ns : (N,) array_like
    sequence : (N,) array_like
        The device's own report numbers, modulo 65536, counted at a steady rate.

    Notes
    -----
    The earliest report is taken as punctual: a delay common to all cannot be observed.
    """
    times = np.asarray(times_ns, dtype=np.float64)
    numbers: NDArray[np.int64] = np.asarray(sequence, dtype=np.int64)
    steps = np.diff(numbers) % _WRAP
    count = np.concatenate([[0], np.cumsum(steps)]).astype(np.float64)
    if len(times) < 3 or count[-1] <= 0:
        return np.zeros(len(times))
    slope, start = np.polyfit(count, times - times[0], 1)
    residual = times - times[0] - (start + slope * count)
    result: NDArray[np.float64] = (residual - residual.min()) * 1e-6
    return result


# ---- Times of measurement ------------------------------------------------------------------------

_RELOCK_NS = 50_000_000
_GAIN = 1.0 / 64.0


@dataclass(frozen=True, slots=True)
class ReportClock:
    """State of the estimate of a device's measurement times.

    Attributes
    ----------
    period_ns : float
        Between two measurements.
    last_ns : int
        Time assigned to the last report; 0 before the first.
    last_sequence : int
    lost : int
        Reports missing by their numbers.
    """

    period_ns: float
    last_ns: int = 0
    last_sequence: int = 0
    lost: int = 0


def stamp(clock: ReportClock, read_ns: int, sequence: int) -> tuple[int, ReportClock]:
    """Estimate when a report was measured; return the time and the updated clock.

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
        The time is later than the last one, if possible not later than `read_ns`, and follows the
        steady rate; after a break of 50 ms the clock locks anew.
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
