"""The studio in a real window on a real display, by mouse, pen and keys."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import weakref
from concurrent.futures import CancelledError
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from paint3d.bench.start import wait_for as first_line
from paint3d.cli.main import main

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtWidgets

import paint3d
from paint3d.app.model.input.devices import Feeling
from paint3d.app.model.persistence.recovery_folder import recoverable
from paint3d.app.window import garbage
from paint3d.app.window.hand.device_input import DeviceInput, carried_camera
from paint3d.app.window.playing.pictures import FilmOptions
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language
from paint3d.core.quaternion import rotate
from paint3d.device.sample import StylusReading
from paint3d.errors import Paint3DError
from paint3d.files.load import load_mesh
from paint3d.files.project.session import load_session
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.pose.steering import ObjectPose
from paint3d.view.camera import Camera
from tests.support.app.gestures import (
    ALT,
    BUTTON,
    KIND,
    answer,
    answer_bar,
    drag,
    live,
    mouse,
    pen_stroke,
    wait_for,
)
from tests.support.app.windows import opened, pretend_saved, seen, settled

ROOT = Path(__file__).parents[2]
PAINTING = """
import sys
from paint3d.app.window.start import make_program
from paint3d.app.window.studio import StudioWindow
from paint3d.files.project.journal import read_events
from tests.support.app.gestures import drag, live, wait_for
from tests.support.app.windows import SMALL, draw_little

def kept():
    n, found = 0, 0  # strokes, and samples of the last; between these time passes for the ink
    (journal,) = window.stage.paint_thread.recovery.folder.glob("journal-1.*")
    for event in read_events(journal)[1]:
        if not isinstance(event, dict):
            found += len(event)
        elif event["do"] == "begin_stroke":
            n, found = n + 1, 0
    return n, found

draw_little()
window = StudioWindow(make_program())
window.resize(*SMALL)
window.show()
window.opening.open_path("plane", 1.5, "xuan", asked=True)
live(0.3)
drag(window.canvas, (0.35, 0.5), (0.6, 0.5))
drag(window.canvas, (0.5, 0.35), (0.5, 0.6), release=False)
wait_for(lambda: kept() >= (2, 10))
print("painting", flush=True)
while True:
    live(1.0)
"""


@pytest.fixture(scope="module")
def window(program):
    """A window with a sheet in it."""
    with opened(program, drawn=False) as window:
        yield window


@pytest.fixture(scope="module")
def at_first(window) -> tuple:
    """The brush and the ink in hand when it was opened."""
    return window.document.painter.brush, window.document.inks[0]


@pytest.fixture
def sheet(window, at_first):
    """Nothing painted, and brush and ink as at first, whatever the tests before did."""
    assert window.opening.open_path("plane", 1.5, "xuan", asked=True)
    window.workspace.post("set_brush", at_first[0])
    window.workspace.post("dip", at_first[1])
    wait_for(lambda: window.stage.is_lit)
    settled(window)
    return window


@pytest.fixture
def painted_once(sheet):
    """A sheet with one stroke."""
    drag(sheet.canvas, (0.35, 0.45), (0.6, 0.45))
    settled(sheet)
    return sheet


def choose(window, name: str) -> None:
    """Choose from a menu what can be chosen, or soon can."""
    action = window.workspace.actions[name]
    wait_for(action.isEnabled)
    action.trigger()
    settled(window)


def painted(window) -> int:
    """How many vertices have paint."""
    with window.stage.paint_thread.paused() as document:
        return int(document.surface.painted.sum())


def picture(window) -> np.ndarray:
    window.stage.hide_brush()
    with seen(window):
        window.stage.follow()
        return window.stage.picture(fine=False)[..., :3].astype(int)


def test_a_mouse_paints_and_the_picture_shows_it(sheet) -> None:
    window = sheet
    before = picture(window)
    drag(window.canvas, (0.35, 0.45), (0.6, 0.45))
    settled(window)
    n = painted(window)
    assert n > 50
    darker = (before - picture(window)).sum(axis=2) > 100
    assert 100 < darker.sum() < 0.2 * darker.size
    ys = np.flatnonzero(darker.any(axis=1)) / len(darker)  # rows count from the bottom
    assert abs(0.55 - ys.mean()) < 0.06
    choose(window, "undo")
    assert painted(window) == 0
    assert np.abs(before - picture(window)).sum(axis=2).max() < 30
    choose(window, "redo")
    assert painted(window) == n


def test_a_pens_pressure_widens_the_stroke(sheet) -> None:
    window = sheet
    counts = []
    for row, pressure in ((0.4, 0.15), (0.6, 0.8)):
        before = painted(window)
        ramp = np.concatenate([[0.05], np.full(12, pressure), [0.0]])
        pen_stroke(window.canvas, (0.4, row), (0.55, row), ramp, tilt=(10.0, 5.0))
        settled(window)
        counts.append(painted(window) - before)
    assert counts[1] > 1.5 * counts[0] > 0
    pressures = [s.pressure for s in window.document.strokes[-1].samples]
    assert max(pressures) == pytest.approx(0.8, abs=1e-3)


def test_alt_or_another_button_turns_instead_of_painting(window) -> None:
    choose(window, "frame_all")  # the panels may have taken room since it was opened
    n, camera = painted(window), window.hand.camera
    drag(window.canvas, (0.5, 0.5), (0.6, 0.5), keys=ALT)
    drag(window.canvas, (0.5, 0.5), (0.5, 0.45), button=BUTTON.MiddleButton)
    settled(window)
    turned = window.hand.camera
    assert painted(window) == n
    assert np.linalg.norm(turned.position - camera.position) > 10.0
    far = np.linalg.norm(turned.position - turned.focus)
    assert far == pytest.approx(np.linalg.norm(camera.position - camera.focus))
    choose(window, "frame_all")
    assert np.allclose(window.hand.camera.position, camera.position)


def test_keys_and_panels_reach_the_painting(sheet) -> None:
    window = sheet
    length = window.document.painter.brush.length_mm
    choose(window, "larger")
    assert window.document.painter.brush.length_mm > length
    window.panels.inks.dishes.taken.emit("azurite")
    settled(window)
    assert window.document.inks[0] == "azurite"
    window.panels.inks.stir("cinnabar")
    window.panels.inks.stir("gamboge")
    window.panels.inks.water.setValue(50)
    mixture = window.panels.inks.mixture()
    assert 0.5 < mixture["water"] < 0.95
    assert mixture["cinnabar"] == mixture["gamboge"] == pytest.approx(0.5 - 0.5 * mixture["water"])
    window.panels.layers.buttons["plus"].click()
    settled(window)
    assert len(window.document.layers) == 2
    wait_for(lambda: window.panels.layers.list.count() == 2)
    choose(window, "swap_inks")
    assert window.document.inks[0] != "azurite"


def test_history_goes_back_and_forth(window) -> None:
    while len(window.document.strokes) < 3:
        down = 0.3 + 0.1 * len(window.document.strokes)
        drag(window.canvas, (0.35, down), (0.6, down))
        settled(window)
    wait_for(lambda: window.panels.history.slider.maximum() >= 3)
    n, there = painted(window), len(window.document.strokes)
    window.panels.history.slider.setValue(1)
    settled(window)
    assert len(window.document.strokes) == 1
    assert painted(window) < n
    window.panels.history.slider.setValue(there)
    settled(window)
    assert painted(window) == n


def test_a_copybook_is_painted_over_and_judged(window) -> None:
    assert window.copying.layout_text("一", 60.0, True)
    ghost = window.panels.copybook.copybook.ghosts[0]
    back = window.hand.camera
    window.workspace.actions["look_top"].trigger()
    boxes = [window.stage.scene.screen_box(ghost.medians[0][k][None]) for k in (0, -1)]
    width, height = window.stage.scene.size
    ends = [((b[0] + b[2]) / 2 / width, 1 - (b[1] + b[3]) / 2 / height) for b in boxes]
    drag(window.canvas, *ends)
    settled(window)
    wait_for(lambda: window.panels.copybook.percent(0) is not None)
    assert 5.0 < window.panels.copybook.percent(0) <= 100.0
    window.copying.hide()
    assert window.panels.copybook.list.count() == 0
    window.hand.look(back)


def test_a_recording_is_replayed_at_the_speed_that_is_asked_for(painted_once) -> None:
    window = painted_once
    stroke = window.document.strokes[0]
    there, n = len(window.document.strokes), len(stroke.samples)
    window.player.play(stroke.samples, 1e-3)
    live(0.05)
    assert window.player.is_playing
    window.player.stop()
    settled(window)
    again = window.document.strokes[there]
    assert 0 < len(again.samples) < n
    window.player.play(stroke.samples, None)
    wait_for(lambda: not window.player.is_playing)
    assert len(window.document.strokes[there + 1].samples) == n
    choose(window, "undo")
    choose(window, "undo")


@pytest.mark.parametrize("by", ["mouse", "stylus"])
def test_a_stroke_by_hand_ends_a_replay_and_is_one_of_its_own(painted_once, by: str) -> None:
    """It would be painted into the stroke of the recording, and the rest of that be refused."""
    window = painted_once
    stroke = window.document.strokes[0]
    there, before = len(window.document.strokes), window.stage.paint_thread.n_painted
    window.player.play(stroke.samples, 0.1)
    wait_for(lambda: window.stage.paint_thread.n_painted > before + 2)
    if by == "mouse":
        drag(window.canvas, (0.4, 0.6), (0.6, 0.6), n=6)
    else:
        readings = readings_along_a_line()
        window.both_hands = DeviceInput(window.workspace, window.panels.devices, Devices(readings))
        wait_for(lambda: len(window.document.strokes) == there + 2)
        window.both_hands.close()
        window.both_hands = DeviceInput(window.workspace, window.panels.devices)
    assert not window.player.is_playing
    assert "replay was stopped" in window.status.message_label.text()
    settled(window)
    replayed, own = window.document.strokes[there:]
    assert len(replayed.samples) < len(stroke.samples)
    places = np.array([sample.position[1] for sample in own.samples])
    old = np.array([sample.position[1] for sample in stroke.samples])
    assert not ((places > old.min()) & (places < old.max())).any()
    choose(window, "undo")
    choose(window, "undo")


class Devices:
    """A stylus that is read again and again; no other device."""

    failures: ClassVar[dict[str, str]] = {}

    def __init__(self, readings) -> None:
        self.readings = list(readings)

    def nodes(self) -> list:
        return []

    mice = styli = take_mouse = nodes

    def take_stylus(self) -> list:
        taken, self.readings = self.readings[:5], self.readings[5:]
        return taken

    def set_deflection(self, deflection) -> None:
        pass

    def stop(self) -> None:
        self.readings = []


class Felt(Devices):
    """A haptic stylus that pushes back with 2 N."""

    last_force = np.array([0.0, 0.0, 2.0])
    settings = None

    def take(self) -> list:
        return self.take_stylus()

    def publish(self, object_pose=None) -> None:
        self.object_pose = object_pose

    def is_running(self) -> bool:
        return True


def readings_along_a_line() -> list[StylusReading]:
    """Of a stylus over the sheet, from now on."""
    now, upright = time.monotonic_ns(), np.array([1.0, 0.0, 0.0, 0.0])
    return [
        StylusReading(
            now + 4_000_000 * k,
            np.array([-40.0 + 2.0 * k, 60.0, 35.0]),
            upright,
            0.0 if k in (0, 29) else 0.4,
        )
        for k in range(30)
    ]


@pytest.mark.parametrize("haptic", [False, True])
def test_a_stylus_paints_through_the_desk(painted_once, haptic: bool) -> None:
    window, readings = painted_once, readings_along_a_line()
    settled(window)
    n, there = painted(window), len(window.document.strokes)
    workspace, panel = window.workspace, window.panels.devices
    if haptic:
        felt = Felt(readings)
        window.both_hands = DeviceInput(
            workspace, panel, Devices([]), lambda document, settings: Feeling(felt)
        )
        window.both_hands.open()
    else:
        window.both_hands = DeviceInput(workspace, panel, Devices(readings))
    wait_for(lambda: len(window.document.strokes) == there + 1)
    settled(window)
    assert painted(window) >= n > 0
    assert window.both_hands.desk.force_n == pytest.approx(2.0 if haptic else 0.0)
    window.both_hands.close()
    window.both_hands = DeviceInput(workspace, panel)


def test_the_camera_stays_in_the_world_while_the_object_is_turned() -> None:
    camera = Camera(np.array([10.0, -300.0, 80.0]), np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.4)
    half = np.sqrt(0.5)
    before = ObjectPose(np.array([5.0, 6.0, 7.0]), np.array([half, 0.0, 0.0, half]))
    after = ObjectPose(np.array([-2.0, 1.0, 3.0]), np.array([0.0, half, half, 0.0]))
    moved = carried_camera(camera, before, after)
    for name in ("position", "focus"):
        was = rotate(before.orientation, getattr(camera, name)) + before.position
        now = rotate(after.orientation, getattr(moved, name)) + after.position
        np.testing.assert_allclose(now, was, atol=1e-9)


def test_keys_that_are_held_size_the_brush_or_show_what_is_below(window) -> None:
    length = window.document.painter.brush.length_mm
    canvas = window.canvas
    window.activateWindow()
    canvas.setFocus()
    live(0.1)
    mouse(canvas, KIND.MouseMove, 300, 300)
    window.hand.held.add("size")
    mouse(canvas, KIND.MouseMove, 360, 300)
    window.hand.held.clear()
    wait_for(lambda: window.document.painter.brush.length_mm > 1.2 * length)
    camera = window.hand.camera
    window.keys.tapped.emit("frame_selected")
    assert not np.allclose(window.hand.camera.position, camera.position)
    window.hand.look(camera)


def test_refining_that_is_stopped_leaves_the_surface_as_it_was(window, program) -> None:
    other = StudioWindow(program)
    other.show()
    other.workspace.quiet = True
    assert other.opening.open_path("sphere", 0.3, asked=True)
    with other.stage.paint_thread.paused() as document:
        before = document.surface.n_vertices
    answer_bar(lambda bar: bar.canceled.emit())
    other.painting.do_refine()
    assert isinstance(other.workspace.error, CancelledError)
    with other.stage.paint_thread.paused() as document:
        assert document.surface.n_vertices == before
        assert not document.surface.paint_mesh.arrays.done.any()
        assert len(document.surface.codes) == document.surface.paint_mesh.capacity
    pretend_saved(other.stage.paint_thread)
    other.close()


def test_an_implausible_object_is_asked_for_its_unit(window, tmp_path: Path) -> None:
    small = tmp_path / "small.ply"
    ball = load_mesh("sphere")
    paint3d.export(TriangleMesh(ball.vertices * 1e-3, ball.faces), small)
    before = window.document
    answer(lambda dialog: dialog.reject())
    assert not window.opening.open_path(str(small), asked=True)
    assert window.document is before
    answer(lambda dialog: dialog.accept())  # the likeliest is chosen already
    assert window.opening.open_path(str(small), 2.0, asked=True)
    np.testing.assert_allclose(np.ptp(window.stage.points, axis=0), [150.0] * 3, rtol=0.01)
    assert window.opening.open_path("plane", 1.5, "xuan", asked=True)
    drag(window.canvas, (0.35, 0.45), (0.6, 0.45))
    settled(window)


def test_the_whole_surface_is_refined_on_demand(window) -> None:
    with window.stage.paint_thread.paused() as document:
        before = document.surface.n_vertices
    window.painting.do_refine()
    with window.stage.paint_thread.paused() as document:
        assert document.surface.n_vertices > 1.5 * before


def test_it_fits_on_a_small_screen_in_both_themes_and_languages(window, program) -> None:
    assert window.minimumSizeHint().height() <= 760
    assert window.minimumSizeHint().width() <= 1280
    with seen(window):
        window.workspace.actions["dark"].setChecked(True)
        live(0.1)
        dark = window.grab().toImage().pixelColor(5, 5).lightness()
        window.workspace.actions["dark"].setChecked(False)
        live(0.1)
        assert dark < 80 < 180 < window.grab().toImage().pixelColor(5, 5).lightness()
    choose_language("zh")
    other = StudioWindow(program)
    choose_language("en")
    titles = [action.text() for action in other.menuBar().actions()]
    assert "文件" in titles
    assert other.minimumSizeHint().height() <= 760
    other.close()


def test_save_export_and_pictures(window, tmp_path: Path) -> None:
    session, glb = tmp_path / "a.p3d", tmp_path / "a.glb"
    drag(window.canvas, (0.42, 0.5), (0.58, 0.52))
    settled(window)
    assert window.saving.save_to(session)
    assert not window.document.modified
    assert load_session(session).surface.painted.sum() == painted(window)
    assert window.exporting.export_to(glb)
    assert load_mesh(glb).n_vertices > 300
    assert not window.exporting.export_to(tmp_path / "no" / "a.glb")
    assert isinstance(window.workspace.error, Paint3DError)
    with seen(window):
        wait_for(lambda: window.stage.is_drawn)
        window.pictures.screenshot_to(tmp_path / "a.png")
        window.pictures.turntable_to(tmp_path / "a.gif", FilmOptions(0.2, 15.0))
        shot = window.grab().toImage()
    assert (tmp_path / "a.png").stat().st_size > 1000
    assert (tmp_path / "a.gif").stat().st_size > 1000
    assert len({shot.pixel(x, y) for x in range(0, 1280, 40) for y in range(0, 800, 40)}) > 20


def test_what_cannot_be_opened_is_said_and_nothing_changes(window, tmp_path: Path) -> None:
    bad = tmp_path / "bad.ply"
    bad.write_text("ply\nno\n")
    document = window.document
    assert not window.opening.open_path(str(bad), asked=True)
    assert "bad.ply" in str(window.workspace.error)
    assert window.document is document


def test_after_kill_nine_the_stroke_is_offered_back(window, places: Path, screen: str) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, "-c", PAINTING], stdout=subprocess.PIPE, text=True, env=environment
    )
    assert process.stdout.readline() == "painting\n"
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    left = recoverable()
    assert len(left) == 1
    answer(lambda dialog: dialog.defaultButton().click())
    assert window.recovery.offer()
    settled(window)
    strokes = window.document.strokes
    assert len(strokes) == 2
    assert len(strokes[1].samples) >= 10
    assert painted(window) > 80
    assert recoverable() == []


# -- garbage -----------------------------------------------------------------------------------


class _Window(QtWidgets.QWidget):
    """Of a class of our own: Qt's own ones are handed back to their thread."""


def test_closed_windows_die_in_their_own_thread(program) -> None:
    died: list[threading.Thread] = []
    for _ in range(40):
        widget = _Window()
        widget.itself = widget
        widget.destroyed.connect(
            lambda: died.append(threading.current_thread()),
            QtCore.Qt.ConnectionType.DirectConnection,
        )
        del widget

    def litter() -> None:
        for _ in range(300_000):
            cycle: list[object] = []
            cycle.append(cycle)

    beside = threading.Thread(target=litter)
    beside.start()
    beside.join()
    wait_for(lambda: len(died) == 40)
    assert set(died) == {threading.main_thread()}


def test_a_painting_that_was_let_go_of_goes_with_its_memory(
    program, monkeypatch: pytest.MonkeyPatch
) -> None:
    given_back: list[threading.Thread] = []
    monkeypatch.setattr(garbage, "_LATER_MS", 200)
    monkeypatch.setattr(
        garbage, "give_back_memory", lambda: given_back.append(threading.current_thread())
    )
    with opened(program, "plane", 4.0) as window:
        left = weakref.ref(window.document)
        wait_for(lambda: given_back)  # of what was there before
        assert window.opening.open_path("sphere", 8.0, "porcelain", asked=True)
        wait_for(lambda: left() is None and len(given_back) > 1)
    assert threading.main_thread() not in given_back  # the window does not wait for it


# -- paint3d paint where it cannot -------------------------------------------------------------


def test_without_a_display_it_says_so(tmp_path: Path) -> None:
    pytest.importorskip("PySide6", reason="PySide6 is not installed")
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    environment["XDG_CONFIG_HOME"] = str(tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "paint3d", "paint", "--quiet"],
        capture_output=True, text=True, env=environment, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.startswith("paint3d: error: there is no display")
    assert done.stderr.count("\n") == 1


def test_without_pyside_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(paint3d.app, "window", paint3d.app.window)  # a failed import replaces it
    for name in [name for name in sys.modules if name.startswith("paint3d.app.window")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "PySide6", None)
    assert main(["paint", "bowl", "--quiet"]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "PySide6" in told
    assert "paint3d[studio]" in told


@pytest.mark.parametrize(
    ("arguments", "word"), [(["no.ply"], "no.ply"), (["bowl", "--material", "jelly"], "jelly")]
)
def test_what_is_not_there_is_named(
    arguments: list[str], word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["paint", *arguments]) == 2
    told = capsys.readouterr().err
    assert told.startswith("paint3d: error:")
    assert word in told
    assert told.count("\n") == 1


def test_the_window_says_that_there_is_no_home_to_write_to(
    program, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from paint3d.app.window import start

    shown: list[StudioWindow] = []
    monkeypatch.setattr(start, "fallback_folder", lambda: tmp_path)
    monkeypatch.setattr(start, "open_first", lambda window, *_: shown.append(window))
    monkeypatch.setattr(
        type(program), "exec", lambda app: shown[0].status.message_label.text(), raising=False
    )
    told = start.run_studio(None, language="en")
    shown[0].close()
    assert told.endswith(f"settings and recovery data are kept in {tmp_path}")


def test_a_started_window_is_painted_and_then_hears_the_hand(screen: str, tmp_path: Path) -> None:
    """What `paint3d bench start` times: milestones in order, up to paint from a real stroke."""
    pytest.importorskip("PySide6", reason="PySide6 is not installed")
    program = (sys.executable, "-m", "paint3d.app.window.first_stroke", f"{time.monotonic()}")
    found = first_line((*program, "paint", "bowl"), tmp_path, home=tmp_path)
    told = [line.partition(" ") for _, line in found.lines]
    assert [what for _, _, what in told] == ["window painted", "hears the hand", "stroke painted"]
    seconds = [float(at) for at, _, _ in told]
    assert seconds == sorted(seconds)
    assert seconds[0] > 0.0
