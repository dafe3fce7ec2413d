"""Plays a recording on the object as if a hand painted it, at any speed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from typing import Any

from PySide6 import QtCore

from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.device.sample import DeviceSample
from paint3d.painter.ink_time import PIECE_NS

__all__ = ["Player"]

_BATCH = 64  # samples handed on at once where no time is kept
_MOST_BATCHES = 16  # in one tick: the window lives on
_AHEAD = 64  # batches that wait: painting is not to wait for the next tick


@dataclass(eq=False)
class _Replay:
    """What is being played.

    Attributes
    ----------
    samples : sequence of DeviceSample
    speed : float or None
        How many times their own; None: as fast as it goes.
    began : Future
        Of the command that begins the stroke.
    later_ns : int
        From the samples' clock to the hand's.
    started : float
        By the clock of `time.perf_counter`.
    next : int
        The first that is still to be handed on.
    before : int
        How many samples had been painted when the first was.
    ended : Future or None
        Of the command that ends the stroke.
    refused : bool
        Whether something was told meanwhile that went wrong.
    """

    samples: Sequence[DeviceSample]
    speed: float | None
    began: Future[Any]
    later_ns: int
    started: float
    next: int = 0
    before: int = 0
    ended: Future[Any] | None = None
    refused: bool = False

    def count_from(self, n_painted: int) -> None:
        """Know how many samples had been painted when the stroke began."""
        self.before = n_painted

    def due(self, now: float) -> int:
        """Number of the first sample whose time has not come."""
        if self.speed is None:
            return len(self.samples)
        passed = (now - self.started) * self.speed * 1e9
        first, at = self.samples[0].time_ns, self.next
        while at < len(self.samples) and self.samples[at].time_ns - first <= passed:
            at += 1
        return at


class Player(QtCore.QObject):
    """For one window; `tick` hands on what is due.

    Signals
    -------
    moved : float
        The share that is painted, 0 to 1; below 0 where nothing is played any more.
    """

    moved = QtCore.Signal(float)

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._workspace = workspace
        self._replay: _Replay | None = None
        workspace.said.connect(self._hear)

    @property
    def is_playing(self) -> bool:
        """Whether there is something still to be painted."""
        return self._replay is not None

    def play(self, samples: Sequence[DeviceSample], speed: float | None) -> None:
        """Paint samples at so many times their own speed; None: as fast as it goes."""
        self.stop()
        if not samples:
            return
        # by the hand's clock, and by whole pieces of the ink's time: as it was painted
        since = time.perf_counter_ns() - samples[0].time_ns
        later_ns = since // PIECE_NS * PIECE_NS
        easel = self._workspace.easel
        began = easel.post("begin_stroke")
        started, painted = time.perf_counter(), easel.n_painted
        replay = _Replay(samples, speed, began, later_ns, started, before=painted)
        began.add_done_callback(lambda _: replay.count_from(easel.n_painted))
        self._replay = replay
        self._workspace.tell(say("Replaying; Esc stops it"))
        self.moved.emit(0.0)
        self.tick()

    def tick(self) -> None:
        """Hand on what is due by now, and see how much is painted."""
        replay, easel = self._replay, self._workspace.stage.easel
        if replay is None or easel is None:
            return
        if replay.began.done():
            if replay.began.cancelled() or replay.began.exception() is not None:
                self.stop()  # it is told why
                return
            self.moved.emit((easel.n_painted - replay.before) / len(replay.samples))
        if replay.ended is None:
            self._hand_on(replay)
        elif replay.ended.done():
            self._forget()
            if not replay.refused:
                self._workspace.tell(say("status.ready"))

    def _hand_on(self, replay: _Replay) -> None:
        easel, due = self._workspace.easel, replay.due(time.perf_counter())
        for _ in range(_MOST_BATCHES):
            if replay.next == due or easel.queue_length > _AHEAD:
                break
            samples = replay.samples[replay.next : min(replay.next + _BATCH, due)]
            moved = [replace(s, time_ns=s.time_ns + replay.later_ns) for s in samples]
            easel.feed(moved, all_time=True)
            replay.next += len(samples)
        if replay.next == len(replay.samples):
            replay.ended = easel.post("end_stroke")

    def stop(self) -> None:
        """Lift the brush where it is, if something is playing; what waits is not painted."""
        replay = self._replay
        if replay is not None:
            self._workspace.easel.leave_out_samples(replay.began, replay.ended)
            if replay.ended is None:
                self._workspace.easel.post("end_stroke")
            self._forget()

    def do_stop(self) -> None:
        """Stop because it is asked for, and say what that leaves."""
        if self.is_playing:
            self.stop()
            self._workspace.tell(say("The replay was stopped; undo takes back what it painted"))

    def take_back(self) -> None:
        """Stop because what was painted is about to be undone, and say so."""
        if self.is_playing:
            self.stop()
            self._workspace.tell(say("The replay was stopped and taken back"))

    def give_way(self) -> None:
        """Stop for a stroke by hand, which would be one with that of the recording."""
        if self._replay is not None and self._replay.ended is None:
            self.stop()
            self._workspace.tell(say("The replay was stopped by your stroke"))

    def _forget(self) -> None:
        self._replay = None
        self.moved.emit(-1.0)

    def _hear(self, _: str, state: str, __: bool) -> None:
        """Leave what went wrong on the status line."""
        if self._replay is not None and state == "bad":
            self._replay.refused = True
