"""Saving and exporting through the window: what is asked, and what is written."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model import paint_thread
from paint3d.app.model.persistence.recovery_folder import recoverable
from paint3d.app.window.files.exporting import ExportDialog
from paint3d.app.window.files.target_dialog import TargetDialog
from paint3d.app.window.playing.pictures import FilmDialog, FilmOptions
from paint3d.app.window.wording import say, say_object
from paint3d.errors import ExportError
from paint3d.files.colour_tags import icc_profile
from paint3d.files.load import load_mesh
from paint3d.files.project import painting
from paint3d.files.project.session import load_session
from tests.support.app.gestures import answer, drag, live, wait_for, when
from tests.support.app.windows import opened, seen, settled
from tests.support.full_disk import full_disk


@pytest.fixture(scope="module")
def window(program):
    """A window with a stroke on a sheet."""
    with opened(program, resolution=2.0, drawn=False) as window:
        drag(window.canvas, (0.4, 0.45), (0.6, 0.5), n=8)
        settled(window)
        yield window


@pytest.fixture(autouse=True)
def in_slots(monkeypatch: pytest.MonkeyPatch):
    """Nothing may go wrong unseen in what Qt calls."""
    raised: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda kind, error, trace: raised.append(error))
    yield
    assert raised == []


def typed(dialog: TargetDialog, name: str) -> None:
    """Type a name in place of the one that stands there, and press Enter."""
    field = dialog.findChild(QtWidgets.QLineEdit)
    while field.text() != name:  # the folder is still being read, which chooses the name again
        live(0.3)
        field.setFocus()
        field.selectAll()
        QtTest.QTest.keyClicks(field, name)
        live(0.05)
    QtTest.QTest.keyClick(field, QtCore.Qt.Key.Key_Return)


def choose(dialog: QtWidgets.QMessageBox, words: str) -> None:
    next(button for button in dialog.buttons() if button.text() == words).click()


@contextmanager
def answers(name: str, *then: Callable) -> Iterator[list[str]]:
    """Type a name into the dialog that opens next; deal with those that follow.

    Yields
    ------
    list of str
        What was asked after the name; it fills while the dialogs are open.
    """
    asked: list[str] = []
    waiting = [lambda dialog: typed(dialog, name), *then]
    met: list[QtWidgets.QWidget] = []
    over: list[bool] = []

    def look() -> None:
        if over:
            return
        QtCore.QTimer.singleShot(30, look)
        dialog = QtWidgets.QApplication.activeModalWidget()
        if not isinstance(dialog, QtWidgets.QDialog) or not dialog.isVisible():
            return
        if isinstance(dialog, QtWidgets.QProgressDialog) or dialog in met:
            return
        met.append(dialog)
        if met[1:]:
            asked.append(dialog.text() if isinstance(dialog, QtWidgets.QMessageBox) else "")
        if waiting:
            waiting.pop(0)(dialog)
            return
        for unexpected in reversed(met):
            unexpected.reject()

    QtCore.QTimer.singleShot(30, look)
    yield asked
    over.append(True)


def replace(dialog) -> None:
    choose(dialog, "Replace")


def keep(dialog) -> None:
    """Leave the file as it is, and the dialog that asked for the name."""
    choose(dialog, "Cancel")
    open_now = QtWidgets.QApplication.activeModalWidget
    when(
        lambda: open_now() not in (None, dialog) and open_now().isVisible(),
        lambda: open_now().reject(),
        "the dialog that asked for the name is in front again",
    )


def accept(dialog) -> None:
    dialog.accept()


def test_a_new_painting_is_proposed_under_a_name_that_is_free(window, tmp_path: Path) -> None:
    """A pen alone types no other one, and what was saved before is not to be replaced."""
    window.document.set_file(None)
    window.targets.folder = tmp_path
    name = said_name(window)
    for path in (tmp_path / f"{name}.p3d", tmp_path / f"{name} 2.p3d"):
        path.write_bytes(b"another painting")
    proposed: list[list[str]] = []

    def leave(dialog: TargetDialog) -> None:
        proposed.append(dialog.selectedFiles())
        dialog.reject()

    answer(leave, TargetDialog)
    window.workspace.actions["save_as"].trigger()
    assert proposed == [[str(tmp_path / f"{name} 3.p3d")]]


def said_name(window) -> str:
    """What the object is called."""
    return say_object(window.document.surface.source.name)


@pytest.mark.parametrize(
    ("action", "suffix", "more"),
    [
        ("save_as", ".p3d", 0),
        ("export", ".glb", 1),
        ("screenshot", ".png", 0),
        ("save_recording", ".jsonl", 0),
        ("turntable", ".webp", 1),
    ],
)
def test_a_name_without_its_suffix_asks_once_before_a_file_is_replaced(
    window, tmp_path: Path, action: str, suffix: str, more: int
) -> None:
    window.workspace.update_settings(
        exports={"film": {"seconds": 0.5, "rate": 4, "width": 160, "height": 120}}
    )
    window.targets.folder = tmp_path
    file = tmp_path / f"yong{suffix}"
    file.write_bytes(b"old")
    with answers("yong", keep) as asked:
        window.workspace.actions[action].trigger()
    assert len(asked) == 1
    assert file.name in asked[0]
    assert file.read_bytes() == b"old"
    with answers("yong", replace, *[accept] * more) as asked:
        window.workspace.actions[action].trigger()
    assert len(asked) == 1 + more
    assert file.stat().st_size > 500
    with answers("new", *[accept] * more) as fresh:
        window.workspace.actions[action].trigger()
    assert len(fresh) == more  # nobody is asked about a file that is not there
    assert sorted(os.listdir(tmp_path)) == [f"new{suffix}", f"yong{suffix}"]


def test_a_link_is_named_with_where_it_leads_and_stays_a_link(window, tmp_path: Path) -> None:
    real, link = tmp_path / "elsewhere" / "real.p3d", tmp_path / "link.p3d"
    real.parent.mkdir()
    real.write_bytes(b"old")
    link.symlink_to(real)
    window.targets.folder = tmp_path
    with answers("link.p3d", replace) as asked:
        window.workspace.actions["save_as"].trigger()
    assert len(asked) == 1
    assert str(real) in asked[0]
    assert link.is_symlink()
    assert len(load_session(real).strokes) == 1


def test_formats_are_listed_by_name_and_the_last_comes_first(window, tmp_path: Path) -> None:
    window.workspace.update_settings(exports={})
    window.targets.folder = tmp_path
    seen: list[list[str]] = []

    def look(dialog) -> None:
        seen.append(dialog.nameFilters())
        index = next(k for k, text in enumerate(seen[0]) if text.endswith("(*.obj)"))
        dialog.selectNameFilter(seen[0][index])
        dialog.filterSelected.emit(seen[0][index])
        answer(accept, ExportDialog)
        typed(dialog, "thing")

    answer(look)
    window.workspace.actions["export"].trigger()
    names = seen[0]
    assert "PLY (*.ply)" in names
    assert "3MF, for printers (*.3mf)" in names
    assert names[-1].startswith("Everything (")
    assert (tmp_path / "thing.obj").is_file()
    answer(lambda dialog: (seen.append([dialog.selectedNameFilter()]), dialog.reject()))
    window.workspace.actions["export"].trigger()
    assert seen[1] == ["Wavefront OBJ (*.obj)"]


@pytest.mark.usefixtures("few_pixels")
def test_of_a_flat_sheet_a_picture_to_its_edges_comes_first(program, tmp_path: Path) -> None:
    seen = []

    def look(dialog: ExportDialog) -> None:
        seen.append((dialog.shot().view, dialog.picture_size()))
        dialog.accept()

    with opened(program, "a4", 2.0, "xuan", drawn=False) as window:
        window.workspace.update_settings(exports={"format": ".obj"})
        window.targets.folder = tmp_path
        answer(lambda dialog: (answer(look, ExportDialog), typed(dialog, "sheet")))
        window.workspace.actions["export"].trigger()
        assert window.workspace.settings.exports["format"] == ".obj"
    with Image.open(tmp_path / "sheet.png") as picture:
        assert seen == [("flat", picture.size)]
        width, height = picture.size
        assert height / width == pytest.approx(297.0 / 210.0, rel=0.01)


def test_what_is_chosen_for_a_format_is_in_the_file_and_chosen_again(
    window, tmp_path: Path
) -> None:
    window.targets.folder = tmp_path

    def few(dialog: ExportDialog) -> None:
        assert "unit" not in dialog.choices
        dialog.checks["few"].setChecked(True)
        dialog.numbers["filaments"].setValue(2)
        dialog.accept()

    with answers("few.html", few):
        window.workspace.actions["export"].trigger()
    plain = tmp_path / "plain.html"
    assert window.exporting.export_to(plain)
    assert 1000 < (tmp_path / "few.html").stat().st_size < plain.stat().st_size

    def in_inches(dialog: ExportDialog) -> None:
        dialog.choices["unit"].setCurrentIndex(dialog.choices["unit"].findData("in"))
        dialog.checks["exact"].setChecked(True)
        assert not dialog.numbers["tolerance"].isEnabled()
        dialog.accept()

    with answers("inches.ply", in_inches):
        window.workspace.actions["export"].trigger()
    mesh = load_mesh(tmp_path / "inches.ply")
    width = float(mesh.vertices[:, 0].max() - mesh.vertices[:, 0].min())
    assert width == pytest.approx(200.0 / 25.4, rel=1e-3)
    with window.stage.paint_thread.paused() as document:
        assert mesh.n_vertices == document.surface.n_vertices
    seen: list[object] = []

    def again(dialog: ExportDialog) -> None:
        seen.append((dialog.choices["unit"].currentData(), dialog.checks["exact"].isChecked()))
        dialog.reject()

    with answers("other.ply", again):
        window.workspace.actions["export"].trigger()
    assert seen == [("in", True)]
    assert not (tmp_path / "other.ply").exists()


def test_a_picture_is_the_view_on_the_screen_in_the_size_that_is_asked(
    window, tmp_path: Path
) -> None:
    window.targets.folder = tmp_path
    width, height = window.canvas.pixel_size
    before = window.hand.camera

    def larger(dialog: ExportDialog) -> None:
        assert dialog.is_of_screen
        assert dialog.picture_size() == (width, height)
        dialog.size_boxes.width_box.setValue(1200)
        dialog.accept()

    for name in ("a.png", "a.jpg"):
        window.workspace.update_settings(exports={})
        with answers(name, larger):
            window.workspace.actions["export"].trigger()
        with Image.open(tmp_path / name) as picture:
            assert picture.size == (1200, round(1200 * height / width))
            assert picture.format == {"a.png": "PNG", "a.jpg": "JPEG"}[name]
            shown = np.array(picture.convert("L").resize((60, 50)), float)
    assert window.hand.camera is before
    assert window.stage.scene.size == (width, height)
    with seen(window):
        window.stage.follow()
        pixels = window.stage.picture()[::-1, :, :3]
    there = Image.fromarray(pixels).convert("L").resize((60, 50))
    assert np.abs(shown - np.array(there, float)).mean() < 3.0  # not another view


def test_the_studios_light_is_offered_too(window, tmp_path: Path) -> None:
    window.workspace.update_settings(exports={})
    window.targets.folder = tmp_path

    def in_the_studio(dialog: ExportDialog) -> None:
        dialog.choices["view"].setCurrentIndex(1)
        assert dialog.picture_size() == (1600, 1200)
        dialog.size_boxes.width_box.setValue(320)
        dialog.size_boxes.height_box.setValue(200)
        dialog.accept()

    with answers("b.png", in_the_studio):
        window.workspace.actions["export"].trigger()
    with Image.open(tmp_path / "b.png") as picture:
        assert picture.size == (320, 200)


def test_the_screen_whose_colours_a_file_has_is_chosen_and_what_does_not_fit_is_told(
    window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    window.workspace.update_settings(exports={})
    window.targets.folder = tmp_path

    def of_p3(dialog: ExportDialog) -> None:
        screens = dialog.choices["gamut"]
        assert not screens.isEnabled()  # the screen's own picture is as it is
        dialog.choices["view"].setCurrentIndex(1)
        assert screens.isEnabled()
        screens.setCurrentIndex(screens.findText("Display P3"))
        dialog.size_boxes.width_box.setValue(160)
        dialog.size_boxes.height_box.setValue(100)
        dialog.accept()

    with answers("wide.png", of_p3):
        window.workspace.actions["export"].trigger()
    with Image.open(tmp_path / "wide.png") as picture:
        assert picture.size == (160, 100)
        assert picture.info["icc_profile"] == icc_profile("p3")
    told: list[str] = []
    monkeypatch.setattr(window.workspace, "tell", lambda text, **how: told.append(text))
    assert window.exporting.export_to(tmp_path / "plain.ply")
    monkeypatch.setattr(painting, "warn_of_clipping", lambda surface, viewing: 1234)
    assert window.exporting.export_to(tmp_path / "clipped.ply")
    assert "1,234" not in told[-2]
    assert told[-1].endswith("1,234 colours do not fit in and are the nearest that do.")


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_a_film_has_the_length_size_and_rate_that_are_asked(
    window, tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    window.workspace.update_settings(exports={})
    window.targets.folder = tmp_path

    def short(dialog: FilmDialog) -> None:
        dialog.seconds.setValue(0.8)
        dialog.rate.setValue(10)
        dialog.size_boxes.width_box.setValue(200)
        dialog.accept()

    with answers(f"turn{suffix}", short):
        window.workspace.actions["turntable"].trigger()
    width, height = window.canvas.pixel_size
    with Image.open(tmp_path / f"turn{suffix}") as film:
        assert film.size == (200, round(200 * height / width))
        assert film.n_frames == 8
        film.seek(3)
        film.load()
        assert film.info["duration"] == 100
    assert window.stage.scene.size == (width, height)
    ticks: list[None] = []
    monkeypatch.setattr(window, "tick", lambda: ticks.append(None))
    wait_for(lambda: bool(ticks))  # it goes on


def test_a_film_that_is_too_long_for_its_size_is_refused(window, tmp_path: Path) -> None:
    dialog = FilmDialog(window, FilmOptions(60.0, 30.0, (1920, 1080)), (1920, 1080))
    standard = QtWidgets.QDialogButtonBox.StandardButton
    ok = dialog.findChild(QtWidgets.QDialogButtonBox).button(standard.Ok)
    assert not ok.isEnabled()
    assert "too many" in dialog.message_label.text()
    dialog.seconds.setValue(2.0)
    assert ok.isEnabled()
    told: list[str] = []
    answer(lambda box: (told.append(box.text()), box.accept()))
    assert not window.pictures.turntable_to(
        tmp_path / "a.gif", FilmOptions(60.0, 30.0, (1920, 1080))
    )
    assert "too many" in told[0]


def test_what_cannot_be_written_is_one_sentence_and_leaves_nothing(window, tmp_path: Path) -> None:
    file = tmp_path / "a.p3d"
    file.write_bytes(b"old")
    for write in (window.saving.save_to, window.exporting.export_to):
        for path in (tmp_path / "no" / "a.p3d", Path("/proc/a.p3d"), tmp_path):
            target = path / "sub.p3d" if path == tmp_path else path
            if path == tmp_path:
                target.mkdir(exist_ok=True)
            assert not write(target)
            assert isinstance(window.workspace.error, ExportError)
            assert "\n" not in str(window.workspace.error)
            assert str(target) in str(window.workspace.error)
        with full_disk(4096):
            assert not write(file)
        assert "cannot write" in str(window.workspace.error)
        assert file.read_bytes() == b"old"
    assert sorted(os.listdir(tmp_path)) == ["a.p3d", "sub.p3d"]
    live(0.1)
    assert window.saving.save_to(tmp_path / "b.p3d")


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_a_film_for_which_there_is_no_room_is_given_up_at_once(
    window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    drawn: list[int] = []
    whole = window.stage.picture_by_parts

    def counted(**how):
        drawn.append(1)
        return whole(**how)

    monkeypatch.setattr(window.stage, "picture_by_parts", counted)
    film = FilmOptions(6.0, 10.0, (160, 120))
    with full_disk(4096):
        assert not window.pictures.turntable_to(tmp_path / f"a{suffix}", film)
    assert isinstance(window.workspace.error, ExportError)
    assert "cannot write" in str(window.workspace.error)
    assert os.listdir(tmp_path) == []
    assert len(drawn) < 0.5 * film.n_pictures  # two, and those that were drawn meanwhile
    assert window.pictures.turntable_to(tmp_path / f"b{suffix}", FilmOptions(1.0, 8.0, (160, 120)))
    data = (tmp_path / f"b{suffix}").read_bytes()  # of what was kept free nothing is left
    if suffix == ".gif":
        assert data.endswith(b"\x00;")
    else:
        assert len(data) == 8 + int.from_bytes(data[4:8], "little")


def answered(words: str, found: list[str]) -> None:
    """Press the button with these words in the question that comes; what it says is kept."""

    def press(box: QtWidgets.QMessageBox) -> None:
        found.append(box.text())
        choose(box, words)

    answer(press, QtWidgets.QMessageBox)


def test_two_windows_on_one_file_know_of_each_other(window, program, tmp_path: Path) -> None:
    """The second one is told, and none replaces what the other has saved without asking."""
    path = tmp_path / "both.p3d"
    assert window.saving.save_to(path)
    with opened(program, str(path), drawn=False) as second:
        assert "both.p3d is open in another window" in second.status.message_label.text()
        drag(second.canvas, (0.4, 0.55), (0.6, 0.6), n=8)
        settled(second)
        second.workspace.actions["save"].trigger()  # the file is as it was opened: nothing is asked
        assert "Saved" in second.status.message_label.text()
        theirs = path.read_bytes()

        said: list[str] = []
        answered(say("Cancel"), said)
        window.workspace.actions["save"].trigger()
        assert path.read_bytes() == theirs
        answered(say("Replace"), said)
        window.workspace.actions["save"].trigger()
        assert path.read_bytes() != theirs
        assert len(said) == 2
        assert all("both.p3d was saved by another window" in text for text in said)
        window.workspace.actions["save"].trigger()  # it is this window's own again
        assert len(said) == 2

        answered(say("Save as…"), said)
        elsewhere = {"press": lambda dialog: typed(dialog, "second")}
        when(
            lambda: isinstance(QtWidgets.QApplication.activeModalWidget(), TargetDialog),
            lambda: elsewhere["press"](QtWidgets.QApplication.activeModalWidget()),
            "it is asked where to save",
        )
        second.workspace.actions["save"].trigger()
        assert (tmp_path / "second.p3d").exists()
        assert second.document.path.name == "second.p3d"


def test_a_file_that_is_gone_is_saved_again_without_a_question(window, tmp_path: Path) -> None:
    path = tmp_path / "gone.p3d"
    assert window.saving.save_to(path)
    path.unlink()
    window.workspace.actions["save"].trigger()
    assert path.exists()


def test_a_painting_that_is_reopened_is_not_said_to_be_open_elsewhere(window, tmp_path) -> None:
    path = tmp_path / "own.p3d"
    assert window.saving.save_to(path)
    assert window.opening.open_path(str(path), asked=True)
    assert "another window" not in window.status.message_label.text()


def test_whole_copies_are_kept_as_often_as_was_chosen_however_much_is_painted(
    program, monkeypatch
) -> None:
    """On a large wet sheet every 3 s of the painting's work wrote 155 MB."""
    with opened(program, resolution=2.0, drawn=False) as window:
        paints = window.stage.paint_thread
        paints.set_autosave_interval(1e9)
        first = paints.recovery.number

        worked = time.thread_time

        def work(document: object) -> None:
            monkeypatch.setattr(time, "thread_time", lambda: worked() + 3.2)

        paints.post(work).result(300)
        for y in (0.45, 0.55):
            drag(window.canvas, (0.4, y), (0.6, y), n=8)
            settled(window)
        assert paints.recovery.number == first
        paints.set_autosave_interval(0.1)
        drag(window.canvas, (0.4, 0.65), (0.6, 0.65), n=8)
        wait_for(lambda: paints.recovery.number > first)


@pytest.mark.skipif(os.name == "nt", reason="rights are others there")
@pytest.mark.parametrize("umask", [0o000, 0o022, 0o077])
def test_what_is_kept_is_the_users_alone_whatever_the_umask(
    program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, umask: int
) -> None:
    """Also among what an older version has left open to others."""
    state, config = tmp_path / "home" / "state", tmp_path / "home" / "config"
    monkeypatch.setenv("PAINT3D_STATE", str(state))
    monkeypatch.setenv("PAINT3D_CONFIG", str(config))
    before = os.umask(umask)
    try:
        if umask == 0o022:
            (state / "sittings").mkdir(parents=True)
        with opened(program, resolution=2.0, drawn=False) as window:
            paints = window.stage.paint_thread
            drag(window.canvas, (0.4, 0.45), (0.6, 0.5), n=8)
            settled(window)
            paints.set_autosave_interval(0.1)
            drag(window.canvas, (0.4, 0.55), (0.6, 0.55), n=8)
            wait_for(lambda: paints.recovery.number > 1)
            paints.set_autosave_interval(1e9)
            settled(window)
            window.workspace.update_settings(theme="light")
            kept = [*(state / "sittings").rglob("*"), *config.rglob("*"), state / "sittings"]
            if umask != 0o022:
                kept += [state, config]
            modes = {path.name: path.stat().st_mode & 0o777 for path in kept}
            folders = {path.name for path in kept if path.is_dir()}
    finally:
        os.umask(before)
    assert {"lock", "about.json", "settings.json"} <= set(modes)
    assert any(name.startswith("journal-") for name in modes)
    assert {name: oct(mode) for name, mode in modes.items()} == {
        name: oct(0o700 if name in folders else 0o600) for name in modes
    }


def test_what_a_full_disk_could_not_keep_is_kept_as_soon_as_there_is_room(
    program, tmp_path: Path, monkeypatch
) -> None:
    """Said in the status line; a stroke that the journal missed is in the next base."""
    with opened(program, resolution=2.0, drawn=False) as window:
        sitting = window.stage.paint_thread.recovery
        window.stage.paint_thread.set_autosave_interval(1e9)

        def full(*_: object) -> None:
            raise ExportError("a.p3dj: cannot write: No space left on device")

        with monkeypatch.context() as disk:
            disk.setattr(sitting, "append", full)
            disk.setattr(sitting, "save_base", full)
            drag(window.canvas, (0.4, 0.45), (0.6, 0.5), n=8)
            settled(window)
            wait_for(lambda: "Recovery data cannot be saved" in window.status.message_label.text())
        monkeypatch.setattr(paint_thread, "_AGAIN_S", 0.0)
        drag(window.canvas, (0.4, 0.55), (0.6, 0.6), n=8)
        settled(window)
        wait_for(lambda: "being saved again" in window.status.message_label.text())
        shutil.copytree(sitting.folder, tmp_path / "left")  # as a crash would leave it
        with window.stage.paint_thread.paused() as document:
            painted = document.surface.srgb.copy()
    (left,) = recoverable(tmp_path)
    again = left.recover().document
    assert len(again.strokes) == 2
    again.refresh()
    np.testing.assert_array_equal(again.surface.srgb, painted)
