"""What a hand's events leave on the surface: under the pen, whole, and alike on every machine."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtWidgets

import paint3d
from paint3d.app.model.document import Document
from paint3d.app.window.hand import canvas as canvases
from paint3d.app.window.studio import StudioWindow
from paint3d.brush.bending import LOWEST_TILT, build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, trace_outline
from paint3d.brush_engine.tuft import greatest_descent
from paint3d.cli.sources import lay_on
from paint3d.core.quaternion import matrices_from_quaternions
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app import event_player
from tests.support.app.event_player import (
    DeviceEvent,
    EventRecording,
    look,
    open_for,
    pixel_of,
    settle,
    surface_of,
)
from tests.support.app.gestures import answer
from tests.support.app.hands import pad_stroke, same_vertices
from tests.support.app.marks import (
    Way,
    begins_and_goes_on,
    beyond,
    ink_per_mm,
    inked_share,
    largest_jump,
    largest_rise,
    off_the_way,
    stations,
    stray,
    strongest_spot,
    take_mark,
)
from tests.support.app.random_strokes import random_strokes
from tests.support.app.trials import (
    HALF_FOOTPRINT,
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


def lying_width(window: StudioWindow, upright: bool = False) -> float:
    """How wide the tuft lies amid the last stroke on a sheet, mm, by its lean along its bend."""
    samples, brush = window.document.strokes[-1].samples, window.document.painter.brush
    pose = samples[len(samples) // 2]
    axes = matrices_from_quaternions(np.asarray(pose.orientation))
    along, up = axes[:2, 0], axes[:2, 2]
    lean = 0.0 if upright else -float(along @ up) / np.hypot(*along)
    tilt = max(math.acos(max(lean, 0.0)), LOWEST_TILT)
    press = pose.pressure
    footprint = make_footprint(build_tuft(brush), press * brush.press_mm, tilt, pe=press)
    return 2.0 * float(footprint.half_width.max())


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
    """As wide as the tuft lies: on its belly, half as wide again, where 60 degrees lead its way."""
    chart = EventRecording.load("tilt_chart")
    open_for(window, chart.header)
    upright = upright_ink(window, chart.part(0, 1))[0]
    told = []
    for trial in try_strokes(window, chart.part(8 * row, 8 * row + 8)):
        broader = lying_width(window) / lying_width(window, upright=True)
        told += faults(trial, broader * upright)
    assert told == []


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
    ways = [
        ("one by one", 0.0),
        ("at once", 0.0),
        ("pictures", 5.0),
        ("pictures", 120.0),
        ("as recorded", 0.0),
    ]
    for how, pace in ways if ALL else ways[1:4]:
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
    assert max(rises) <= 0.07, rises  # of the width: so far paper moves the edges


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


# -- marks of others than a pen ----------------------------------------------------------------


STEP_MS = 10
SPEED_MM_S = 80.0
BY_HAND = [("bowl", "in"), pytest.param("vase", "out", marks=pytest.mark.long)]
BESIDE = 9.0  # mm: what is farther from a way belongs to another image


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
    assert window.copying.layout_text("一十", 36.0, False)
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
    while [len(ghost.strokes) for ghost in ghosts] != [1, 2] and time.monotonic() < until:
        settle(window)
    counted = [len(ghost.strokes) for ghost in ghosts]
    window.copying.hide()
    assert told == []
    assert counted == [1, 2]


def lines_on(window: StudioWindow, name: str, side: str, n: int) -> Iterator[EventRecording]:
    """Recordings of random strokes on an object, with the view they are to be played in."""
    open_for(window, {"object": name, "material": "porcelain"}, 1.0)
    return random_strokes(window, np.random.default_rng(12), n, side)


@pytest.mark.parametrize(("name", "side"), BY_HAND)
def test_a_finger_paints_under_its_point(window, monkeypatch, name: str, side: str) -> None:
    monkeypatch.setattr(window.canvas, "finger", "paint")  # by itself it turns once a pen was seen
    told = []
    for number, stroke in enumerate(lines_on(window, name, side, 3 if ALL else 2)):
        (way,) = ways_of(window, stroke)
        player_of(window).play(stroke)  # pens are played faster than a hand writes
        window.workspace.post("undo")
        settle(window)
        time.sleep(1.25)  # so long what touches is the hand that holds the pen
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
    for stroke in lines_on(window, name, side, 3 if ALL else 2):
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


# -- sharp edges -------------------------------------------------------------------------------


LENGTH_MM = 140.0
# beside an outline, at 1 mm: half its soft edge, from a vertex with paint towards a bare one as far
# as `INKED`, and half of the longest sweep
BESIDE_MM = 0.3 + 0.75 + 0.6
STEPS = [(-60, 0), (-60, 12), (-36, 12), (-36, 24), (-12, 24), (-12, 36), (60, 36), (60, 0)]
DOWN_THE_STEPS = [(-18, -12, 24), (-36, -4, 24), (-36, 2, 12), (-54, 10, 12)]
UP_THE_STEPS = [(-50, -6, 12), (-36, 0, 12), (-36, 3, 24), (-16, 14, 24)]
EDGE_STEP_MS, EDGE_SPEED_MM_S = 10, 80.0


def drawn_out(outline: Sequence[tuple[float, float]], length_mm: float = LENGTH_MM) -> TriangleMesh:
    """A bar of that cross section, (x, z) clockwise; its ends are open, its edges sharp."""
    at = np.array(outline, float)
    vertices: list[tuple[float, float, float]] = []
    faces: list[tuple[int, int, int]] = []
    for a, b in zip(at, np.roll(at, -1, axis=0), strict=True):
        for x, z in (a, b):
            vertices += [(x, -0.5 * length_mm, z), (x, 0.5 * length_mm, z)]
        k = len(vertices) - 4
        faces += [(k, k + 3, k + 1), (k, k + 2, k + 3)]
    return TriangleMesh(np.array(vertices), np.array(faces))


def over(window: StudioWindow, corners, tilt: tuple[float, float]) -> EventRecording:
    """One stroke along a line through these places on the object, mm, in the view of now."""
    line = np.array(corners, float)
    behind = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, behind[-1], round(behind[-1] / EDGE_SPEED_MM_S * 1000.0 / EDGE_STEP_MS))
    size = window.canvas.width(), window.canvas.height()
    events = []
    for k, d in enumerate((*at, at[-1])):
        place = [np.interp(d, behind, column) for column in line.T]
        pixel = np.array(pixel_of(window, place, None)) / size
        kind = "press" if k == 0 else "release" if k == len(at) else "move"
        down = kind != "release"
        events.append(
            DeviceEvent("pen", kind, tuple(pixel), 0.25 * down, tilt, 0.0, ("left",) * down,
                        time_ms=EDGE_STEP_MS * k, handled_ms=EDGE_STEP_MS * k + 3)
        )  # fmt: skip
    return EventRecording({"places": "canvas", "aspect": size[0] / size[1]}, tuple(events))


def footprint_reach(window: StudioWindow, tilt: tuple[float, float], pressure=0.25) -> float:
    """How far a footprint's ends lie from its middle if the pen leans along its bend, mm."""
    tuft = build_tuft(window.document.painter.brush)
    lean = math.atan(math.hypot(*(math.tan(math.radians(angle)) for angle in tilt)))
    angle = max(0.5 * math.pi - lean, tuft.lowest_tilt)
    reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    descent = min(pressure * tuft.full_press, greatest_descent(tuft, angle))
    n = trace_outline(tuft, descent, angle, pressure, np.empty(SCRATCH_SIZE), reach, half)
    return 0.5 * float(reach[0] - reach[n - 1])


@pytest.mark.parametrize(
    "way",
    [
        pytest.param(DOWN_THE_STEPS, id="down"),
        pytest.param(UP_THE_STEPS, id="up", marks=pytest.mark.long),
    ],
)
def test_over_steps_a_pen_paints_under_its_point_and_nowhere_else(window, tmp_path, way) -> None:
    path = tmp_path / "steps.ply"
    paint3d.export(drawn_out(STEPS), path)
    open_for(window, {"object": str(path), "material": "porcelain"}, 1.0)
    source = window.document.surface.source
    np.testing.assert_allclose(np.ptp(source.vertices, axis=0)[2], 36.0)
    lowest = source.vertices[source.faces][:, :, 2].min(axis=1)
    assert source.face_normals[np.argmax(lowest), 2] > 0.9  # it is seen from outside
    camera = window.hand.camera
    away = np.array([-1.0, -0.3, 1.0])
    middle = np.array([-36.0, 0.0, 18.0])
    seen_from = middle + 200.0 * away / np.linalg.norm(away)
    window.hand.look(replace(camera, position=seen_from, focus=middle, up=np.array([0, 0, 1.0])))
    told = []
    tilts = ((40.0, 0.0), (-40.0, 20.0), (0.0, 45.0), (20.0, -40.0), (0.0, 0.0))
    for tilt in tilts if ALL else tilts[:3]:
        for trial in try_strokes(window, over(window, way, tilt)):
            told += [f"tilt {tilt}: {fault}" for fault in faults(trial)]
            off = off_the_way(stations(trial.mark, trial.way), ends_mm=1.0)
            if off > 1.2:
                told.append(f"tilt {tilt}: in one place {off:.2f} mm off")
            far = stray(trial.mark, trial.way, 0.0)
            if far > (most := footprint_reach(window, tilt) + BESIDE_MM):
                told.append(f"tilt {tilt}: paint {far:.2f} mm from the way, at most {most:.2f}")
    assert told == []
