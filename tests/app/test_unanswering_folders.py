"""Named pipes and folders that do not answer do not hold the window up, by real events."""

from __future__ import annotations

import os
import threading
import time

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.files import file_dialogs
from paint3d.app.window.files.file_dialogs import NamesOnly, answers, that_exist
from tests.support.app.gestures import answer, take_file
from tests.support.app.windows import opened

DEAD = "/dead"


@pytest.fixture
def dead(monkeypatch):
    """A folder in which every look stands still until the test is over."""
    over, look = threading.Event(), file_dialogs._is_there

    def stand_still(path: str) -> bool:
        if path.startswith(DEAD):
            over.wait(600.0)
            return False
        return look(path)

    monkeypatch.setattr(file_dialogs, "_is_there", stand_still)
    monkeypatch.setattr(file_dialogs, "_PATIENCE_S", 1.0)
    yield
    over.set()


def test_files_in_a_dead_folder_are_passed_over(dead, tmp_path) -> None:
    here = tmp_path / "here.p3d"
    here.touch()
    paths = [f"{DEAD}/{k}.p3d" for k in range(8)]
    started = time.monotonic()
    assert that_exist([*paths, here, tmp_path / "gone.p3d"]) == [str(here)]
    assert time.monotonic() - started < 300.0  # not for ever
    assert answers(tmp_path / "gone.p3d")
    assert not answers(paths[0])


def test_kinds_are_told_by_names_without_opening_files(program, tmp_path) -> None:
    for name, told in (("picture", False), ("picture.png", True)):
        (tmp_path / name).write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(64))
        kind = NamesOnly().type(QtCore.QFileInfo(str(tmp_path / name)))
        assert ("PNG" in kind) is told
        assert not NamesOnly().icon(QtCore.QFileInfo(str(tmp_path / name))).isNull()


def test_a_folder_is_called_one_whatever_its_name_ends_with(program, tmp_path) -> None:
    for name in ("scans", "old.txt"):
        (tmp_path / name).mkdir()
        assert NamesOnly().type(QtCore.QFileInfo(str(tmp_path / name))) == "Folder"


def test_a_slow_folder_is_waited_for_in_any_place_of_the_list(monkeypatch) -> None:
    def look(path: str) -> bool:
        time.sleep(0.5 if path == "slow" else 0.0)
        return True

    monkeypatch.setattr(file_dialogs, "_is_there", look)
    monkeypatch.setattr(file_dialogs, "_PATIENCE_S", 20.0)
    assert that_exist(["here", "slow"]) == ["here", "slow"]


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 4.0, "xuan", drawn=False) as window:
        window.workspace.quiet = False
        window.saving.may_leave = lambda: True
        yield window


@pytest.mark.parametrize("suffix", [".p3d", ".stl"])
def test_a_named_pipe_is_refused_at_once(window, tmp_path, suffix) -> None:
    pipe = tmp_path / f"pipe{suffix}"
    os.mkfifo(pipe)
    before = window.workspace.painting.source
    answer(take_file(pipe), QtWidgets.QFileDialog)
    window.workspace.quiet = True  # the refusal is told in the line of status
    window.workspace.actions["open"].trigger()
    window.workspace.quiet = False
    assert "plain file" in str(window.workspace.error)
    assert window.workspace.painting.source is before


def test_saving_into_a_dead_folder_is_told_and_asks_again(window, dead) -> None:
    told = []

    def look_at_message(dialog: QtWidgets.QDialog) -> None:
        told.append(dialog.text())
        dialog.accept()

    def save_there(dialog: QtWidgets.QFileDialog) -> None:
        dialog.findChild(QtWidgets.QLineEdit, "fileNameEdit").setText(f"{DEAD}/a.p3d")
        answer(look_at_message, QtWidgets.QMessageBox)
        dialog.accept()
        assert dialog.isVisible()
        dialog.reject()

    answer(save_there, QtWidgets.QFileDialog)
    window.workspace.actions["save_as"].trigger()
    assert DEAD in told[0]
