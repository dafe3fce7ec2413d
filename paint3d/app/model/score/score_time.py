"""How long a score takes to be played at the hand's own speed, and when each step of it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from paint3d.device.sample import DeviceSample
from paint3d.recording.hand_time import HandTime
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score

__all__ = ["after_samples", "pass_command", "seconds_of"]

_OF_INK = frozenset({"follow_time", "let_time_pass"})


def after_samples(clock: HandTime, samples: Iterable[DeviceSample]) -> None:
    """Count samples of the stroke that goes on."""
    clock.pass_samples(np.array([sample.time_ns for sample in samples], np.int64))


def pass_command(clock: HandTime, command: str, options: Mapping[str, Any]) -> None:
    """Count what was asked for; it takes time only where ink is left to spread."""
    if command in _OF_INK:
        clock.pass_ink(float(options["seconds"]))


def seconds_of(score: Score) -> float:
    """How long a score takes at the hand's own speed, s."""
    clock = HandTime()
    for event in score.events:
        if isinstance(event, Recording):
            clock.pass_samples(event.time_ns)
        else:
            for _ in range(event.get("times", 1)):
                pass_command(clock, event["do"], event)
    return clock.seconds
