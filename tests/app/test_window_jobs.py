"""Work that the window waits for: a bar that moves, a Cancel that leaves things as they were."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import paint3d
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.mesh.upright import guess_up
from paint3d.view.camera import View, fit_camera
from paint3d.view.live_light import LiveLight
from paint3d.view.live_patches import LivePatches

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model.commands import COMMANDS
from paint3d.app.model.document import Document
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, Unfinished, recoverable
from paint3d.app.window import job as jobs
from paint3d.app.window import start, studio
from paint3d.app.window.files import opening
from paint3d.app.window.files.open_result import some_points
from paint3d.app.window.job import is_waiting, run_beside
from paint3d.app.window.playing.pictures import FilmOptions
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language
from paint3d.core.machine import is_locked
from paint3d.errors import ExportError
from tests.support.app.gestures import (
    answer,
    answer_bar,
    drag,
    live,
    type_key,
    wait_for,
    when,
)
from tests.support.app.hands import line
from tests.support.app.windows import SMALL, blind, close_unasked, opened, pretend_saved, settled
from tests.support.cases import long_but

LIMIT_S = 300.0  # for what comes soon where the machine is not busy


@pytest.fixture(autouse=True)
def in_slots(monkeypatch: pytest.MonkeyPatch):
    """Nothing may go wrong unseen in what Qt calls."""
    raised: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda kind, error, trace: raised.append(error))
    yield
    assert raised == []


@pytest.fixture
def empty(program):
    """A window with nothing in it."""
    window = StudioWindow(program)
    window.resize(*SMALL)
    window.show()
    window.workspace.quiet = True
    with blind(window):
        yield window
    close_unasked(window)


def leave_a_sitting() -> None:
    """Leave a painting with a second layer behind, as a crash does."""
    sitting = RecoveryFolder(Document.new("plane", 4.0))
    sitting.note({"do": "add_layer"})
    sitting.close(keep=True)


@pytest.fixture
def window(empty):
    """A window with a sheet in it."""
    assert empty.opening.open_path("plane", 2.0, "xuan", asked=True)
    return empty


@pytest.fixture
def gate():
    """What work waits for that nobody can interrupt."""
    gate = threading.Event()
    yield gate
    gate.set()


def cancel(bar: QtWidgets.QProgressDialog) -> None:
    bar.findChild(QtWidgets.QPushButton).click()


def open_dialog() -> QtWidgets.QWidget | None:
    return QtWidgets.QApplication.activeModalWidget()


def still_paints(window) -> bool:
    before = len(window.document.strokes)
    drag(window.canvas, (0.4, 0.5), (0.55, 0.5), n=6)
    settled(window)
    return len(window.document.strokes) == before + 1


@pytest.mark.parametrize("stage", ["read_mesh", "new", "open"])
def test_opening_that_cannot_be_interrupted_is_left_to_itself(
    window, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, gate: threading.Event, stage: str
) -> None:
    """Cancel comes back while the work still hangs, and what it makes later does not open."""
    file, begun, ended = tmp_path / "a.p3d", threading.Event(), threading.Event()
    assert window.saving.save_to(file)
    before = window.document

    def slow(whole):
        def waiting(*given, **named):
            begun.set()
            gate.wait(LIMIT_S)
            made = whole(*given, **named)
            ended.set()
            return made

        return waiting

    if stage == "read_mesh":
        monkeypatch.setattr(opening, "read_mesh", slow(opening.read_mesh))
    else:
        monkeypatch.setattr(Document, stage, slow(getattr(Document, stage)))

    def hangs() -> bool:  # on a busy machine there is a bar before
        return begun.is_set() and isinstance(open_dialog(), QtWidgets.QProgressDialog)

    when(hangs, lambda: cancel(open_dialog()), "a bar while it hangs")
    target = str(file) if stage == "open" else "sphere"
    assert not window.opening.open_path(target, 3.0, asked=True)
    assert not gate.is_set()
    assert isinstance(window.workspace.error, CancelledError)
    assert window.document is before
    monkeypatch.undo()
    gate.set()
    if stage == "new":
        assert ended.wait(LIMIT_S)
    live(0.3)
    assert window.document is before
    assert still_paints(window)


def test_the_bar_moves_by_itself_and_by_what_is_told(window, gate: threading.Event) -> None:
    seen: list[int] = []

    def moved(value: int) -> None:
        seen.append(value)
        if len({value for value in seen if 0 < value < 1000}) > 3:
            gate.set()

    def watch(bar) -> None:
        bar.findChild(QtWidgets.QProgressBar).valueChanged.connect(moved)

    answer_bar(watch)
    done = run_beside(window, "work", lambda progress: gate.wait(LIMIT_S))
    assert done.result()  # else it stood still
    assert seen == sorted(seen)


@pytest.mark.parametrize("form", long_but(["glb", "p3d"], ["glb", "obj", "p3d", "html"]))
def test_an_export_that_is_stopped_leaves_no_file_and_a_painting_that_goes_on(
    window, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, gate: threading.Event, form: str
) -> None:
    old = tmp_path / f"old.{form}"
    old.write_bytes(b"old")
    name = "paint3d.files.project.session.write_archive"
    if form != "p3d":
        name = f"paint3d.files.formats.{'gltf' if form == 'glb' else form}.write_{form}"
    place, function = name.rsplit(".", 1)
    module = import_module(place)
    whole = getattr(module, function)

    def slow(*given, **named) -> None:
        whole(*given, **named)
        gate.wait(LIMIT_S)

    monkeypatch.setattr(module, function, slow)
    answer_bar(cancel)
    assert not window.exporting.export_to(old)
    assert not gate.is_set()
    gate.set()
    wait_for(lambda: os.listdir(tmp_path) == [old.name])
    assert old.read_bytes() == b"old"
    assert still_paints(window)


def test_what_waits_in_the_queue_is_not_begun_after_cancel(window, gate: threading.Event) -> None:
    window.stage.paint_thread.post(lambda document: gate.wait(LIMIT_S))
    answer_bar(cancel)
    before = window.document.surface.n_vertices
    window.painting.do_refine()
    assert isinstance(window.workspace.error, CancelledError)
    gate.set()
    settled(window)
    assert window.document.surface.n_vertices == before
    live(0.1)
    assert "CancelledError" not in window.status.message_label.text()


def test_a_film_that_is_stopped_leaves_no_file_and_the_view_as_it_was(
    window, tmp_path: Path
) -> None:
    window.hand.look(replace(window.hand.camera))  # by choice: it is not fitted anew
    camera = window.hand.camera
    answer_bar(cancel)
    assert not window.pictures.turntable_to(tmp_path / "a.gif", FilmOptions(20.0, 20.0, (320, 240)))
    wait_for(lambda: os.listdir(tmp_path) == [])
    assert window.hand.camera is camera
    assert window.stage.scene.size == window.canvas.pixel_size
    np.testing.assert_array_equal(window.stage.scene.camera.position, camera.position)
    assert still_paints(window)


def test_the_bar_is_seen_before_the_window_itself_works_for_long(
    window, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs, "_SOON_MS", 1e3 * LIMIT_S)  # after that it works without
    seen: list[bool] = []

    def here() -> None:
        bar = QtWidgets.QApplication.activeModalWidget()
        seen.append(bar is not None and bar.windowHandle().isExposed())
        ended.set()

    ended = threading.Event()
    assert run_beside(window, "work", lambda progress: ended.wait(LIMIT_S), here).result()
    assert seen[0]


def test_meanwhile_the_window_takes_no_clicks_and_keys(window, gate: threading.Event) -> None:
    strokes = len(window.document.strokes)
    begun: list[str] = []
    window.workspace.actions["open"].triggered.connect(lambda: begun.append("open"))
    nested: list[bool] = []

    def meanwhile() -> None:
        assert is_waiting(window)
        key, middle = QtCore.Qt.Key, window.canvas.rect().center()
        QtTest.QTest.keyClick(window, key.Key_O, QtCore.Qt.KeyboardModifier.ControlModifier)
        QtTest.QTest.mousePress(window.canvas, QtCore.Qt.MouseButton.LeftButton, pos=middle)
        QtTest.QTest.mouseRelease(window.canvas, QtCore.Qt.MouseButton.LeftButton, pos=middle)
        nested.append(window.opening.open_path("sphere", 3.0, asked=True))
        assert not window.close()
        gate.set()

    QtCore.QTimer.singleShot(50, meanwhile)  # before the bar is there
    assert run_beside(window, "work", lambda progress: gate.wait(LIMIT_S)).result()
    live(0.1)
    assert nested == [False]
    assert begun == []
    assert not window.hand.in_stroke
    assert len(window.document.strokes) == strokes
    assert window.isVisible()


def test_meanwhile_it_takes_no_keys_that_are_held_though_it_was_left_and_come_back_to(
    window, gate: threading.Event
) -> None:
    tapped: list[str] = []
    window.keys.tapped.connect(tapped.append)
    held: list[set[str]] = []

    def meanwhile() -> None:
        for kind in (QtCore.QEvent.Type.WindowDeactivate, QtCore.QEvent.Type.WindowActivate):
            QtWidgets.QApplication.sendEvent(window, QtCore.QEvent(kind))
        QtTest.QTest.keyPress(window.canvas, QtCore.Qt.Key.Key_Space)
        held.append(set(window.hand.held))
        pad = QtCore.Qt.KeyboardModifier.KeypadModifier
        QtTest.QTest.keyClick(window.canvas, QtCore.Qt.Key.Key_7, pad)
        gate.set()

    window.activateWindow()
    wait_for(window.isActiveWindow)
    QtCore.QTimer.singleShot(50, meanwhile)  # before the bar is there
    assert run_beside(window, "work", lambda progress: gate.wait(LIMIT_S)).result()
    live(0.1)
    assert (tapped, held) == ([], [set()])
    QtTest.QTest.keyRelease(window.canvas, QtCore.Qt.Key.Key_Space)


def test_a_recovery_that_is_stopped_stays_and_is_offered_in_the_empty_window(
    empty, monkeypatch: pytest.MonkeyPatch, gate: threading.Event
) -> None:
    leave_a_sitting()
    assert len(recoverable()) == 1
    whole = Unfinished.recover

    def held(one: Unfinished):
        gate.wait(LIMIT_S)
        return whole(one)

    monkeypatch.setattr(Unfinished, "recover", lambda self, progress=None: held(self))
    answer_bar(cancel)
    assert not empty.recovery.recover(recoverable()[0])
    gate.set()
    live(0.3)
    assert empty.stage.paint_thread is None
    assert len(recoverable()) == 1
    monkeypatch.undo()
    wait_for(empty.begin_page.isVisible)
    back = next(b for b in empty.begin_page.buttons if b.text().startswith("Recover"))
    back.click()
    assert len(empty.document.layers) == 2
    wait_for(lambda: not empty.begin_page.isVisible())
    assert recoverable() == []


def test_a_recovery_that_is_stopped_at_the_start_opens_nothing_instead(
    empty, monkeypatch: pytest.MonkeyPatch, gate: threading.Event
) -> None:
    leave_a_sitting()
    monkeypatch.setattr(Unfinished, "recover", lambda *given, **named: gate.wait(LIMIT_S))

    def bring_back(box: QtWidgets.QMessageBox) -> None:
        answer_bar(cancel)
        box.defaultButton().click()

    answer(bring_back, QtWidgets.QMessageBox)
    start.open_first(empty, None, 3.0, None)
    gate.set()
    monkeypatch.undo()
    assert empty.stage.paint_thread is None
    wait_for(empty.begin_page.isVisible)
    assert any(b.text().startswith("Recover") for b in empty.begin_page.buttons)
    answer(lambda box: next(b for b in box.buttons() if b.text() == "Delete it").click())
    assert not empty.recovery.offer()
    assert recoverable() == []
    buttons = empty.begin_page.buttons
    assert not any(b.text().startswith("Recover") for b in buttons)
    assert all(b.isVisible() for b in buttons)


def test_without_an_object_the_page_asks_what_to_paint_on(empty) -> None:
    start.open_first(empty, None, None, None)
    wait_for(empty.begin_page.isVisible)
    assert empty.stage.paint_thread is None
    empty.begin_page.buttons[0].click()
    wait_for(lambda: empty.stage.paint_thread is not None)
    assert empty.document.surface.source.name == "bowl"


def test_what_is_brought_back_and_cannot_be_kept_anew_stays(
    empty, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the disk is full, what the crash left is all that there is until it is saved."""

    def full(document: Document) -> RecoveryFolder:
        raise ExportError("the disk is full")

    leave_a_sitting()
    monkeypatch.setattr(studio, "RecoveryFolder", full)
    assert empty.recovery.recover(recoverable()[0])
    assert len(empty.document.layers) == 2
    assert "the disk is full" in empty.status.message_label.text()
    (left,) = recoverable()
    left.discard()


def test_what_is_brought_back_is_nobody_elses_until_it_is_kept_anew(
    empty, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another window that has asked about it could take it up while this one made it ready."""
    leave_a_sitting()
    (left,) = recoverable()
    locked = []
    show = empty.workspace.show

    def shown(opened: object) -> bool:
        locked.append(is_locked(left.folder / "lock"))
        return show(opened)

    monkeypatch.setattr(empty.workspace, "show", shown)
    assert empty.recovery.recover(left)
    assert locked == [True]
    assert not left.folder.exists()


def test_what_is_brought_back_says_that_its_file_is_open_elsewhere(empty, tmp_path) -> None:
    """Whoever saves second is asked; here it is known before."""
    document = Document.new("plane", 4.0)
    document.save(tmp_path / "both.p3d")
    theirs = RecoveryFolder(document)
    killed = RecoveryFolder(document)
    killed.note({"do": "add_layer"})
    killed.close(keep=True)
    try:
        assert empty.recovery.recover(recoverable()[0])
    finally:
        theirs.close()
    told = empty.status.message_label.text()
    assert "Recovered" in told
    assert "both.p3d is open in another window" in told


@pytest.mark.parametrize("tongue", ["en", "zh"])
def test_what_a_damaged_journal_lost_is_told(empty, tongue: str) -> None:
    sitting = RecoveryFolder(Document.new("plane", 4.0))
    sitting.note({"do": "add_layer"})
    sitting.note({"do": "remove_layer", "with": [7]})  # there is none, and nobody was told then
    sitting.note({"do": "begin_stroke"})
    sitting.append(line((-20, 0), (20, 0)))
    sitting.close(keep=True)
    (journal,) = sitting.folder.glob("journal-1.*")
    journal.write_bytes(journal.read_bytes()[:-200])
    n_lost = recoverable()[0].recover().n_lost
    assert n_lost >= 10
    choose_language(tongue)
    try:
        assert empty.recovery.recover(recoverable()[0])
    finally:
        choose_language("en")
    words = {"en": ("Recovered", f"about {n_lost} samples", "1 steps", "layer 7")}
    words["zh"] = ("已找回", f"约有 {n_lost} 个", "有 1 步", "7")
    assert all(part in empty.status.message_label.text() for part in words[tongue])
    drag(empty.canvas, (0.4, 0.5), (0.55, 0.5), n=6)
    assert words[tongue][1] in empty.status.message_label.text()  # it stays


def test_nothing_is_said_of_what_was_refused_before_the_crash(window) -> None:
    window.workspace.post("remove_layer", 7)
    settled(window)
    drag(window.canvas, (0.4, 0.5), (0.55, 0.5), n=6)
    settled(window)
    window.stage.paint_thread.stop(keep=True)
    (left,) = recoverable()
    recovered = left.recover()
    assert recovered.refused == ()
    assert len(recovered.document.strokes) == 1
    left.discard()


@pytest.mark.parametrize("by_others", [False, True])
def test_saving_what_was_brought_back_asks_if_others_saved_there(
    empty, tmp_path: Path, by_others: bool
) -> None:
    """Since the lost window knew the file last, not since it was brought back."""
    path = tmp_path / "mine.p3d"
    document = Document.new("plane", 4.0)
    sitting = RecoveryFolder(document)
    document.save(path)
    sitting.name_file(document)
    sitting.note({"do": "add_layer"})
    sitting.close(keep=True)
    if by_others:
        Document.open(path).save()
    before, asked = path.read_bytes(), []
    assert empty.recovery.recover(recoverable()[0])

    def stay(box: QtWidgets.QMessageBox) -> None:
        asked.append(box.text())
        box.escapeButton().click()

    if by_others:
        answer(stay, QtWidgets.QMessageBox)
    empty.workspace.actions["save"].trigger()
    assert len(asked) == by_others
    assert (path.read_bytes() == before) == by_others


def test_what_was_put_off_stays_in_the_file_menu(empty) -> None:
    def later(box: QtWidgets.QMessageBox) -> None:
        next(button for button in box.buttons() if button.text() == "Not now").click()

    sitting = RecoveryFolder(Document.new("plane", 4.0))
    sitting.note({"do": "add_layer"})
    sitting.close(keep=True)
    answer(later, QtWidgets.QMessageBox)
    start.open_first(empty, "sphere", 8.0, None)
    assert empty.document.surface.source.name == "sphere"
    assert "File, Recover" in empty.status.message_label.text()
    menu = empty.commands.menus["file"]
    menu.aboutToShow.emit()
    (back,) = empty.commands.unsaved.actions()
    assert empty.commands.unsaved.isEnabled()
    assert back.text().startswith("Plane")
    empty.workspace.post("add_layer")
    empty.stage.paint_thread.post(lambda document: None).result(LIMIT_S)
    boxes: list[str] = []

    def stay(box: QtWidgets.QMessageBox) -> None:  # what is open is asked about, too
        boxes.append(box.text())
        box.escapeButton().click()

    def go_on(box: QtWidgets.QMessageBox) -> None:
        answer(stay, QtWidgets.QMessageBox)
        box.defaultButton().click()

    answer(go_on, QtWidgets.QMessageBox)
    back.trigger()
    assert len(boxes) == 1
    assert empty.document.surface.source.name == "sphere"
    pretend_saved(empty.stage.paint_thread)
    answer(lambda box: box.defaultButton().click(), QtWidgets.QMessageBox)
    back.trigger()
    assert empty.document.surface.source.name == "plane"
    menu.aboutToShow.emit()
    assert not empty.commands.unsaved.isEnabled()
    assert recoverable() == []


def test_a_first_opening_that_is_stopped_leaves_an_empty_window_that_works(
    empty, monkeypatch: pytest.MonkeyPatch, gate: threading.Event
) -> None:
    monkeypatch.setattr(opening, "read_mesh", lambda *given, **named: gate.wait(LIMIT_S))
    answer_bar(cancel)
    start.open_first(empty, "bowl", 3.0, None)
    gate.set()
    monkeypatch.undo()
    wait_for(empty.begin_page.isVisible)
    texts = [button.text() for button in empty.begin_page.buttons]
    assert texts[:3] == ["A bowl", "A sheet of paper", "Another sheet or object…"]
    assert texts[3] == "An object of your own, or a painting…"
    for name, action in empty.workspace.actions.items():
        assert action.isEnabled() == COMMANDS[name].always, name
        if not COMMANDS[name].always:
            action.trigger()
            assert not action.isChecked() or not COMMANDS[name].checkable, name
    for key in "DRXIMKFWS":
        type_key(empty.canvas, getattr(QtCore.Qt.Key, f"Key_{key}"))
    for name in ("smoothing", "brush", "panels", "dark"):
        empty.workspace.actions[name].trigger()
        empty.workspace.actions[name].trigger()
    drag(empty.canvas, (0.1, 0.1), (0.2, 0.2), n=4)
    for panel in (empty.panels.brushes, empty.panels.inks, empty.panels.copybook):
        assert not panel.isEnabled()
    empty.workspace.post("dip")
    assert empty.opening.open_path("plane", 3.0, asked=True)
    wait_for(lambda: not empty.begin_page.isVisible())
    assert still_paints(empty)
    wait_for(empty.workspace.actions["undo"].isEnabled)


def test_toggles_of_one_painting_are_not_lit_in_the_next(window) -> None:
    for name in ("mirror", "radial", "mask", "record"):
        window.workspace.actions[name].setChecked(True)
    settled(window)
    assert window.opening.open_path("plane", 3.0, asked=True)
    for name in ("mirror", "radial", "mask", "record"):
        assert not window.workspace.actions[name].isChecked()
    assert window.document.symmetry.planes == ()


def test_a_childs_reading_is_ended_by_cancel(window, tmp_path: Path) -> None:
    big = tmp_path / "big.obj"
    big.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 3_000_000)
    answer_bar(cancel)
    assert not window.opening.open_path(str(big), 3.0, asked=True)
    assert isinstance(window.workspace.error, CancelledError)
    wait_for(lambda: not _readers())
    assert still_paints(window)


def _readers() -> list[int]:
    """Processes that read a mesh for this one."""
    found = []
    for folder in Path("/proc").iterdir() if Path("/proc/self").exists() else ():
        try:
            mine = f"PPid:\t{os.getpid()}\n" in (folder / "status").read_text()
            if mine and b"paint3d.files.sandbox" in (folder / "cmdline").read_bytes():
                found.append(int(folder.name))
        except (OSError, ValueError):
            continue
    return found


# -- beside the window's thread ----------------------------------------------------------------


LONG = (ClosestPoints, LiveLight, LivePatches)  # to be made: seconds a million triangles

# A process of its own: the kernels of this one are ready. What one thread makes ready makes all
# others wait that need any kernel, and brushes of many hairs take minutes.
FIRST = """
import sys, threading
from numba.core.dispatcher import Dispatcher
from paint3d.app.window.start import make_program
from tests.support.app.gestures import BUTTON, drag, pen_stroke
from tests.support.app.windows import draw_little, opened, settled

draw_little()
make_ready, found = Dispatcher.compile, []

def tell(kernel, signature):
    if threading.current_thread() is threading.main_thread():
        found.append(kernel.py_func.__name__)
    return make_ready(kernel, signature)

Dispatcher.compile = tell
with opened(make_program(), sys.argv[1]) as window:
    canvas = window.canvas
    pen_stroke(canvas, (0.45, 0.5), (0.55, 0.55), [0.3] * 12)
    drag(canvas, (0.4, 0.4), (0.6, 0.5), BUTTON.RightButton)
    drag(canvas, (0.45, 0.55), (0.55, 0.5))
    settled(window)
    assert window.stage.draw() is not None or window.stage.frame is not None
    assert window.document.strokes
    print("in the window's thread:", *found)
"""


@pytest.mark.parametrize("name", [pytest.param("plane", marks=pytest.mark.long), "sphere"])
def test_no_kernel_is_made_ready_in_the_windows_thread(name: str, screen: str, places) -> None:
    assert screen
    assert places
    command = [sys.executable, "-c", FIRST, name]
    root = Path(__file__).parents[2]
    done = subprocess.run(command, capture_output=True, text=True, cwd=root, check=False)
    assert done.stdout.splitlines()[-1:] == ["in the window's thread:"], done.stderr[-2000:]


def test_an_object_is_examined_beside_the_window(
    program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, found = threading.main_thread(), []

    def watched(before: Callable[..., object], what: str) -> Callable[..., object]:
        def told(*args: object, **options: object) -> object:
            found.append((what, threading.current_thread() is here))
            return before(*args, **options)

        return told

    for kind in LONG:
        monkeypatch.setattr(kind, "__init__", watched(kind.__init__, kind.__name__))
    reading = sys.modules["paint3d.files.reading"]
    monkeypatch.setattr(reading, "guess_up", watched(guess_up, guess_up.__name__))
    is_solid = watched(TriangleMesh.is_solid.func, "is_solid")
    monkeypatch.setattr(TriangleMesh, "is_solid", property(is_solid))
    path = tmp_path / "ball.ply"
    paint3d.export(load_mesh("sphere"), path)
    with opened(program, str(path)):
        pass
    wanted = {kind.__name__ for kind in LONG} | {guess_up.__name__, "is_solid"}
    assert {what for what, _ in found} == wanted
    assert not any(in_window for _, in_window in found)


def test_a_camera_is_placed_as_well_by_some_of_the_points() -> None:
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(200_000, 3))
    points = 80.0 * ways / np.linalg.norm(ways, axis=1, keepdims=True) * [1.0, 0.4, 0.7]
    points = np.concatenate([points, [[0.0, 0.0, 120.0]]]).astype(np.float32)
    some = some_points(points)
    assert len(some) < 70_000
    assert np.array_equal(some.max(axis=0), points.max(axis=0))
    assert np.array_equal(some.min(axis=0), points.min(axis=0))
    for direction in rng.normal(size=(8, 3)):
        view = View(direction)
        all_of_it, by_some = (fit_camera(where, view, 1.4) for where in (points, some))
        away = np.linalg.norm(all_of_it.position - all_of_it.focus)
        assert np.linalg.norm(all_of_it.position - by_some.position) < 0.005 * away
    assert np.array_equal(some_points(points[:1000]), points[:1000])
