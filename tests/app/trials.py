"""Strokes of recordings painted one by one in the window, each on a clean surface, and measured."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from paint3d.app.window.studio import StudioWindow
from tests.app.event_player import EventPlayer, EventRecording, pen_ways, settle, surface_of
from tests.app.marks import Mark, Way, take_mark

__all__ = ["Trial", "blind", "mark_now", "player_of", "try_strokes", "ways_of"]


class Trial(NamedTuple):
    """One stroke: its number in the recording, the mark it left, the way of the pen."""

    number: int
    mark: Mark
    way: Way


def player_of(window: StudioWindow) -> EventPlayer:
    """The window's one player: its clock goes on."""
    there = window.findChild(EventPlayer)
    return EventPlayer(window) if there is None else there


@contextmanager
def blind(window: StudioWindow) -> Iterator[None]:
    """Draw no pictures meanwhile: only what is painted is looked at, and it takes a third."""
    window.stage.draw = lambda: None
    try:
        yield
    finally:
        del window.stage.draw


def mark_now(window: StudioWindow) -> Mark:
    """What is painted by now."""
    with window.stage.easel.paused() as document:
        return take_mark(document.surface)


def ways_of(window: StudioWindow, recording: EventRecording) -> list[Way]:
    """Where the pen goes on the object in each stroke, in the view of now."""
    surface = surface_of(window)
    return [Way(way, surface.find(way).normals) for way in _finite(pen_ways(window, recording))]


def try_strokes(
    window: StudioWindow, recording: EventRecording, how: str = "one by one", **options: object
) -> Iterator[Trial]:
    """Paint the strokes of a recording, and take each back when it was looked at."""
    player = player_of(window)
    for number, way in enumerate(ways_of(window, recording)):
        n_before = len(window.document.strokes)
        player.play(recording.part(number, number + 1), how, **options)
        yield Trial(number, mark_now(window), way)
        if len(window.document.strokes) > n_before:
            window.post("undo")
            settle(window)


def _finite(ways: list[np.ndarray]) -> list[np.ndarray]:
    return [way[np.isfinite(way).all(axis=1)] for way in ways]
