"""Painting as it happens: a frame's samples, then the colours that changed, 30 times a second."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from paint3d.bench.stopwatch import Times
from paint3d.device.sample import DeviceSample
from paint3d.stroke.engine import Painter
from paint3d.stroke.recording import Recording

__all__ = ["FRAME_HZ", "LiveTimes", "frames_of", "play"]

FRAME_HZ = 30.0


@dataclass(frozen=True)
class LiveTimes:
    """What a stroke cost, and how much of it the colours did."""

    whole: Times
    colour: Times

    def best(self, other: LiveTimes) -> LiveTimes:
        """The smaller of each."""
        return LiveTimes(self.whole.best(other.whole), self.colour.best(other.colour))


def frames_of(recording: Recording) -> list[list[DeviceSample]]:
    """The samples as a live device gives them, frame by frame of the stroke's own time."""
    seconds = (recording.time_ns - recording.time_ns[0]) * 1e-9
    frame = np.floor(seconds * FRAME_HZ).astype(np.int64)
    frames: list[list[DeviceSample]] = [[] for _ in range(int(frame[-1]) + 1)]
    for at, sample in zip(frame, recording.samples(), strict=True):
        frames[at].append(sample)
    return frames


def play(painter: Painter, frames: list[list[DeviceSample]]) -> LiveTimes:
    """Paint one stroke live, colours included, as fast as it goes; the brush is dipped before."""
    painter.dip()
    surface = painter.surface
    surface.refresh()
    colour_wall = colour_cpu = 0.0
    wall, cpu = time.perf_counter(), time.thread_time()
    for k, samples in enumerate(frames):
        painter.advance(samples)
        if k + 1 == len(frames):
            painter.finish()
        before_wall, before_cpu = time.perf_counter(), time.thread_time()
        surface.refresh()
        colour_wall += time.perf_counter() - before_wall
        colour_cpu += time.thread_time() - before_cpu
    return LiveTimes(
        Times(time.perf_counter() - wall, time.thread_time() - cpu),
        Times(colour_wall, colour_cpu),
    )
