"""Strokes on paper while their ink spreads: how far painting falls behind a hand that goes on.

The painting thread's work is done here one piece after the other, by the rules of
`app.model.easel`: paint first, time in small pieces whenever nothing else waits. The clock that
the hand writes by is this thread's own CPU time, so other programs on the machine change nothing.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.easel import LONGEST_WET_S, PIECE_S, WET_STEP_S
from paint3d.bench.result import Check, Result
from paint3d.device.sample import DeviceSample

__all__ = ["measure"]

_RESOLUTION = 0.25
_STROKES = 20
_IN_A_ROW = 5
_STEP_MM, _LENGTH_MM = 34.0, 22.0
_RATE_HZ = 133.0
_STROKE_S, _REST_S = 0.8, 0.4
_MOST_BEHIND_S = 0.3
_UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass
class _Hand:
    """Writes by a clock of its own, and notes how late everything was done.

    Attributes
    ----------
    now, ink_s, owed : float
        Time since the beginning, time that passed for the ink, and what is still to, s.
    late, slices : list of float
        How long after it came each batch was done, and what each piece of time took, s.
    """

    document: Document
    now: float = 0.0
    ink_s: float = 0.0
    late: list[float] = field(default_factory=list)
    slices: list[float] = field(default_factory=list)
    owed: float = 0.0
    _keeps_up: bool = True
    _asked: deque[tuple[float, Callable[[], object]]] = field(default_factory=deque)

    def ask(self, at: float, work: Callable[[], object]) -> None:
        """Have something done that comes at a time, s; times rise."""
        self._asked.append((at, work))

    def go_on(self) -> None:
        """Do all that was asked for, and let time pass meanwhile."""
        while self._asked:
            at, work = self._asked[0]
            if at <= self.now:
                self._asked.popleft()
                self._spend(work)
                self.late.append(self.now - at)
            elif not self._keeps_up or self.owed >= WET_STEP_S:
                self._let_time_pass()
            else:
                self._wait(min(at - self.now, WET_STEP_S - self.owed + 1e-6))

    def _let_time_pass(self) -> None:
        seconds = min(self.owed, PIECE_S) if self._keeps_up else 0.0
        self.owed = self.owed - seconds if self._keeps_up else min(self.owed, PIECE_S)
        before = self.now
        self._keeps_up = self._spend(lambda: self.document.let_time_pass(seconds))
        self._spend(self.document.refresh)
        self.ink_s += seconds
        self.slices.append(self.now - before)

    def _spend(self, work: Callable[[], object]) -> object:
        before = time.process_time()
        found = work()
        self._wait(time.process_time() - before)
        return found

    def _wait(self, seconds: float) -> None:
        self.now += seconds
        self.owed = min(self.owed + seconds, LONGEST_WET_S)


def _stroke(k: int, start_s: float) -> list[DeviceSample]:
    """One of the strokes: five in a row, pressed and lifted."""
    n = round(_STROKE_S * _RATE_HZ)
    share = np.linspace(0.0, 1.0, n)
    x = -80.0 + _STEP_MM * (k % _IN_A_ROW) + _LENGTH_MM * share
    y = 70.0 - _STEP_MM * (k // _IN_A_ROW) - 5.0 * (k % 3) * share
    pressure = 0.5 * np.sin(np.pi * share) ** 0.5
    pressure[[0, -1]] = 0.0
    first = round(1e9 * (start_s + 1.0))
    return [
        DeviceSample(
            first + round(1e9 * i / _RATE_HZ), np.array([x[i], y[i], 35.0]), _UPRIGHT,
            float(pressure[i]), 0, np.zeros(3), _UPRIGHT,
        )
        for i in range(n)
    ]  # fmt: skip


def _warm() -> None:
    """Load what is compiled."""
    document = Document.new("plane", 4.0, "xuan")
    document.begin_stroke()
    document.feed(_stroke(0, 0.0))
    document.let_time_pass(0.1)
    document.end_stroke()


def measure(share: float = 1.0) -> Result:
    """How late 20 strokes at 0.25 mm are, how fast their ink's time goes, and undo.

    Parameters
    ----------
    share : float
        Of the 20 strokes.
    """
    _warm()
    document = Document.new("plane", _RESOLUTION, "xuan")
    hand = _Hand(document)
    rows, at = [], 0.0
    n = max(1, round(_STROKES * share))
    for k in range(n):
        began, ink, passed = hand.now, hand.ink_s + hand.owed, len(hand.late)
        pieces = len(hand.slices)
        hand.ask(at, document.begin_stroke)
        for i, sample in enumerate(_stroke(k, at)):
            hand.ask(at + i / _RATE_HZ, lambda sample=sample: document.feed([sample]))
        at += _STROKE_S
        hand.ask(at, document.end_stroke)
        at += _REST_S
        hand.ask(at, lambda: None)
        hand.go_on()
        rows.append(
            (
                k + 1, document.surface.flow.n_wet, 1e3 * max(hand.late[passed:]),
                1e3 * max(hand.slices[pieces:], default=0.0),
                (hand.ink_s + hand.owed - ink) / (hand.now - began),
            )
        )  # fmt: skip
    hand.ask(hand.now, document.undo)
    hand.go_on()
    undo = hand.late[-1]
    checks = [
        Check("furthest behind the hand", max(hand.late), _MOST_BEHIND_S, unit="s"),
        Check("undo", undo, _MOST_BEHIND_S, unit="s"),
    ]
    few = [row[4] for row in rows if row[1] <= 50_000]
    if few:
        checks.append(
            Check("ink's time over the clock's, up to 50,000 wet vertices", min(few), 0.99, False)
        )
    return Result(
        f"{n} wet strokes on xuan at {_RESOLUTION} mm, by this thread's CPU time",
        ("stroke", "wet vertices", "furthest behind, ms", "longest piece, ms", "ink's time/clock"),
        rows,
        checks,
    )
