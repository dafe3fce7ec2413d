"""Pigments of one's own are at hand with the next start, and their tables may have gone by then."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from paint3d.colour.pigments import load_palette
from tests.support.app.gestures import type_key, wait_for
from tests.support.app.windows import faults, opened, settled

HEAD = "name,R_400,R_550,R_700\n"
RED, DUN = "dragon blood,0.05,0.08,0.7\n", "dun,0.2,0.3,0.35\n"


@pytest.fixture
def table(tmp_path: Path) -> Iterator[Path]:
    """A table of one pigment; settings begin as they were made, and are so again."""
    before = load_settings()[0]
    save_settings(Settings())
    path = tmp_path / "mine.csv"
    path.write_text(HEAD + RED, encoding="utf-8")
    yield path
    save_settings(before)


@contextmanager
def started(program):
    """The studio as it starts anew, with what was kept."""
    with faults() as found, opened(program, resolution=4.0, settings=load_settings()[0]) as window:
        window.panels.docks["inks"].raise_()
        settled(window)
        yield window
    assert found == []


def open_table(window, path: Path, monkeypatch) -> None:
    monkeypatch.setattr(QtWidgets.QFileDialog, "getOpenFileName", lambda *_: (str(path), ""))
    button = window.findChild(QtWidgets.QPushButton, "open_pigments")
    QtTest.QTest.mouseClick(button, QtCore.Qt.MouseButton.LeftButton)


def own(window) -> list[str]:
    return window.panels.inks.dishes.names[len(load_palette()) :]


def dip_in_last(window) -> str:
    """Dip in the last dish by keys; the name of what is in the brush then."""
    dishes = window.panels.inks.dishes
    dishes.setFocus()
    for _ in dishes.names:
        type_key(dishes, QtCore.Qt.Key.Key_Right)
    type_key(dishes, QtCore.Qt.Key.Key_Return)
    settled(window)
    return window.document.painter.dipped.name


def test_a_table_is_among_the_dishes_of_the_next_start(program, table, monkeypatch) -> None:
    with started(program) as window:
        open_table(window, table, monkeypatch)
        assert own(window) == ["dragon blood"]
        assert dip_in_last(window) == "dragon blood"
    with started(program) as window:
        assert own(window) == ["dragon blood"]
        assert window.document.inks[0].name == "dragon blood"  # what was in hand is so again
        assert "mine.csv" not in window.status.told.text()


def test_a_table_that_has_changed_is_told_once_and_read_as_it_is(
    program, table, monkeypatch
) -> None:
    with started(program) as window:
        open_table(window, table, monkeypatch)
    table.write_text(HEAD + RED + DUN, encoding="utf-8")
    with started(program) as window:
        wait_for(lambda: "mine.csv: has changed" in window.status.told.text())
        assert own(window) == ["dragon blood", "dun"]
    with started(program) as window:
        assert "mine.csv" not in window.status.told.text()
        assert own(window) == ["dragon blood", "dun"]


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda path: path.unlink(), "mine.csv: is gone, and its pigments with it"),
        pytest.param(lambda path: path.write_text("name\nred\n"), "its pigments are left out",
                     marks=pytest.mark.long),
        pytest.param(lambda path: path.write_text(HEAD + RED.replace("dragon blood", "cinnabar")),
                     "'cinnabar' is called like an ink of the palette", marks=pytest.mark.long),
    ],
)  # fmt: skip
def test_a_table_that_is_gone_or_spoiled_is_one_line_and_nothing_breaks(
    program, table, monkeypatch, spoil, told
) -> None:
    with started(program) as window:
        open_table(window, table, monkeypatch)
        assert dip_in_last(window) == "dragon blood"
    whole = table.read_text(encoding="utf-8")
    spoil(table)
    with started(program) as window:
        wait_for(lambda: told in window.status.told.text())
        assert "\n" not in window.status.told.text()
        assert own(window) == []
        assert window.document.inks[0] == "pine soot"
    with started(program) as window:  # told once
        assert "mine.csv" not in window.status.told.text()
    table.write_text(whole, encoding="utf-8")  # a stick that is plugged in again
    with started(program) as window:
        assert own(window) == ["dragon blood"]
        assert "mine.csv" not in window.status.told.text()


def test_own_pigments_are_put_away_for_good(program, table, monkeypatch) -> None:
    with started(program) as window:
        open_table(window, table, monkeypatch)
        window.panels.inks.stir("dragon blood")
        window.workspace.actions["forget_pigments"].trigger()
        assert own(window) == []
        assert window.panels.inks.mixture() == {}
    with started(program) as window:
        assert own(window) == []
    assert table.is_file()


def test_settings_that_say_it_wrongly_are_refused() -> None:
    with pytest.raises(Exception, match="pigment_tables"):
        Settings(pigment_tables=["a.csv"])
    with pytest.raises(Exception, match="pigment_tables"):
        Settings(pigment_tables={"a.csv": 3})
