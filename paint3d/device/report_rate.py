"""Rate and regularity of a device's reports, from the times at which they were read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ReportRate", "find_report_rate", "lateness_ms"]

_PAUSE_NS = 100_000_000


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


def find_report_rate(times_ns: ArrayLike) -> ReportRate:
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
    steps = np.diff(numbers) % 65536
    count = np.concatenate([[0], np.cumsum(steps)]).astype(np.float64)
    if len(times) < 3 or count[-1] <= 0:
        return np.zeros(len(times))
    slope, start = np.polyfit(count, times - times[0], 1)
    residual = times - times[0] - (start + slope * count)
    result: NDArray[np.float64] = (residual - residual.min()) * 1e-6
    return result
