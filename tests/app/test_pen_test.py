"""The page to try a pen on: it says what the pen tells, and what it does not."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.input.pressure_curve import PressureCurve
from paint3d.app.window.hand.pen_test import PenTestDialog
from paint3d.app.window.theme import LIGHT_THEME
from tests.support.app.gestures import HAND, KIND, drag, pen


@pytest.fixture
def dialog(program):
    shown = PenTestDialog(None, LIGHT_THEME, PressureCurve())
    shown.show()
    yield shown
    shown.close()


def draw(pad, pressures, tilt=(0.0, 0.0)) -> None:
    HAND.begin()
    last = len(pressures) - 1
    for k, pressure in enumerate(pressures):
        kind = KIND.TabletPress if k == 0 else KIND.TabletMove
        kind = KIND.TabletRelease if k == last else kind
        pen(pad, kind, 60.0 + 8.0 * k, 120.0, pressure, tilt)
        HAND.pass_by(0.008)


def width_at(pad, x: int) -> int:
    """Pixels of a column that are inked."""
    picture = pad._picture
    field = picture.pixelColor(2, 2)
    return sum(picture.pixelColor(x, y) != field for y in range(picture.height()))


def test_a_pen_that_tells_all(dialog) -> None:
    pad, rows = dialog.pad, dialog.rows
    draw(pad, [0.1 + 0.03 * k for k in range(25)] + [0.0], (25, -32))
    assert pad.device
    assert rows["lean"].text().startswith("25°")
    assert "10.0 to 82.0 %" in rows["pressure"].text()
    assert rows["rate"].text() == "125"
    assert "tilt arrive" in dialog.message_label.text()
    assert width_at(pad, 72) < 0.5 * width_at(pad, 236)  # as wide as it presses


def test_what_it_does_not_tell_is_said(dialog) -> None:
    assert "Draw on the sheet" in dialog.message_label.text()
    draw(dialog.pad, [0.5] * 12)
    assert "Only one pressure" in dialog.message_label.text()
    draw(dialog.pad, [0.2, 0.4, 0.9, 0.0])
    assert "Tilt the pen" in dialog.message_label.text()
    assert dialog.rows["lean"].text() == "–"
    QtTest.QTest.mouseClick(dialog.pad, QtCore.Qt.MouseButton.LeftButton)
    assert "as a mouse" in dialog.message_label.text()


def test_a_new_sheet_is_empty_and_forgets(dialog) -> None:
    draw(dialog.pad, [0.2, 0.9, 0.9, 0.0], (10, 0))
    assert width_at(dialog.pad, 76)
    dialog._begin_anew()
    assert not width_at(dialog.pad, 76)
    assert dialog.rows["device"].text() == "–"
    assert not dialog.pad.leaned


def test_a_mouse_draws_too(dialog) -> None:
    drag(dialog.pad, (0.1, 0.4), (0.5, 0.4))
    assert width_at(dialog.pad, 120)
    assert dialog.rows["pressure"].text() == "none"
