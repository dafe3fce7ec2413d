"""The time that wet ink is given: the hand's own, in equal pieces.

A hand's samples say when they were made, and come late: by a picture, or many at once. Ink that ran
by the clock on the wall would meet the next stroke a little sooner or later on every machine. So a
piece of time passes before the first sample that was made after its end, however late that comes;
and only while nothing is heard of the hand for longer than it may be late, the wall's clock goes on
for it. The same samples then find the same ink, handed over in whatever way.
"""

from __future__ import annotations

__all__ = ["PIECE_S", "InkClock"]

PIECE_S = 0.05  # of time that passes at once
LATE_S = 0.25  # that what a hand did may be told later than the wall's clock says
LONGEST_S = 3.0  # that passes between two samples; more is left out
_OTHER_S = 1.0  # that samples go back in time where another clock counts it
_NS = 1_000_000_000
_PIECE_NS = round(PIECE_S * _NS)


class InkClock:
    """Counts the pieces of time that have passed for the ink.

    Parameters
    ----------
    now_ns : int
        By the wall's clock, which counts alone until the first sample is heard of.

    Attributes
    ----------
    left_out : int
        Pieces that were left out.
    """

    def __init__(self, now_ns: int) -> None:
        self.left_out = 0
        self._at = self._heard = self._heard_at = now_ns  # the end of the last piece; news
        self._knows_hand = False

    def hear(self, sample_ns: int, now_ns: int, most: int) -> int:
        """Hear of a sample.

        Parameters
        ----------
        sample_ns : int
            When it was made, ns by a clock of its own.
        now_ns : int
            When it came, ns by the wall's clock.
        most : int
            Pieces that may pass; what is more is left out.

        Returns
        -------
        int
            Pieces of time that pass before it is painted; none before the first.
        """
        self._heard, self._heard_at = sample_ns, now_ns
        if not self._knows_hand or sample_ns < self._at - _OTHER_S * _NS:
            self._at, self._knows_hand = sample_ns, True
        due = max(0, (sample_ns - self._at) // _PIECE_NS)
        passed = min(due, most, round(LONGEST_S / PIECE_S))
        self._at += due * _PIECE_NS
        self.left_out += due - passed
        return passed

    def wait(self, now_ns: int, most: int) -> bool:
        """Whether one more piece has passed by the wall's clock since it heard of a sample.

        Of pieces that are due already no more than `most` are still to come; the rest is left out.
        """
        due = max(0, self._since(now_ns) // _PIECE_NS)
        late = max(0, due - most)
        self._at += (late + (due > 0)) * _PIECE_NS
        self.left_out += late
        return due > 0

    def patience(self, now_ns: int) -> float:
        """How long it is until `wait` has another piece, s, 0 to one piece."""
        return min(max(0.0, 1e-9 * (_PIECE_NS - self._since(now_ns))), PIECE_S)

    def _since(self, now_ns: int) -> int:
        """How far the wall's clock is past the last piece, ns."""
        return self._heard + now_ns - self._heard_at - round(LATE_S * _NS) - self._at
