"""Ink that spreads while events come into the window: alike however they are handed over."""

from __future__ import annotations

import time
from types import SimpleNamespace

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtTest

from paint3d.app.model import paint_thread as paint_threads
from paint3d.app.model.input.event_clock import EventClock
from paint3d.app.window.hand import canvas as canvases
from paint3d.painter.ink_time import PIECE_NS
from tests.support.app.event_player import (
    PAUSE_MS,
    EventRecording,
    hand_over,
    open_for,
    process,
    settle,
)
from tests.support.app.hands import same_vertices
from tests.support.app.trials import blind_window, player_of

_STALL_S = 0.004  # in which the ink would go on by itself
_GRID_MS = PIECE_NS // 1_000_000  # events are the same if they fall alike between its lines
WAYS = (("pictures", 5.0), ("pictures", 120.0), ("one by one", 0.0), ("burst", 0.0))


class Wall:
    """A clock for window and painting that goes on when it is told to, on every machine alike.

    It begins anew for each test, so the window forgets what it knew of devices' times.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch, window) -> None:
        monkeypatch.setattr(window.canvas, "_clock", EventClock())
        self.ms = 10_000_000
        names = {name: getattr(time, name) for name in ("monotonic", "thread_time", "sleep")}
        clock = SimpleNamespace(
            perf_counter=lambda: 1e-3 * self.ms, perf_counter_ns=lambda: 1_000_000 * self.ms,
            **names,
        )  # fmt: skip
        for module in (paint_threads, canvases):
            monkeypatch.setattr(module, "time", clock)
        monkeypatch.setattr(
            paint_threads.Pace, "most", lambda pace, behind_s: 1000
        )  # it is followed


@pytest.fixture(scope="module")
def window(program):
    """A window that draws no pictures."""
    with blind_window(program) as window:
        yield window


def play(window, recording: EventRecording, wall: Wall, how: str, pace: float) -> None:
    """Hand events over when their picture ends, by the clock on the wall."""
    window.activateWindow()  # a bar had the keys until now
    assert QtTest.QTest.qWaitForWindowActive(window, 60_000)
    player, begin_ms = player_of(window), -(-(wall.ms + PAUSE_MS) // _GRID_MS) * _GRID_MS
    player.aspect = recording.header.get("aspect")
    for batch in hand_over(recording.events, how, 12, pace):
        wall.ms = begin_ms + batch[-1].time_ms
        if how == "burst":  # something holds the window up, longer than between two strokes
            for _ in range(5):
                window.stage.paint_thread.post(lambda document: None).result(60)
                time.sleep(_STALL_S)
        for event in batch:
            player.send(event, begin_ms)
        process()
    settle(window)


@pytest.mark.parametrize("name", ["mouse_lines", pytest.param("bamboo", marks=pytest.mark.long)])
def test_wet_ink_does_not_depend_on_how_events_are_handed_over(window, monkeypatch, name) -> None:
    recording, wall = EventRecording.load(name), Wall(monkeypatch, window)
    recording = recording.part(0, 16 if name == "bamboo" else 3)  # no time for ink after the last
    first = None
    for how, pace in WAYS:
        open_for(window, {**recording.header, "material": "xuan", "wet": True}, 2.4)
        play(window, recording, wall, how, pace)
        surface = window.document.surface
        assert surface.flow.water > 0.0
        if first is None:
            first = surface
        same_vertices(first, surface)
        assert surface.flow.water == first.flow.water, (how, pace)
