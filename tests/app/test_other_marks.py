"""What others than a pen leave: images of a symmetry, ghosts, fingers, mice and pads."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.typing import ArrayLike

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from paint3d.app.window.hand import canvas as canvases
from paint3d.app.window.studio import StudioWindow
from paint3d.cli.sources import lay_on
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.event_player import DeviceEvent, EventRecording, open_for, settle, surface_of
from tests.support.app.hands import pad_stroke
from tests.support.app.marks import Way, ink_per_mm, take_mark
from tests.support.app.random_strokes import random_strokes
from tests.support.app.trials import (
    Trial,
    blind_window,
    faults,
    mark_now,
    player_of,
    try_strokes,
    ways_of,
)
from tests.support.cases import long_but
from tests.support.examples import ALL

STEP_MS = 10
SPEED_MM_S = 80.0
BY_HAND = [("bowl", "in"), pytest.param("vase", "out", marks=pytest.mark.long)]
BESIDE = 9.0  # mm: what is farther from a way belongs to another image


@pytest.fixture(scope="module")
def window(program):
    """A window that draws no pictures."""
    with blind_window(program) as window:
        yield window


def stroke_along(
    places: ArrayLike,
    header: dict,
    device: str = "pen",
    pressure: float = 0.25,
    tilt: tuple[float, float] = (0.0, 0.0),
) -> EventRecording:
    """One stroke along a line (N, 2 or 3) on the object, mm, from press to release."""
    line = np.asarray(places, float)
    behind = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    n = max(2, round(behind[-1] / SPEED_MM_S * 1000.0 / STEP_MS))
    at = np.linspace(0.0, behind[-1], n)
    points = np.stack([np.interp(at, behind, column) for column in line.T], axis=1)
    rows = [("press" if k == 0 else "move", p, pressure) for k, p in enumerate(points)]
    rows.append(("release", points[-1], 0.0))
    events = [
        DeviceEvent(device, kind, tuple(place), force, tilt, 0.0,
                    ("left",) if kind != "release" and device != "touch" else (),
                    time_ms=STEP_MS * k, handled_ms=STEP_MS * k + 3)
        for k, (kind, place, force) in enumerate(rows)
    ]  # fmt: skip
    return EventRecording({"places": "object", **header}, tuple(events))


def by_finger(recording: EventRecording) -> EventRecording:
    """The same by a finger."""
    return EventRecording(
        recording.header,
        tuple(replace(event, device="touch", buttons=(), id=1) for event in recording.events),
    )


def images_of(window: StudioWindow, way: Way) -> list[Way]:
    """The way under every image of the symmetry that is set, itself first."""
    found = []
    for image in (np.eye(4), *window.document.symmetry.images()):
        turned = way.points @ image[:3, :3].T + image[:3, 3]
        found.append(Way(turned, surface_of(window).find(turned).normals))
    return found


def apart(ways: list[Way]) -> float:
    """How near two of the ways come to one another, mm."""
    return min(
        float(one.tree.query(other.points)[0].min())
        for k, one in enumerate(ways)
        for other in ways[:k]
    )


@pytest.mark.parametrize(
    ("name", "actions"),
    [
        pytest.param("vase", ("mirror",), id="vase mirrored", marks=pytest.mark.long),
        pytest.param("bowl", ("radial",), id="bowl turned"),
        pytest.param("sphere", ("mirror", "radial"), id="sphere both", marks=pytest.mark.long),
    ],
)
def test_every_image_of_a_stroke_lies_under_the_image_of_its_way(window, name, actions) -> None:
    open_for(window, {"object": name, "material": "porcelain"}, 1.0)
    for action in actions:
        window.workspace.actions[action].setChecked(True)
    settle(window)
    told, tried, n = [], 0, 3 if ALL else 2
    side = "in" if name == "bowl" else "any"
    strokes = random_strokes(
        window, np.random.default_rng(6), 40, side, tilt_degrees=50.0, lengths_mm=(15.0, 25.0)
    )
    for stroke in strokes:
        ways = images_of(window, ways_of(window, stroke)[0])
        if apart(ways) < 2.0 * BESIDE:
            continue
        player_of(window).play(stroke)
        mark = mark_now(window)
        own = ink_per_mm(mark.within(ways[0], BESIDE), ways[0])
        for number, way in enumerate(ways):
            told += faults(Trial(number, mark.within(way, BESIDE), way), own)
        window.workspace.post("undo")
        settle(window)
        tried += 1
        if tried == n:
            break
    for action in actions:
        window.workspace.actions[action].setChecked(False)
    settle(window)
    assert tried == n
    assert told == []


@pytest.mark.parametrize(
    "tilt",
    [
        pytest.param((0.0, 0.0), id="upright", marks=pytest.mark.long),
        pytest.param((35.0, 35.0), id="45"),
    ],
)
def test_a_ghost_is_painted_over_where_it_stands_and_counted(window, tilt) -> None:
    open_for(window, {"object": "vase", "material": "porcelain", "view": "front"}, 0.9)
    assert window.copying.layout_text("二十", 36.0, False)
    ghosts = window.panels.copybook.copybook.ghosts
    told, strokes = [], []
    for number, ghost in enumerate(ghosts):
        for median in ghost.medians:
            strokes.append(stroke_along(median, {}, pressure=0.2, tilt=tilt))
            way = Way(median, surface_of(window).find(median).normals)
            player_of(window).play(strokes[-1])
            told += faults(Trial(number, mark_now(window), way))
            window.workspace.post("undo")
            settle(window)
    for stroke in strokes:
        player_of(window).play(stroke)
    until = time.monotonic() + 300.0
    while [len(ghost.strokes) for ghost in ghosts] != [2, 2] and time.monotonic() < until:
        settle(window)
    counted = [len(ghost.strokes) for ghost in ghosts]
    window.copying.hide()
    assert told == []
    assert counted == [2, 2]


def lines_on(window: StudioWindow, name: str, side: str, n: int) -> Iterator[EventRecording]:
    """Recordings of random strokes on an object, with the view they are to be played in."""
    open_for(window, {"object": name, "material": "porcelain"}, 1.0)
    return random_strokes(window, np.random.default_rng(12), n, side)


def wait_for_the_palm(window: StudioWindow) -> None:
    """For a moment after a pen was seen, what touches is the hand that holds it.

    By the events' times, which the computer's own has to come to.
    """
    ends_s = 1e-3 * player_of(window).now_ms + 0.25
    time.sleep(max(0.25, ends_s - time.monotonic()))


@pytest.mark.parametrize(("name", "side"), BY_HAND)
def test_a_finger_paints_under_its_point(window, monkeypatch, name: str, side: str) -> None:
    monkeypatch.setattr(window.canvas, "finger", "paint")  # by itself it turns once a pen was seen
    told = []
    for number, stroke in enumerate(lines_on(window, name, side, 3)):
        (way,) = ways_of(window, stroke)
        player_of(window).play(stroke)  # pens are played faster than a hand writes
        window.workspace.post("undo")
        settle(window)
        wait_for_the_palm(window)
        player_of(window).play(by_finger(stroke))
        told += faults(Trial(number, mark_now(window), way))
        window.workspace.post("undo")
        settle(window)
    assert told == []


@pytest.fixture
def own_window(program):
    """For events that are said to happen in some seconds: the window remembers such a clock."""
    with blind_window(program) as window:
        yield window


def test_a_finger_that_follows_a_pen_at_once_presses_as_after_a_pause(
    own_window, monkeypatch
) -> None:
    window = own_window
    monkeypatch.setattr(window.canvas, "finger", "paint")
    (stroke,) = lines_on(window, "sphere", "any", 1)
    slow = tuple(replace(event, time_ms=8 * event.time_ms) for event in stroke.events)
    player_of(window).play(EventRecording(stroke.header, slow), "at once")  # ends seconds from now
    monkeypatch.setattr(canvases, "_PALM_NS", 0)  # else it belongs to the hand that holds the pen
    player_of(window).play(by_finger(stroke))
    by_pen, by_touch = (each.samples for each in window.document.strokes)
    lasted = by_touch[-1].time_ns - by_touch[0].time_ns
    assert by_touch[0].time_ns > by_pen[-1].time_ns - 1_000_000  # a pen is lifted up to 1 ms late
    assert lasted >= 1e6 * stroke.events[-1].time_ms
    assert max(sample.pressure for sample in by_touch) > 0.15


@pytest.mark.parametrize(("name", "side"), BY_HAND)
def test_a_mouse_paints_under_its_point(window, name: str, side: str) -> None:
    told = []
    for stroke in lines_on(window, name, side, 3):
        for trial in try_strokes(window, stroke.changed(device="mouse", tilt=(0.0, 0.0))):
            told += faults(trial)
    assert told == []


PAD_LINES = {
    "across": np.linspace((-20.0, 0.0), (20.0, 0.0), 60),
    "down": np.linspace((0.0, 18.0), (0.0, -18.0), 60),
    "slanting": np.linspace((-14.0, 14.0), (14.0, -14.0), 60),
    "round": 14.0 * np.stack([f(np.linspace(0.0, 4.0, 120)) for f in (np.cos, np.sin)], axis=1),
}


@pytest.mark.parametrize(
    ("pressure", "name"),
    long_but([(0.25, "bowl"), (0.5, "sphere")], product((0.25, 0.5), ("bowl", "vase", "sphere"))),
)
def test_a_pad_is_laid_down_as_it_was_drawn(name: str, pressure: float) -> None:
    mesh = load_mesh(name)
    surface, told = ClosestPoints(mesh), []
    for what, line in PAD_LINES.items():
        laid = lay_on(mesh, pad_stroke(line, pressure, np.radians(55.0)), None, None).whole()
        painter = Painter(PaintedSurface(mesh, 0.8))
        painter.replay(laid)
        way = Way(laid.contact, surface.find(laid.contact).normals)
        told += [f"{what}: {fault}" for fault in faults(Trial(0, take_mark(painter.surface), way))]
    assert told == []
