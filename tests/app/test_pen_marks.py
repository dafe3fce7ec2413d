"""What a hand's events leave on the surface: under the pen, whole, and alike on every machine."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.studio import StudioWindow
from tests.support.app import event_player
from tests.support.app.event_player import EventRecording, look, open_for, settle
from tests.support.app.gestures import answer
from tests.support.app.hands import same_vertices
from tests.support.app.marks import (
    begins_and_goes_on,
    beyond,
    ink_per_mm,
    inked_share,
    largest_jump,
    largest_rise,
    off_the_way,
    stations,
    strongest_spot,
)
from tests.support.app.random_strokes import random_strokes
from tests.support.app.trials import (
    HALF_FOOTPRINT,
    blind_window,
    faults,
    mark_now,
    player_of,
    try_strokes,
    ways_of,
)

UPRIGHT = {"tilt": (0.0, 0.0)}
REACH = 10.0  # mm, beside the way: what is farther off is measured by `stray`


@pytest.fixture(scope="module")
def window(program):
    """A window that draws no pictures."""
    with blind_window(program) as window:
        yield window


def upright_ink(window: StudioWindow, recording: EventRecording) -> list[float]:
    """Ink a millimetre of the same strokes by a pen held upright."""
    upright = recording.changed(**UPRIGHT)
    return [ink_per_mm(trial.mark, trial.way) for trial in try_strokes(window, upright)]


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(1, id="15", marks=pytest.mark.long),
        pytest.param(2, id="30", marks=pytest.mark.long),
        pytest.param(3, id="45"),
        pytest.param(4, id="60", marks=pytest.mark.long),
    ],
)
def test_a_pen_that_leans_paints_under_its_point(window, row: int) -> None:
    chart = EventRecording.load("tilt_chart")
    open_for(window, chart.header)
    wanted = upright_ink(window, chart.part(0, 1))[0]
    trials = try_strokes(window, chart.part(8 * row, 8 * row + 8))
    assert [fault for trial in trials for fault in faults(trial, wanted)] == []


def test_a_pen_that_is_turned_about_its_axis_paints_under_its_point(window) -> None:
    chart = EventRecording.load("tilt_chart")
    open_for(window, chart.header)
    wanted = upright_ink(window, chart.part(0, 1))[0]
    told = []
    for rotation in (60.0, 180.0, 270.0):
        turned = chart.part(26, 27).changed(rotation=rotation)
        for trial in try_strokes(window, turned):
            told += [f"{rotation} degrees: {fault}" for fault in faults(trial, wanted)]
    assert told == []


@pytest.mark.parametrize(
    "tilt",
    [
        pytest.param((0.0, 0.0), id="upright", marks=pytest.mark.long),
        pytest.param((35.0, 35.0), id="45"),
    ],
)
def test_lines_inside_the_bowl_are_whole(window, tilt: tuple[float, float]) -> None:
    lines = EventRecording.load("bowl_lines")
    open_for(window, lines.header)
    wanted = upright_ink(window, lines.part(6, 7))[0]  # outside, where it always was right
    trials = try_strokes(window, lines.changed(tilt=tilt))
    assert [fault for trial in trials for fault in faults(trial, wanted)] == []


@pytest.mark.parametrize(
    ("name", "side"),
    [
        ("bowl", "in"),
        pytest.param("bowl", "out", marks=pytest.mark.long),
        pytest.param("vase", "out", marks=pytest.mark.long),
        pytest.param("sphere", "any", marks=pytest.mark.long),
        pytest.param("plate", "any", marks=pytest.mark.long),
    ],
)
def test_no_random_stroke_is_lost(window, name: str, side: str) -> None:
    open_for(window, {"object": name, "material": "porcelain"}, 1.0)
    rng, lost = np.random.default_rng(20), []
    for number, stroke in enumerate(random_strokes(window, rng, 6, side, tilt_degrees=50.0)):
        for trial in try_strokes(window, stroke):
            share = inked_share(trial.mark, trial.way, HALF_FOOTPRINT)
            jump = largest_jump(stations(trial.mark, trial.way, reach_mm=REACH))
            if share < 0.98 or jump > 2.0:
                lost.append(f"stroke {number}: inked {share:.3f}, jump of {jump:.2f} mm")
    assert lost == []


def test_strokes_right_after_a_change_of_brush_are_painted(window) -> None:
    switched = EventRecording.load("brush_switch")
    open_for(window, switched.header)
    ways = ways_of(window, switched)
    player_of(window).play(switched)
    mark = mark_now(window)
    near = [mark.within(way, 16.0) for way in ways]
    inked = [inked_share(*each, HALF_FOOTPRINT) for each in zip(near, ways, strict=True)]
    off = [off_the_way(stations(*each), 95.0, ends_mm=5.0) for each in zip(near, ways, strict=True)]
    assert min(inked) >= 0.98, inked
    assert max(off) <= 1.0, off


@pytest.mark.parametrize("name", ["band", pytest.param("mouse_lines", marks=pytest.mark.long)])
def test_the_mark_does_not_depend_on_how_events_are_handed_over(window, name: str) -> None:
    recording = EventRecording.load(name)
    surfaces = []
    for how, pace in (
        ("one by one", 0.0),
        ("at once", 0.0),
        ("pictures", 5.0),
        ("pictures", 120.0),
        ("as recorded", 0.0),
    ):
        open_for(window, recording.header, 2.0)
        in_time = pace == 120.0
        player_of(window).play(
            recording, how, pictures_a_second=pace, real_time=in_time, late=not in_time
        )
        surfaces.append(window.document.surface)
        if len(surfaces) > 1:
            same_vertices(surfaces[0], surfaces[-1])
    strokes = [stroke.samples for stroke in window.document.strokes]
    open_for(window, recording.header, 2.0)
    for samples in strokes:
        window.workspace.post("begin_stroke")
        window.stage.paint_thread.feed(samples)
        window.workspace.post("end_stroke")
    settle(window)
    same_vertices(surfaces[0], window.document.surface)


def test_a_stroke_is_saved_whole_though_another_object_is_opened_at_once(
    window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    band, file = EventRecording.load("band"), tmp_path / "band.p3d"
    left = []
    for held in (False, True):
        open_for(window, band.header, 1.0)
        assert window.saving.save_to(file)
        document, gate = window.document, threading.Event()
        if held:  # the painting stands still until the other object is being opened
            window.stage.paint_thread.post(lambda document, gate=gate: gate.wait(300))
            monkeypatch.setattr(event_player, "settle", lambda window: None)
            threading.Timer(2.0, gate.set).start()
        player_of(window).play(band, "at once")
        assert held == (len(document.strokes) == 0)
        window.workspace.quiet = False
        answer(lambda box: box.defaultButton().click(), QtWidgets.QMessageBox)  # Save
        assert window.opening.open_path("sphere", 4.0, "porcelain")
        window.workspace.quiet = True
        assert window.document is not document
        left.append(Document.open(file))
    assert len(left[1].strokes) == len(left[0].strokes) > 0
    same_vertices(left[0].surface, left[1].surface)


@pytest.mark.long
def test_strokes_in_all_directions_start_as_wide_as_they_go_on(window) -> None:
    starts = EventRecording.load("long_directions")
    open_for(window, starts.header, 0.5)
    tuft = window.document.painter.brush.length_mm
    ratios = []
    for trial in try_strokes(window, starts):
        early, late = begins_and_goes_on(stations(trial.mark, trial.way), tuft)
        ratios.append(round(early / late, 3))
    assert 0.85 <= min(ratios) <= max(ratios) <= 1.15, ratios


def test_falling_pressure_narrows_the_mark_all_the_way(window) -> None:
    falling = EventRecording.load("falling_pressure")
    open_for(window, falling.header, 0.5)
    rises = []
    for trial in try_strokes(window, falling.part(0, 2)):
        found = stations(trial.mark, trial.way, step_mm=2.0)
        rises.append(largest_rise(found.width[int(np.argmax(found.width)) :]))
    assert max(rises) <= 0.03, rises


def test_a_fast_lift_leaves_no_dot_and_nothing_beyond_the_pen(window) -> None:
    falling = EventRecording.load("falling_pressure")
    open_for(window, falling.header, 0.5)
    rises, over = [], []
    for trial in try_strokes(window, falling.part(2, 6)):
        found = stations(trial.mark, trial.way)
        rises.append(largest_rise(found.width[found.at > found.at[-1] - 8.0]))
        over.append(beyond(trial.mark, trial.way))
    assert max(rises) <= 0.05, rises
    assert max(over) <= 1.0, over  # twice the resolution: edges fade over one


@pytest.mark.long
def test_pale_ink_has_no_dark_stamps_at_its_ends(window) -> None:
    pale = EventRecording.load("pale_ink")
    open_for(window, pale.header, 0.5)
    trials = try_strokes(window, pale.part(0, 2))
    spots = [strongest_spot(trial.mark, trial.way, 8.0) for trial in trials]
    assert max(spots) <= 1.3, spots


def test_the_view_is_that_which_was_asked_for(window) -> None:
    """The trials stand on it: a stroke's way is where the pen's rays meet the object."""
    open_for(window, {"object": "sphere", "material": "porcelain"}, 2.0)
    stroke = next(random_strokes(window, np.random.default_rng(3), 1))
    there = window.hand.camera
    window.hand.show_all()
    look(window, stroke.header["view"])
    np.testing.assert_array_equal(window.hand.camera.position, there.position)
