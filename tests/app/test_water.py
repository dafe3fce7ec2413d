"""Water in the ink: a scale even in lightness, its slider, and the key that waters the brush."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.app.window.ink.water_scale import MOST_WATER, position_of, water_at
from paint3d.app.window.previews import ink_coat
from paint3d.colour.difference import lab_from_srgb
from paint3d.colour.pigments import WATER

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from tests.support.app.gestures import KIND, live, mouse, type_key, wait_for
from tests.support.app.windows import opened, settled

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier


@pytest.mark.parametrize("ink", ["pine soot", "cinnabar", "indigo"])
def test_a_coat_becomes_lighter_by_even_steps(ink: str) -> None:
    shares = [water_at({ink: 1.0}, position) for position in np.linspace(0.0, 1.0, 9)]
    coats = [ink_coat({ink: 1.0 - water, WATER: water}) for water in shares]
    steps = np.diff(lab_from_srgb(np.array(coats) / 255.0)[:, 0])
    assert shares[0] == 0.0
    assert shares[-1] == pytest.approx(MOST_WATER)
    assert steps.min() > 0.75 * steps.mean()
    assert steps.max() < 1.25 * steps.mean()
    for position in (0.0, 0.3, 1.0):
        assert position_of({ink: 1.0}, water_at({ink: 1.0}, position)) == pytest.approx(
            position, abs=0.01
        )


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sheet:120x120", 2.0, "xuan", drawn=False) as window:
        yield window


def drag_with_v(window, pixels: float) -> None:
    canvas = window.canvas
    x, y = 0.5 * canvas.width(), 0.5 * canvas.height()
    mouse(canvas, KIND.MouseMove, x, y)
    QtTest.QTest.keyPress(canvas, KEY.Key_V)
    for k in range(11):
        mouse(canvas, KIND.MouseMove, x + pixels * k / 10, y)
    QtTest.QTest.keyRelease(canvas, KEY.Key_V)


def test_v_held_and_a_drag_water_the_brush_and_thicken_it_again(window) -> None:
    window.stage.paint_thread.post("dip", "pine soot").result(300)
    settled(window)
    type_key(window.canvas, KEY.Key_Shift)  # the window has the keyboard
    drag_with_v(window, 120.0)
    assert "Water" in window.status.message_label.text()
    wait_for(lambda: isinstance(window.document.inks[0], dict))
    settled(window)
    ink = window.document.inks[0]
    assert ink["water"] == pytest.approx(water_at({"pine soot": 1.0}, 0.4), abs=0.02)
    assert not window.document.strokes
    drag_with_v(window, -200.0)
    wait_for(lambda: "water" not in window.document.inks[0])
    live()


def test_the_sliders_middle_is_grey_and_no_black(window) -> None:
    panel = window.panels.inks
    panel.empty()
    panel.stir("pine soot")
    panel.water.setFocus()
    panel.water.setValue(49)
    QtTest.QTest.keyClick(panel.water, KEY.Key_Right)
    mixture = panel.mixture()
    light = lab_from_srgb(np.array([ink_coat(mixture)]) / 255.0)[0, 0]
    assert light == pytest.approx(44.0, abs=4.0)
    panel.empty()
