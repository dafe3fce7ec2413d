"""Strokes of recordings painted one by one in the window, each on a clean surface, and measured."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
from PySide6 import QtWidgets

from paint3d.app.window.studio import StudioWindow
from tests.support.app.event_player import EventPlayer, EventRecording, pen_ways, settle, surface_of
from tests.support.app.marks import (
    Mark,
    Way,
    ink_per_mm,
    inked_share,
    largest_jump,
    off_the_way,
    stations,
    take_mark,
)
from tests.support.app.windows import blind, close_unasked

__all__ = [
    "HALF_FOOTPRINT",
    "Trial",
    "blind_window",
    "faults",
    "mark_now",
    "player_of",
    "try_strokes",
    "ways_of",
]

LEAP_MM = 3.0  # between two pixels' rays: a brush is lifted there
HALF_FOOTPRINT = 2.4  # mm: of the full brush at a quarter of its pressure


class Trial(NamedTuple):
    """One stroke: its number in the recording, the mark it left, the path of the pen."""

    number: int
    mark: Mark
    way: Way


def player_of(window: StudioWindow) -> EventPlayer:
    """The window's one player: its clock goes on."""
    there = window.findChild(EventPlayer)
    return EventPlayer(window) if there is None else there


def faults(trial: Trial, wanted_ink: float | None = None) -> list[str]:
    """List how a stroke differs from what any should be; its ink, if that is given, coats x mm."""
    parts = stations(trial.mark, trial.way)
    inked = inked_share(trial.mark, trial.way, HALF_FOOTPRINT)
    off = off_the_way(parts, 95.0, ends_mm=1.0)
    jump = largest_jump(parts)
    differences = []
    if inked < 0.98:
        differences.append(f"inked {inked:.3f}")
    if off > 1.2:
        differences.append(f"{off:.2f} mm off")
    if jump > 2.0:
        differences.append(f"jump of {jump:.2f} mm")
    ink = 1.0 if wanted_ink is None else ink_per_mm(trial.mark, trial.way) / wanted_ink
    if not 0.85 <= ink <= 1.25:  # on paper lanes of hairs bring more or less
        differences.append(f"ink {ink:.2f} of what was wanted")
    return [f"stroke {trial.number}: {', '.join(differences)}"] if differences else []


@contextmanager
def blind_window(program: QtWidgets.QApplication) -> Iterator[StudioWindow]:
    """A window that draws no pictures; nothing of it is asked for when it closes."""
    window = StudioWindow(program)
    window.show()
    with blind(window):
        yield window
    close_unasked(window)


def mark_now(window: StudioWindow) -> Mark:
    """Return the mark on the surface now."""
    with window.stage.paint_thread.paused() as document:
        return take_mark(document.surface)


def ways_of(window: StudioWindow, recording: EventRecording) -> list[Way]:
    """Compute the pen's path on the object in each stroke, in the current view."""
    surface = surface_of(window)
    return [
        Way(way, surface.find(way).normals, surface=surface, leap_mm=LEAP_MM)
        for way in _finite(pen_ways(window, recording))
    ]


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
            window.workspace.post("undo")
            settle(window)


def _finite(ways: list[np.ndarray]) -> list[np.ndarray]:
    return [way[np.isfinite(way).all(axis=1)] for way in ways]
