"""The time of the hand in a recording, as it is shown again: without long rests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["LONGEST_REST_S", "HandTime"]

LONGEST_REST_S = 1.0
_BETWEEN_S = 0.3  # between two strokes whose clocks have nothing to do with each other


class HandTime:
    """Counts the time that a film or a playback takes at the hand's own speed.

    Between two samples as much time passes as between them did, but at most `LONGEST_REST_S`, since
    nothing is to be seen then; where ink spreads meanwhile, that counts in full.

    Parameters
    ----------
    in_full : bool
        Count every rest in full.

    Attributes
    ----------
    seconds : float
        Since the beginning.
    """

    def __init__(self, in_full: bool = False) -> None:
        self.seconds = 0.0
        self._in_full = in_full
        self._last_ns: int | None = None
        self._ink_s = 0.0

    def pass_samples(self, time_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Count some samples, (N,) ns, that follow those before; when each is, (N,) s."""
        if not len(time_ns):
            return np.zeros(0)
        gaps = np.diff(time_ns, prepend=time_ns[:1]) * 1e-9
        if self._last_ns is not None:
            since = (int(time_ns[0]) - self._last_ns) * 1e-9
            gaps[0] = max(0.0, (since if since >= 0.0 else _BETWEEN_S) - self._ink_s)
        if not self._in_full:
            gaps = np.minimum(gaps, LONGEST_REST_S)
        when = self.seconds + np.cumsum(gaps)
        self._last_ns, self._ink_s = int(time_ns[-1]), 0.0
        self.seconds = float(when[-1])
        return when

    def pass_ink(self, seconds: float) -> None:
        """Count time in which ink spreads and dries."""
        self._ink_s += seconds
        self.seconds += seconds
