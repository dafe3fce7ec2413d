"""Tones, any colour, pigments of one's own, pick-up and the tip's reach, in the real window."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.persistence.settings import Settings, load_settings, save_settings
from paint3d.app.model.score.playing import painted
from paint3d.app.window.ink.ink_panel import DishGrid
from paint3d.app.window.ink.water_scale import MOST_WATER
from paint3d.app.window.theme import LIGHT_THEME
from paint3d.colour.inks import TONES
from paint3d.colour.pigments import WATER, load_palette
from tests.support.app.gestures import BUTTON, KIND, live, pen_stroke, type_key, wait_for
from tests.support.app.windows import faults, opened, settled

LEFT, NO_KEY, KEY = (
    QtCore.Qt.MouseButton.LeftButton,
    QtCore.Qt.KeyboardModifier.NoModifier,
    QtCore.Qt.Key,
)


@pytest.fixture(scope="module")
def window(program):
    with opened(program, drawn=False) as one:
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
        called = {"pine soot": "Burnt", "indigo": "100 %"}[ink]  # no blue is burnt
        assert inks.tones.buttons["burnt"].text() == called
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
    assert "ΔE00 0" in dialog.message_label.text()
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
    window.panels.inks.water.setValue(100)  # stirred further by hand
    assert window.panels.inks.mixture()[WATER.name] == pytest.approx(MOST_WATER)
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
            "paint3d.app.window.ink.ink_making.ask_file", lambda *_, path=path: str(path)
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


# -- pigments of one's own ---------------------------------------------------------------------


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
    kept = load_settings()[0]
    with faults() as found, opened(program, resolution=4.0, settings=kept, drawn=False) as window:
        window.panels.docks["inks"].raise_()
        settled(window)
        yield window
    assert found == []


def open_table(window, path: Path, monkeypatch) -> None:
    monkeypatch.setattr("paint3d.app.window.ink.ink_making.ask_file", lambda *_: str(path))
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
        assert "mine.csv" not in window.status.message_label.text()


def test_a_table_that_has_changed_is_told_once_and_read_as_it_is(
    program, table, monkeypatch
) -> None:
    with started(program) as window:
        open_table(window, table, monkeypatch)
    table.write_text(HEAD + RED + DUN, encoding="utf-8")
    with started(program) as window:
        wait_for(lambda: "mine.csv: has changed" in window.status.message_label.text())
        assert own(window) == ["dragon blood", "dun"]
    with started(program) as window:
        assert "mine.csv" not in window.status.message_label.text()
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
        wait_for(lambda: told in window.status.message_label.text())
        assert "\n" not in window.status.message_label.text()
        assert own(window) == []
        assert window.document.inks[0] == "pine soot"
    with started(program) as window:  # told once
        assert "mine.csv" not in window.status.message_label.text()
    table.write_text(whole, encoding="utf-8")  # a stick that is plugged in again
    with started(program) as window:
        assert own(window) == ["dragon blood"]
        assert "mine.csv" not in window.status.message_label.text()


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


# -- dishes ------------------------------------------------------------------------------------


NAMES = ["pine soot", "cinnabar", "gamboge"]


class Touched:
    """A grid of dishes, and what was asked of it."""

    def __init__(self) -> None:
        self.grid, self.asked = DishGrid(NAMES, LIGHT_THEME), []
        self.grid.taken.connect(lambda name: self.asked.append(("taken", name)))
        self.grid.stirred.connect(lambda name: self.asked.append(("stirred", name)))
        self.grid.resize(280, 120)
        self.grid.show()

    def send(self, kind, index: int, at_ms: int) -> None:
        """One event of a mouse, as Qt makes it of a finger too, with a time of its own."""
        place = self.grid.box(index).center()
        down = BUTTON.LeftButton if kind == KIND.MouseButtonPress else BUTTON.NoButton
        whole = self.grid.mapToGlobal(place)
        event = QtGui.QMouseEvent(kind, place, whole, BUTTON.LeftButton, down, NO_KEY)
        event.setTimestamp(at_ms)
        QtWidgets.QApplication.sendEvent(self.grid, event)

    def picture(self) -> bytes:
        """What is shown."""
        image = self.grid.grab().toImage().convertToFormat(QtGui.QImage.Format.Format_RGB32)
        return bytes(image.constBits())


@pytest.fixture
def touched(program):
    held = Touched()
    yield held
    held.grid.close()


def wait_long(touched: Touched) -> None:
    """Let the time pass after which a press is a long one, which is none for this one."""
    (timer,) = touched.grid.findChildren(QtCore.QTimer)
    timer.start(0)
    wait_for(lambda: not timer.isActive())


@pytest.mark.parametrize(("held_ms", "asked"), [(40, "taken"), (499, "taken"), (500, "stirred")])
@pytest.mark.parametrize("heard_late", [False, True])
def test_the_events_say_how_long_a_dish_was_pressed(touched, held_ms, asked, heard_late) -> None:
    """A busy window hears of a short press late; it is a short one."""
    touched.send(KIND.MouseButtonPress, 1, 70_000)
    if heard_late:
        wait_long(touched)
    assert touched.asked == []
    touched.send(KIND.MouseButtonRelease, 1, 70_000 + held_ms)
    assert touched.asked == [(asked, "cinnabar")]


def test_a_press_that_slides_off_asks_for_nothing(touched) -> None:
    touched.send(KIND.MouseButtonPress, 1, 0)
    touched.send(KIND.MouseButtonRelease, 2, 900)
    assert touched.asked == []


def test_it_shows_when_it_has_been_pressed_long_enough(touched) -> None:
    still = touched.picture()
    touched.send(KIND.MouseButtonPress, 0, 0)
    short = touched.picture()
    wait_long(touched)
    assert touched.picture() not in (still, short)
    touched.send(KIND.MouseButtonRelease, 0, 900)
    assert touched.picture() == short
