"""Tones, any colour, pigments of one's own, pick-up and the tip's reach, in the real window."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.score.playing import painted
from paint3d.app.window.ink import ink_making, ink_panel
from paint3d.app.window.wording import CHINESE
from paint3d.colour.inks import TONES
from paint3d.colour.pigments import WATER, load_palette
from tests.support.app.gestures import live, pen_stroke, type_key, wait_for
from tests.support.app.windows import opened, settled

LEFT, NO_KEY, KEY = (
    QtCore.Qt.MouseButton.LeftButton,
    QtCore.Qt.KeyboardModifier.NoModifier,
    QtCore.Qt.Key,
)


@pytest.fixture(scope="module")
def window(program):
    with opened(program) as one:
        one.panels.docks["inks"].raise_()
        live(0.1)
        yield one


def click(widget: QtWidgets.QWidget) -> None:
    QtTest.QTest.mouseClick(widget, LEFT, NO_KEY, widget.rect().center())


def held(window) -> dict[str, float]:
    """Shares of what the brush was dipped in, by name."""
    settled(window)
    dipped = window.document.painter.dipped
    dipped = dipped if isinstance(dipped, dict) else {dipped: 1.0}
    return {ink if isinstance(ink, str) else ink.name: part for ink, part in dipped.items()}


def stroke(window, row: float) -> None:
    pen_stroke(window.canvas, (0.42, row), (0.55, row), [0.1, *[0.5] * 8, 0.0])
    settled(window)


def test_the_five_tones_of_the_ink_in_hand_are_buttons(window) -> None:
    inks = window.panels.inks
    for ink in ("pine soot", "indigo"):
        inks.dishes.taken.emit(ink)
        settled(window)
        for name, tone in TONES.items():
            click(inks.tones.buttons[name])
            wanted = {ink: tone.share, WATER.name: 1.0 - tone.share}
            assert held(window) == pytest.approx({k: v for k, v in wanted.items() if v > 0.0})
    click(inks.tones.buttons["burnt"])  # and back from thin ink to thick
    assert held(window) == {"indigo": 1.0}


def test_any_colour_is_mixed_of_the_inks_there_are(window) -> None:
    click(window.findChild(QtWidgets.QPushButton, "choose_colour"))
    dialog = window.inks.dialog
    assert dialog.isVisible()
    dialog.picker.setCurrentColor(QtGui.QColor(80, 140, 150))
    assert not dialog.dip.isEnabled()
    wait_for(lambda: not dialog.is_busy)
    found = dialog.nearest
    assert found.difference < 1.0
    assert "ΔE00 0" in dialog.told.text()
    click(dialog.mix)
    assert window.panels.inks.mixture() == pytest.approx(
        {ink.name: part for ink, part in found.parts.items()}
    )
    click(dialog.dip)
    assert held(window) == pytest.approx({ink.name: part for ink, part in found.parts.items()})
    stroke(window, 0.4)
    codes = window.document.surface.srgb[window.document.surface.painted]
    near = np.abs(codes.astype(int) - found.srgb).max(axis=1)
    assert near.min() <= 12  # where about a coat lies
    window.panels.inks.water.setValue(90)  # stirred further by hand
    assert window.panels.inks.mixture()[WATER.name] == pytest.approx(0.9)
    window.panels.inks.empty()
    assert window.panels.inks.mixture() == {}
    dialog.close()


def test_a_colour_is_mixed_for_the_ground_that_is_painted_on(window) -> None:
    """The dialog's mixtures are those of a ground: another object has another."""
    click(window.findChild(QtWidgets.QPushButton, "choose_colour"))
    dialog = window.inks.dialog
    wait_for(lambda: not dialog.is_busy)
    other = "silk" if window.document.surface.material.name != "silk" else "xuan"
    while window.document.can_undo:
        window.stage.paint_thread.post("undo").result(300)
    window.standing.take_material(other)
    settled(window)
    assert window.document.surface.material.name == other
    assert window.inks.dialog is None


def test_pigments_of_ones_own_are_dishes_to_dip_in(window, tmp_path: Path, monkeypatch) -> None:
    table, bad = tmp_path / "mine.csv", tmp_path / "bad.csv"
    head = "name,R_400,R_550,R_700\n"
    table.write_text(f"{head}dragon blood,0.05,0.08,0.7\n", encoding="utf-8")
    bad.write_text(f"{head}cinnabar,0.05,0.08,0.7\n", encoding="utf-8")
    button = window.findChild(QtWidgets.QPushButton, "open_pigments")
    for path in (table, bad):
        monkeypatch.setattr(
            QtWidgets.QFileDialog, "getOpenFileName", lambda *_, path=path: (str(path), "")
        )
        click(button)
    dishes = window.panels.inks.dishes
    assert dishes.names == [*load_palette(), "dragon blood"]
    told = [label.text() for label in window.statusBar().findChildren(QtWidgets.QLabel)]
    assert any("bad.csv: 'cinnabar' is called like an ink of the palette" in t for t in told)
    dishes.setFocus()
    for _ in range(len(dishes.names)):
        type_key(dishes, KEY.Key_Right)
    assert dishes.marked == "dragon blood"
    type_key(dishes, KEY.Key_Return)
    assert held(window) == {"dragon blood": 1.0}
    assert dishes.chosen == "dragon blood"
    stroke(window, 0.5)
    red, green, _ = window.document.surface.srgb[window.document.surface.painted][-1].tolist()
    assert red > green
    click(window.panels.inks.tones.buttons["clear"])
    clear = TONES["clear"].share
    assert held(window) == pytest.approx({"dragon blood": clear, "water": 1.0 - clear})
    dishes.stirred.emit("dragon blood")
    dishes.stirred.emit("indigo")
    window.panels.inks.dip_mixture()
    assert held(window) == {"dragon blood": 0.5, "indigo": 0.5}
    again = painted(window.document.score, window.document.surface.source)
    assert np.array_equal(again.surface.srgb, window.document.surface.srgb)


def test_the_brush_takes_ink_up_again_where_it_is_asked_to(window) -> None:
    box = window.panels.inks.pickup
    box.setFocus()
    box.selectAll()
    QtTest.QTest.keyClicks(box, "0.2")
    QtTest.QTest.keyClick(box, KEY.Key_Return)
    window.panels.inks.dipped.emit("pine soot", None)
    settled(window)
    assert window.document.pickup == 0.2
    stroke(window, 0.6)
    window.panels.inks.dipped.emit("cinnabar", None)
    stroke(window, 0.6)
    surface = window.document.surface
    names = [pigment.name for pigment in surface.pigments]
    load = surface.ink.load
    assert load[names.index("pine soot")] > 0.0  # of the stroke below
    again = painted(window.document.score, surface.source)
    assert again.pickup == 0.2
    assert np.array_equal(again.surface.srgb, surface.srgb)
    window.workspace.post("set_pickup", 0.0)
    window.canvas.setFocus()
    settled(window)
    wait_for(lambda: box.value() == 0.0)


def test_the_tip_is_dipped_as_far_as_it_is_asked(window) -> None:
    inks = window.panels.inks
    inks.tip_only.setChecked(False)
    inks.dishes.taken.emit("gamboge")
    inks.tip_only.setChecked(True)
    inks.reach.setValue(60)
    inks.dishes.taken.emit("indigo")
    settled(window)
    dips = window.document.painter.dips
    assert [(str(ink), reach) for ink, reach in dips] == [("gamboge", None), ("indigo", 0.6)]
    surface = window.document.surface
    column = [pigment.name for pigment in surface.pigments].index("indigo")
    assert np.count_nonzero(surface.ink.reservoirs[:, column]) in (7, 8)  # of twelve
    inks.tip_only.setChecked(False)


def test_all_that_is_said_of_inks_is_said_in_chinese() -> None:
    texts = set()
    for module in (ink_making, ink_panel):
        source = Path(module.__file__).read_text(encoding="utf-8")
        texts |= set(re.findall(r'say\("([^"]+)"', source))
        texts |= set(re.findall(r'_button\("([^"]+)"', source))
    assert {text for text in texts if "." not in text and text not in CHINESE} == set()
    assert {name.capitalize() for name in TONES} <= set(CHINESE)
