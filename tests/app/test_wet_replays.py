"""Wet ink in the window: alike however events come, and replayed to the bit."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtTest

from paint3d.app.model import paint_thread as paint_threads
from paint3d.app.model.ink_clock import LATE_S
from paint3d.app.model.input.event_clock import EventClock
from paint3d.app.window.hand import canvas as canvases
from paint3d.app.window.playing import player as players
from paint3d.cli.main import main
from paint3d.files.project.session import load_session
from paint3d.painter.ink_time import INK_STEP_NS, INK_STEP_S
from paint3d.painter.painter import Painter
from paint3d.recording.recording import load_recording
from paint3d.recording.recording import save_recording as save_recording_file
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.event_player import (
    PAUSE_MS,
    EventRecording,
    hand_over,
    open_for,
    process,
    settle,
)
from tests.support.app.gestures import wait_for
from tests.support.app.hands import same_vertices
from tests.support.app.trials import blind_window, player_of
from tests.support.examples import ALL

_STALL_S = 0.004  # in which the ink would go on by itself
_GRID_MS = INK_STEP_NS // 1_000_000  # events are the same if they fall alike between its lines
WAYS = (("pictures", 5.0), ("pictures", 120.0), ("one by one", 0.0), ("burst", 0.0))
KEPT = WAYS if ALL else (WAYS[1], WAYS[3])  # the rest with --long


class Wall:
    """A clock for window and painting that goes on when it is told to, on every machine alike.

    It begins anew for each test, so the window forgets what it knew of devices' times.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch, window) -> None:
        monkeypatch.setattr(window.canvas, "_clock", EventClock())
        monkeypatch.setattr(window.canvas, "_pen_touched_ns", None)  # a mouse were its stray event
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
        open_for(window, {"object": "plane"}, 4.0)  # its ink is at hand for what is opened next
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
                window.stage.paint_thread.post(lambda document: None).result(300)
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
    for how, pace in KEPT:
        open_for(window, {**recording.header, "material": "xuan", "wet": True}, 2.4)
        play(window, recording, wall, how, pace)
        surface = window.document.surface
        assert surface.flow.water > 0.0
        if first is None:
            first = surface
        same_vertices(first, surface)
        assert surface.flow.water == first.flow.water, (how, pace)
    # its ink is at hand for what is opened next, which would have a column of it
    open_for(window, {**lines().header, "material": "xuan", "wet": True}, 2.4)


# -- the recording that the window saves -------------------------------------------------------


RESOLUTION = 2.4
RESTS_MS = (90, 4730, 620)  # between strokes: they come soon, late, and as they mostly do


@pytest.fixture
def wall(window, monkeypatch):
    return Wall(monkeypatch, window)


def lines() -> EventRecording:
    """Four lines by a mouse, and what passes between them."""
    recording = EventRecording.load("mouse_lines")
    events, end_ms = [], 0
    for stroke, rest_ms in zip(recording.strokes(), (50, *RESTS_MS), strict=False):
        later_ms = end_ms + rest_ms - stroke[0].time_ms
        events += [replace(event, time_ms=event.time_ms + later_ms) for event in stroke]
        end_ms = events[-1].time_ms
    return EventRecording(recording.header, tuple(events))


def save_recording(window, monkeypatch, path: Path) -> None:
    """As the menu does, once it is known where."""
    monkeypatch.setattr(window.targets, "ask", lambda *asked: path)
    window.workspace.actions["save_recording"].trigger()
    assert path.exists()


def same_ink(one: PaintedSurface, other: PaintedSurface) -> None:
    """Check that two surfaces hold the same, the water in them too."""
    same_vertices(one, other)
    assert one.flow.water == other.flow.water > 0.0
    for kept in ("owed", "pace", "soaked", "pigment"):
        first, second = (np.sort(s.keep_flow()[kept], axis=0) for s in (one, other))
        np.testing.assert_array_equal(first, second)


def replayed(recording: Path, rest_s: float) -> PaintedSurface:
    """By the command line."""
    out = recording.with_suffix(".p3d")
    words = ["replay", recording, "--on", "plane", "--material", "xuan", "--resolution", RESOLUTION]
    words += ["--spread", rest_s, "--out", out, "--force", "--quiet"]
    assert main([str(word) for word in words]) == 0
    return load_session(out).surface


def rest(window, wall: Wall, seconds: float) -> None:
    """Let time pass on the wall while nobody paints, and what it is worth to the ink."""
    wall.ms += round(1000.0 * (seconds + LATE_S))
    paint_thread = window.stage.paint_thread
    while paint_thread.ink_clock.patience(wall.ms * 1_000_000) == 0.0:
        settle(window)
    settle(window)


@pytest.mark.parametrize(
    ("how", "pace", "rest_s"),
    [pytest.param("pictures", 20.0, 0.0, marks=pytest.mark.long), ("at once", 0.0, 7.31)],
)
def test_the_wet_recording_paints_the_same_to_the_bit(
    window, wall, monkeypatch, tmp_path, how, pace, rest_s
) -> None:
    events, file = lines(), tmp_path / "lines.jsonl"
    open_for(window, {**events.header, "material": "xuan", "wet": True}, RESOLUTION)
    play(window, events, wall, how, pace)
    save_recording(window, monkeypatch, file)
    rests = np.sort(np.diff(load_recording(file).time_ns))[-3:]
    np.testing.assert_allclose(1e-6 * rests, sorted(RESTS_MS), atol=5.0)
    if rest_s:
        rest(window, wall, rest_s)
    same_ink(window.document.surface, replayed(file, rest_s))


@pytest.mark.long
def test_the_window_replays_it_to_the_bit_too(window, wall, monkeypatch, tmp_path) -> None:
    events, file = lines(), tmp_path / "lines.jsonl"
    header = {**events.header, "material": "xuan", "wet": True}
    open_for(window, header, RESOLUTION)
    play(window, events, wall, "at once", 0.0)
    save_recording(window, monkeypatch, file)
    open_for(window, header, RESOLUTION)
    wall.ms += 13  # the hand's clock stands anywhere
    monkeypatch.setattr(players, "time", paint_threads.time)
    assert window.recordings.replay_file(str(file))
    wait_for(lambda: not window.player.is_playing)
    same_ink(window.document.surface, replayed(file, 0.0))


def test_a_recording_of_another_day_lets_no_more_time_pass_first(
    window, wall, monkeypatch, tmp_path
) -> None:
    events, file = lines(), tmp_path / "later.jsonl"
    open_for(window, {**events.header, "material": "xuan", "wet": True}, RESOLUTION)
    play(window, events.part(0, 1), wall, "at once", 0.0)
    save_recording(window, monkeypatch, file)
    recording = load_recording(file)
    later = replace(recording, time_ns=recording.time_ns + 86_400_000_000_000)
    save_recording_file(later, file)
    pieces, follow = [], PaintedSurface.follow_time
    monkeypatch.setattr(
        PaintedSurface, "follow_time", lambda *given: pieces.append(1) or follow(*given)
    )
    monkeypatch.setattr(players, "time", paint_threads.time)
    assert window.recordings.replay_file(str(file))
    wait_for(lambda: not window.player.is_playing)
    assert 0 < len(pieces) < 2.0 * recording.duration_s / INK_STEP_S + 10


@pytest.mark.long
def test_so_does_thinned_ink_by_a_pen(window, wall, monkeypatch, tmp_path) -> None:
    """A recording does not say how far ink is thinned: the brush is dipped as it was."""
    events, file = EventRecording.load("bamboo").part(0, 16), tmp_path / "bamboo.jsonl"
    open_for(window, {**events.header, "material": "xuan", "wet": True}, RESOLUTION)
    play(window, events, wall, "pictures", 60.0)
    save_recording(window, monkeypatch, file)
    surface = PaintedSurface(window.document.surface.source, RESOLUTION, "xuan")
    Painter(surface, "full", events.header["ink"]).replay(load_recording(file), wet=True)
    same_ink(window.document.surface, surface)
