"""What is asked before something is lost: one box for all, which leaves things as they are."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

import paint3d
from paint3d.app.window.questions import Answer, ask
from tests.support.app.gestures import answer

THREE = {"accept": "Save", "destroy": "Do not save"}


def answered(parent: QtWidgets.QWidget, press, **words) -> Answer:
    answer(press, QtWidgets.QMessageBox)
    return ask(parent, "Keep <b>it</b>.p3d?", **words)


def press_key(key: QtCore.Qt.Key):
    return lambda box: QtTest.QTest.keyClick(box, key)


def press_words(words: str):
    return lambda box: next(b for b in box.buttons() if b.text() == words).click()


@pytest.fixture
def parent(program):
    widget = QtWidgets.QWidget()
    widget.show()
    yield widget
    widget.close()


@pytest.mark.parametrize(
    ("press", "words", "wanted"),
    [
        (press_words("Save"), THREE, Answer.AcceptRole),
        (press_words("Do not save"), THREE, Answer.DestructiveRole),
        (press_words("Cancel"), THREE, Answer.RejectRole),
        (press_key(QtCore.Qt.Key.Key_Return), THREE, Answer.AcceptRole),
        (press_key(QtCore.Qt.Key.Key_Escape), THREE, Answer.RejectRole),
        (lambda box: box.close(), THREE, Answer.RejectRole),
        (press_key(QtCore.Qt.Key.Key_Return), {"destroy": "Replace"}, Answer.RejectRole),
        (press_key(QtCore.Qt.Key.Key_Return), {"accept": "Begin anew"}, Answer.AcceptRole),
    ],
)
def test_a_question_is_answered_by_buttons_and_keys(parent, press, words, wanted) -> None:
    assert answered(parent, press, **words) is wanted


def test_a_name_is_shown_as_it_is_written(parent) -> None:
    shown: list[QtCore.Qt.TextFormat] = []

    def look(box: QtWidgets.QMessageBox) -> None:
        shown.append(box.textFormat())
        box.close()

    answered(parent, look, **THREE)
    assert shown == [QtCore.Qt.TextFormat.PlainText]


def test_there_is_one_place_that_asks() -> None:
    root = Path(paint3d.__file__).parent / "app"
    makers = [path.name for path in root.rglob("*.py") if "QMessageBox(" in path.read_text()]
    assert makers == ["questions.py"]
