"""Painting with the colours brought up to date 30 times a second of the stroke's own time.

`play` takes the stroke as a recording; `play_live` takes it as a device gives it, sample by sample
and frame by frame, which costs some Python more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from paint3d.bench.stopwatch import Times, timed_once
from paint3d.device.sample import DeviceSample
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording

__all__ = ["FRAME_HZ", "LiveTimes", "frames_of", "play", "play_live"]

FRAME_HZ = 30.0


@dataclass(frozen=True)
class LiveTimes:
    """Cost of a stroke, and how much of it the colours of a recording took (wall, s)."""

    whole: Times
    colour_s: float

    def best(self, other: LiveTimes) -> LiveTimes:
        """The smaller of each."""
        return LiveTimes(self.whole.best(other.whole), min(self.colour_s, other.colour_s))


def frames_of(recording: Recording) -> list[list[DeviceSample]]:
    """The samples as a live device gives them, frame by frame of the stroke's own time."""
    seconds = (recording.time_ns - recording.time_ns[0]) * 1e-9
    frame = np.floor(seconds * FRAME_HZ).astype(np.int64)
    frames: list[list[DeviceSample]] = [[] for _ in range(int(frame[-1]) + 1)]
    for at, sample in zip(frame, recording.samples(), strict=True):
        frames[at].append(sample)
    return frames


def play(painter: Painter, recording: Recording) -> LiveTimes:
    """Paint a recording, colours included; the brush is dipped before."""
    return _timed(painter, lambda: painter.replay(recording, frame_rate=FRAME_HZ))


def play_live(painter: Painter, frames: list[list[DeviceSample]]) -> LiveTimes:
    """Paint frames of samples as fast as it goes, colours included."""

    def paint() -> None:
        for samples in frames:
            painter.advance(samples)
            painter.surface.refresh()
        painter.finish()
        painter.surface.refresh()

    return _timed(painter, paint)


def _timed(painter: Painter, paint: Callable[[], None]) -> LiveTimes:
    painter.dip()
    painter.surface.refresh()
    colour_before = painter.seconds["colour"]
    whole = timed_once(paint)
    return LiveTimes(whole, painter.seconds["colour"] - colour_before)
