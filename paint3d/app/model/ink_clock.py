"""When the pieces of time pass for wet ink while a hand paints (`painter.ink_time` says which).

A hand's samples say when they were made, and come late: by a picture, or many at once. The pieces
that pass before a sample follow from its time, however late it comes; and only while nothing is
heard of the hand for longer than it may be late, the wall's clock goes on for it. The same samples
then find the same ink, handed over in whatever way, as they do when their recording is replayed.
"""

from __future__ import annotations

from paint3d.painter.ink_time import PIECE_NS, PIECE_S, pieces_until

__all__ = ["LATE_S", "InkClock"]

LATE_S = 0.25  # that what a hand did may be told later than the wall's clock says
_OTHER_S = 1.0  # that samples go back in time where another clock counts it
_NS = 1_000_000_000


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
        self._passed = pieces_until(now_ns)  # since the clock's zero
        self._heard = self._heard_at = now_ns  # news
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
        ended = pieces_until(sample_ns)
        if not self._knows_hand or ended < self._passed - round(_OTHER_S / PIECE_S):
            self._passed, self._knows_hand = ended, True
        due = max(0, ended - self._passed)
        passed = min(due, most)
        self._passed += due
        self.left_out += due - passed
        return passed

    def wait(self, now_ns: int, most: int) -> bool:
        """Whether one more piece has passed by the wall's clock since it heard of a sample.

        Of pieces that are due already no more than `most` are still to come; the rest is left out.
        """
        due = max(0, pieces_until(self._hand_ns(now_ns)) - self._passed)
        late = max(0, due - most)
        self._passed += late + (due > 0)
        self.left_out += late
        return due > 0

    def patience(self, now_ns: int) -> float:
        """How long it is until `wait` has another piece, s, 0 to one piece."""
        left = (self._passed + 1) * PIECE_NS - self._hand_ns(now_ns)
        return min(max(0.0, left / _NS), PIECE_S)

    def _hand_ns(self, now_ns: int) -> int:
        """Up to when all that the hand did is known, by its own clock."""
        return self._heard + now_ns - self._heard_at - round(LATE_S * _NS)
