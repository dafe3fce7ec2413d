"""Decides when time steps of wet ink pass while a hand paints; `painter.ink_time` says which steps.

Samples carry the time at which they were made and arrive late, one frame at a time or many at
once. The steps before a sample follow from its timestamp, however late it arrives; the wall clock
takes over only when the hand has been silent for longer than it may be late. So the same samples
meet the same ink however they are delivered, and again when their recording is replayed.
"""

from __future__ import annotations

from paint3d.painter.ink_time import INK_STEP_NS, INK_STEP_S, ink_steps_until

__all__ = ["LATE_S", "InkClock"]

LATE_S = 0.25  # by which samples may arrive late
_OTHER_S = 1.0  # a jump back in time by more means that another clock counts
_NS = 1_000_000_000


class InkClock:
    """Counts the time steps that have passed for the ink.

    Parameters
    ----------
    now_ns : int
        Wall clock, which counts alone until the first sample.

    Attributes
    ----------
    left_out : int
        Steps that were skipped.
    """

    def __init__(self, now_ns: int) -> None:
        self.left_out = 0
        self._passed = ink_steps_until(now_ns)  # since the clock's zero
        self._sample_ns = self._arrived_ns = now_ns  # news
        self._knows_hand = False

    def advance_to(self, sample_ns: int, now_ns: int, most: int) -> int:
        """Advance the clock to a sample.

        Parameters
        ----------
        sample_ns : int
            When it was made, ns by the device's clock.
        now_ns : int
            When it arrived, ns by the wall clock.
        most : int
            Steps that may pass; more are skipped.

        Returns
        -------
        int
            Time steps that pass before it is painted; none before the first sample.
        """
        self._sample_ns, self._arrived_ns = sample_ns, now_ns
        ended = ink_steps_until(sample_ns)
        if not self._knows_hand or ended < self._passed - round(_OTHER_S / INK_STEP_S):
            self._passed, self._knows_hand = ended, True
        due = max(0, ended - self._passed)
        passed = min(due, most)
        self._passed += due
        self.left_out += due - passed
        return passed

    def wait(self, now_ns: int, most: int) -> bool:
        """Return whether one more step has passed by the wall clock since the last sample.

        Of steps that are due, `most` wait for later calls; the rest are skipped.
        """
        due = max(0, ink_steps_until(self._hand_ns(now_ns)) - self._passed)
        late = max(0, due - most)
        self._passed += late + (due > 0)
        self.left_out += late
        return due > 0

    def patience(self, now_ns: int) -> float:
        """Seconds until `wait` has another step, 0 to one step."""
        left = (self._passed + 1) * INK_STEP_NS - self._hand_ns(now_ns)
        return min(max(0.0, left / _NS), INK_STEP_S)

    def _hand_ns(self, now_ns: int) -> int:
        """Up to when all input of the hand is known, by its own clock."""
        return self._sample_ns + now_ns - self._arrived_ns - round(LATE_S * _NS)
