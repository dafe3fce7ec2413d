"""Plays a recording on the object as if a hand painted it, at any speed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.device.sample import DeviceSample
from paint3d.painter.ink_time import PIECE_NS

__all__ = ["Player"]

_BATCH = 64  # samples handed on at once where no time is kept


class Player:
    """For one window; `tick` hands on what is due."""

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self._samples: Sequence[DeviceSample] = ()
        self._next = 0
        self._speed: float | None = None
        self._began = 0.0
        self._later_ns = 0

    @property
    def is_playing(self) -> bool:
        """Whether there is more to come."""
        return self._next < len(self._samples)

    def play(self, samples: Sequence[DeviceSample], speed: float | None) -> None:
        """Paint samples at so many times their own speed; None: as fast as it goes."""
        self.stop()
        self._samples, self._next, self._speed = samples, 0, speed
        self._began = time.perf_counter()
        if samples:  # by the hand's clock, and by whole pieces of the ink's time: as it was painted
            since = time.perf_counter_ns() - samples[0].time_ns
            self._later_ns = since // PIECE_NS * PIECE_NS
            self._workspace.easel.post("begin_stroke")
            self._workspace.tell(say("status.replaying"))
            self.tick()

    def tick(self) -> None:
        """Hand on what is due by now."""
        if not self.is_playing:
            return
        due = self._due()
        for at in range(self._next, due, _BATCH):
            samples = self._samples[at : min(at + _BATCH, due)]
            moved = [replace(s, time_ns=s.time_ns + self._later_ns) for s in samples]
            self._workspace.easel.feed(moved)
        self._next = due
        if not self.is_playing:
            self._workspace.easel.post("end_stroke")
            self._workspace.tell(say("status.ready"))

    def stop(self) -> None:
        """Lift the brush where it is, if something is playing."""
        if self.is_playing:
            self._next = len(self._samples)
            self._workspace.easel.post("end_stroke")

    def give_way(self) -> None:
        """Stop for a stroke by hand, which would be one with that of the recording."""
        if self.is_playing:
            self.stop()
            self._workspace.tell(say("The replay was stopped by your stroke"))

    def _due(self) -> int:
        """Number of the first sample whose time has not come."""
        if self._speed is None:
            return len(self._samples)
        passed = (time.perf_counter() - self._began) * self._speed * 1e9
        first, at = self._samples[0].time_ns, self._next
        while at < len(self._samples) and self._samples[at].time_ns - first <= passed:
            at += 1
        return at
