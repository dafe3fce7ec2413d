"""Dips by the hand in the studio: as much as was chosen, and by itself where little is left."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.settings import load_settings
from paint3d.app.model.score.playing import painted
from paint3d.brush.spec import DipAmount
from tests.app.test_score import same_paintings
from tests.support.app.gestures import live, pen_stroke, type_key, wait_for
from tests.support.app.windows import faults, opened, settled

KEY = QtCore.Qt.Key
PRESSURES = [0.1, *[0.6] * 10, 0.0]
LITTLE = DipAmount(0.05, 1.5)


@pytest.fixture
def window(program):
    with faults() as found, opened(program, "plane", 2.5, "porcelain") as window:
        window.panels.docks["inks"].raise_()
        live(0.05)
        yield window
        window.workspace.keep(dips_by_itself=False)
    assert found == []


def choose(box, percent: float) -> None:
    """Type a share into a box."""
    box.setFocus()
    box.selectAll()
    QtTest.QTest.keyClicks(box, f"{percent:g}")
    QtTest.QTest.keyClick(box, KEY.Key_Return)


def choose_little(window) -> None:
    choose(window.panels.inks.wetted, 5.0)
    choose(window.panels.inks.fullness, 150.0)


def stroke(window, row: float) -> None:
    pen_stroke(window.canvas, (0.35, row), (0.62, row), PRESSURES)
    settled(window)


def dip_by_key(window) -> None:
    window.canvas.setFocus()
    type_key(window.canvas, KEY.Key_D)
    settled(window)


def in_hand(window) -> tuple[DipAmount, float]:
    """What dips take up, and what is held against a full brush of the preset."""
    settled(window)
    painter = window.document.painter
    return painter.amount, float(painter.surface.ink.load.sum())


@pytest.mark.parametrize("how", ["a dish", "the key"])
def test_a_dip_takes_up_as_much_as_was_chosen(window, how: str) -> None:
    full = in_hand(window)[1]
    choose_little(window)
    assert in_hand(window) == (DipAmount(), full)  # nothing is dipped by choosing
    if how == "a dish":
        window.panels.inks.dishes.taken.emit("pine soot")
    else:
        dip_by_key(window)
    amount, held = in_hand(window)
    assert amount == LITTLE
    assert held == pytest.approx(0.05 * 1.5 * full, rel=1e-6)
    window.panels.inks.dishes.taken.emit("indigo")  # and the next dip, too
    assert in_hand(window) == (LITTLE, pytest.approx(held))


def test_it_is_kept_in_score_and_session(window, tmp_path: Path) -> None:
    choose_little(window)
    dip_by_key(window)
    stroke(window, 0.4)
    again = painted(window.document.score, window.document.surface.source)
    with window.stage.paint_thread.paused() as document:
        same_paintings(document, again)
    assert again.painter.amount == LITTLE
    assert window.saving.save_to(tmp_path / "a.p3d")
    assert Document.open(tmp_path / "a.p3d").painter.amount == LITTLE
    choose(window.panels.inks.wetted, 100.0)
    assert window.opening.open_path(tmp_path / "a.p3d")
    settled(window)
    inks = window.panels.inks
    assert (inks.wetted.value(), inks.fullness.value()) == (5.0, 150.0)


def test_the_tip_is_dipped_without_an_amount(window) -> None:
    inks = window.panels.inks
    choose_little(window)
    inks.tip_only.setChecked(True)
    assert not inks.wetted.isEnabled()
    inks.dishes.taken.emit("indigo")
    assert in_hand(window)[0] == DipAmount()
    inks.tip_only.setChecked(False)
    assert inks.wetted.isEnabled()


def test_it_is_dipped_by_itself_before_a_stroke_for_which_little_is_left(window) -> None:
    choose(window.panels.inks.wetted, 1.0)
    dip_by_key(window)
    full = in_hand(window)[1]
    for row in (0.35, 0.40):
        stroke(window, row)
    assert 0.0 < in_hand(window)[1] < 0.25 * full
    stroke(window, 0.45)  # it is not wanted yet
    assert not window.document.strokes[-1].dipped
    window.panels.inks.by_itself.click()
    left = in_hand(window)[1]
    stroke(window, 0.50)
    assert window.document.strokes[-1].dipped
    assert in_hand(window)[1] > left
    assert window.document.painter.amount == DipAmount(wetted=0.01)
    with window.stage.paint_thread.paused() as document:
        same_paintings(document, painted(document.score, document.surface.source))
    assert load_settings()[0].dips_by_itself


def test_it_is_not_dipped_by_itself_while_enough_is_left_or_when_it_was_rinsed(window) -> None:
    window.panels.inks.by_itself.click()
    stroke(window, 0.35)
    stroke(window, 0.40)  # most is left of a whole dip
    assert [one.dipped for one in window.document.strokes] == [True, False]
    window.workspace.actions["rinse"].trigger()
    settled(window)
    stroke(window, 0.45)
    assert in_hand(window)[1] == 0.0
    assert not window.document.strokes[-1].dipped


def test_the_boxes_follow_dips_that_took_up_other_amounts(window) -> None:
    amount = DipAmount(0.25, 0.5)
    window.workspace.post("dip", "cinnabar", None, amount.words())
    inks = window.panels.inks
    wait_for(lambda: inks.amount() == amount)
    dip_by_key(window)
    assert in_hand(window)[0] == amount
