"""Strokes on paper while their ink spreads: how far painting falls behind a hand that goes on.

The painting thread's work is done here in one thread, by the rules of `app.model.paint_thread`:
time steps of the ink are taken between the samples, and whenever nothing else waits. The hand's
clock is the CPU time of all this process's threads, so other programs on the machine change little,
and a second core does not help.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.ink_clock import InkClock
from paint3d.app.model.paint_thread import Pace
from paint3d.bench.result import Check, Result
from paint3d.device.sample import DeviceSample
from paint3d.painter.ink_time import INK_STEP_S

__all__ = ["measure"]

_RESOLUTION = 0.25
_STROKES = 20
_IN_A_ROW = 5
_STEP_MM, _LENGTH_MM = 34.0, 22.0
_RATE_HZ = 133.0
_STROKE_S, _REST_S = 0.8, 0.4
_MOST_BEHIND_S = 0.3
_ALONE, _ALONE_S = 3, 10.0  # strokes that are left alone: about 50,000 wet vertices; and how long
_UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])

_Found = TypeVar("_Found")


@dataclass
class _Hand:
    """Simulates a hand with a clock of its own; records how late everything was done.

    Attributes
    ----------
    now, lost_s : float
        Time since the beginning, and the part of it that did not pass for the ink, s.
    late, slices : list of float
        Delay of each batch, and duration of each time step of the ink, s.
    """

    document: Document
    now: float = 0.0
    slow_s: float = 0.0
    late: list[float] = field(default_factory=list)
    slices: list[float] = field(default_factory=list)
    _follows: bool = True
    _asked: deque[tuple[float, Callable[[], object] | DeviceSample]] = field(default_factory=deque)
    _clock: InkClock = field(default_factory=lambda: InkClock(0))
    _pace: Pace = field(default_factory=Pace)

    @property
    def lost_s(self) -> float:
        """Time that did not pass for the ink, s: left out, or behind what moved."""
        return INK_STEP_S * self._clock.left_out + self.slow_s

    def ask(self, at: float, work: Callable[[], object] | DeviceSample) -> None:
        """Queue work, or a sample to paint, for a time, s; times must rise."""
        self._asked.append((at, work))

    def go_on(self) -> None:
        """Do all that is queued, and let time pass meanwhile."""
        while self._asked:
            at, work = self._asked[0]
            if at <= self.now:
                self._asked.popleft()
                if isinstance(work, DeviceSample):
                    self._paint(at, work)
                else:
                    self._spend(work)
                self.late.append(self.now - at)
            elif self._clock.wait(round(1e9 * self.now), self._pace.most(0.0)):
                self._follow_time()
            else:
                self._spend(self.document.prepare_next_stroke)
                self.now += max(0.0, min(at - self.now, 0.2 * INK_STEP_S))

    def _paint(self, at: float, sample: DeviceSample) -> None:
        most = self._pace.most(self.now - at)
        for _ in range(self._clock.advance_to(sample.time_ns, round(1e9 * at), most)):
            self._follow_time()
        self._spend(lambda: self.document.feed([sample]))

    def _follow_time(self) -> None:
        before = self.now
        self.slow_s += 0.0 if self._follows else INK_STEP_S
        self._follows = self._spend(lambda: self.document.follow_time(INK_STEP_S))
        self._pace.took(self.now - before)
        self._spend(self.document.refresh)
        self.slices.append(self.now - before)

    def _spend(self, work: Callable[[], _Found]) -> _Found:
        before = time.process_time()
        result = work()
        self.now += time.process_time() - before
        return result


def _stroke(k: int, start_s: float) -> list[DeviceSample]:
    """Make stroke k of five in a row, pressed and lifted, from a time, s."""
    n = round(_STROKE_S * _RATE_HZ)
    t = np.linspace(0.0, 1.0, n)
    x = -80.0 + _STEP_MM * (k % _IN_A_ROW) + _LENGTH_MM * t
    y = 70.0 - _STEP_MM * (k // _IN_A_ROW) - 5.0 * (k % 3) * t
    pressure = 0.5 * np.sin(np.pi * t) ** 0.5
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
    """Load the compiled kernels."""
    document = Document.new("plane", 4.0, "xuan")
    document.begin_stroke()
    document.feed(_stroke(0, 0.0))
    document.let_time_pass(0.1)
    document.end_stroke()


def _leave_alone(scale: float) -> tuple[int, float]:
    """Count the wet vertices of strokes left alone; measure what a second of them takes, s."""
    document, seconds = Document.new("plane", _RESOLUTION, "xuan"), _ALONE_S * scale
    for k in range(max(1, round(_ALONE * scale))):
        document.begin_stroke()
        document.feed(_stroke(k, k * (_STROKE_S + _REST_S)))
        document.end_stroke()
    before = time.process_time()
    document.surface.diffuse(seconds)
    return document.surface.flow.n_wet, (time.process_time() - before) / seconds


def measure(scale: float = 1.0) -> Result:
    """Measure the lateness of 20 strokes at 0.25 mm, the pace of their ink's time, and undo.

    Parameters
    ----------
    scale : float
        Of the 20 strokes, and of those that are left alone, and how long.
    """
    _warm()
    document = Document.new("plane", _RESOLUTION, "xuan")
    hand = _Hand(document)
    rows, at = [], 0.0
    n = max(1, round(_STROKES * scale))
    for k in range(n):
        began, lost, passed = hand.now, hand.lost_s, len(hand.late)
        pieces = len(hand.slices)
        hand.ask(at, document.begin_stroke)
        for i, sample in enumerate(_stroke(k, at)):
            hand.ask(at + i / _RATE_HZ, sample)
        at += _STROKE_S
        hand.ask(at, document.end_stroke)
        at += _REST_S
        hand.ask(at, lambda: None)
        hand.go_on()
        rows.append(
            (
                k + 1, document.surface.flow.n_wet, 1e3 * max(hand.late[passed:]),
                1e3 * max(hand.slices[pieces:], default=0.0),
                1.0 - (hand.lost_s - lost) / (hand.now - began),
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
    wet, taken = _leave_alone(scale)
    checks.append(Check(f"a second of ink left alone, {wet:,} wet vertices", taken, 1.0, unit="s"))
    return Result(
        f"{n} wet strokes on xuan at {_RESOLUTION} mm, by this process's CPU time",
        ("stroke", "wet vertices", "furthest behind, ms", "longest piece, ms", "ink's time/clock"),
        rows,
        checks,
    )
