"""Recordings of device events reach the window as they were made, with their own times."""

from __future__ import annotations

import importlib.util
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.studio import StudioWindow
from tests.support.app.event_player import (
    FOLDER,
    DeviceEvent,
    EventPlayer,
    EventRecording,
    hand_over,
    open_for,
    pen_ways,
    without_slips,
)
from tests.support.app.windows import close_unasked

NAMES = sorted(path.stem for path in FOLDER.glob("*.jsonl"))
MAKER = Path(__file__).parents[2] / "scripts" / "make_event_recordings.py"


class Seen(QtCore.QObject):
    """Remembers what the canvas gets."""

    def __init__(self, canvas: QtWidgets.QWidget) -> None:
        super().__init__(canvas)
        self.events: list[tuple] = []
        canvas.installEventFilter(self)

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Note down, and let pass."""
        if isinstance(event, QtGui.QTabletEvent):
            place = event.position()
            tilt = (event.xTilt(), event.yTilt())
            self.events.append(
                ("pen", event.timestamp(), place.x(), place.y(), event.pressure(), tilt)
            )
        elif isinstance(event, QtGui.QMouseEvent):
            self.events.append(("mouse", event.timestamp(), event.buttons()))
        return False


@pytest.fixture(autouse=True, scope="module")
def few_pictures() -> None:
    """Pictures are drawn here as often as users see them."""


@pytest.fixture(scope="module")
def window(program):
    """A window with a sheet in it."""
    window = StudioWindow(program)
    window.show()
    open_for(window, EventRecording.load("zigzag").header, 2.0)
    yield window
    close_unasked(window)


def test_the_recordings_are_those_that_the_script_makes(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("make_event_recordings", MAKER)
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    assert sorted(maker.RECORDINGS) == NAMES
    for name, make in maker.RECORDINGS.items():
        desk = make()
        maker.check(desk)
        desk.write(tmp_path / "again.jsonl")
        assert (tmp_path / "again.jsonl").read_text() == (FOLDER / f"{name}.jsonl").read_text()


@pytest.mark.parametrize("name", NAMES)
def test_every_recording_can_be_read(name: str) -> None:
    recording = EventRecording.load(name)
    assert 50 < len(recording.events) < 1000
    assert all(a.time_ms <= b.time_ms for a, b in pairwise(recording.events))
    for stroke in recording.strokes():
        assert [event.kind for event in stroke].count("press") == 1
        assert stroke[-1].kind == "release"


def test_a_pen_comes_with_its_time_place_pressure_and_tilt(window) -> None:
    recording = EventRecording.load("tilt_chart").part(20, 21)
    seen, player = Seen(window.canvas), EventPlayer(window)
    player.play(recording, "burst", n=5, begin_ms=7_000_000)
    pens = [event for event in recording.events if event.device == "pen"]
    got = [event for event in seen.events if event[0] == "pen"]
    assert [event[1] for event in got] == [7_000_000 + event.time_ms for event in pens]
    assert [event[4] for event in got] == pytest.approx([event.pressure for event in pens])
    tilts = np.array([event.tilt for event in pens])
    np.testing.assert_allclose([event[5] for event in got], tilts, atol=1e-4)
    assert abs(tilts[-1]).max() > 20.0
    ways = pen_ways(window, recording)
    assert len(ways) == 1
    ends = np.array([recording.strokes()[0][k].place for k in (0, -1)])
    np.testing.assert_allclose(ways[0][[0, -1], :2], ends, atol=0.01)


def test_fingers_come_with_their_places_and_times(window, monkeypatch) -> None:
    touches = []

    def see(event: QtCore.QEvent) -> bool:
        if not isinstance(event, QtGui.QTouchEvent):
            return type(window.canvas).event(window.canvas, event)
        places = {p.id(): p.position().toTuple() for p in event.points()}
        touches.append((event.timestamp(), places))
        event.accept()
        return True

    monkeypatch.setattr(window.canvas, "event", see)
    window.canvas.setAttribute(QtCore.Qt.WidgetAttribute.WA_AcceptTouchEvents)
    recording, player = EventRecording.load("touch_turns"), EventPlayer(window)
    player.play(recording, begin_ms=8_000_000)
    assert [time for time, _ in touches] == [8_000_000 + e.time_ms for e in recording.events]
    both = next(places for _, places in touches if len(places) == 2)
    for event in recording.events[:2]:
        place = np.array(player.pixel(event.place).toTuple())
        assert np.abs(place - both[min(both, key=lambda k: abs(place - both[k]).sum())]).max() < 1.0


def test_a_mouse_comes_with_its_time(window) -> None:
    recording = EventRecording.load("mouse_lines").part(0, 1)
    seen = Seen(window.canvas)
    EventPlayer(window).play(recording, "as recorded", begin_ms=9_000_000)
    got = [event[1] for event in seen.events if event[0] == "mouse"]
    assert got == [9_000_000 + event.time_ms for event in recording.events]


def test_keys_reach_the_actions(window) -> None:
    player = EventPlayer(window)
    length = window.document.painter.brush.length_mm
    press, release = (
        DeviceEvent("key", kind, key="]", time_ms=t) for kind, t in (("press", 0), ("release", 40))
    )
    player.play(EventRecording({}, (press, release)))
    assert window.document.painter.brush.length_mm > length


@pytest.mark.parametrize(
    ("how", "sizes"),
    [
        ("one by one", [1] * 10),
        ("burst", [4, 4, 2]),
        ("at once", [10]),
        ("pictures", [3, 2, 3, 2]),
        ("as recorded", [5, 5]),
    ],
)
def test_events_are_handed_over_in_batches(how: str, sizes: list[int]) -> None:
    events = [
        DeviceEvent("pen", "move", time_ms=10 * k, handled_ms=50 * (k // 5 + 1)) for k in range(10)
    ]
    batches = list(hand_over(events, how, n=4, pictures_a_second=40.0))
    assert [len(batch) for batch in batches] == sizes
    assert [event for batch in batches for event in batch] == events


def test_a_stroke_of_a_recording_paints_on_its_way(window) -> None:
    recording = EventRecording.load("directions").part(0, 1)
    open_for(window, recording.header, 2.0)
    painted = []
    EventPlayer(window).play(
        recording, after_stroke=lambda k: painted.append((k, window.document.surface.painted.sum()))
    )
    assert painted[0][0] == 0
    assert painted[0][1] > 10
    assert len(window.document.strokes) == 1


def test_a_ray_that_slips_through_a_crack_is_no_place_of_the_pen() -> None:
    """Three events, 10 pixels and 8 mm apart; between the first two a ray falls 90 mm deep."""
    at, behind = np.arange(21.0), np.array([0.0, 10.0, 20.0])
    way = np.stack([0.8 * at, 0.0 * at, 0.0 * at], axis=1)
    events = way[[0, 10, 20]]
    way[[4, 10], 2] = -90.0
    way[15, 2] = -1.5  # in a groove, but near
    found = without_slips(way, at, events, behind)
    assert np.isnan(found[[4, 10]]).all()
    kept = np.delete(np.arange(21), [4, 10])
    np.testing.assert_array_equal(found[kept], way[kept])
    events[2, 2] = way[11:, 2] = -90.0  # the pen itself went there
    assert np.isfinite(without_slips(way, at, events, behind)[11:]).all()
