"""A reference picture: picked from, shown over the work and on it, kept with the painting."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.previews import ink_coat
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    answer,
    live,
    mouse,
    take_file,
    type_key,
    wait_for,
)
from tests.support.app.windows import opened, pretend_saved, settled

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier


@pytest.fixture(scope="module")
def picture(tmp_path_factory):
    """Left half red, right half blue, with a black bar in the middle."""
    pixels = np.zeros((120, 160, 3), np.uint8)
    pixels[:, :80], pixels[:, 80:] = (200, 40, 30), (30, 60, 190)
    pixels[50:70, 20:140] = 15
    file = tmp_path_factory.mktemp("pictures") / "halves.png"
    Image.fromarray(pixels).save(file)
    return file


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sheet:160x160", 4.0, "xuan") as window:
        window.workspace.actions["look_top"].trigger()
        yield window


@pytest.fixture(autouse=True)
def none_there(window) -> None:
    window.reference.close()
    settled(window)


def show(window, picture) -> None:
    answer(take_file(picture), QtWidgets.QFileDialog)
    type_key(window.canvas, KEY.Key_O, HELD.ControlModifier | HELD.ShiftModifier)
    wait_for(lambda: window.panels.reference.view.image is not None)
    settled(window)


def choose(window, place: str) -> None:
    box = window.panels.reference.place
    box.setCurrentIndex(box.findData(place))
    box.activated.emit(box.currentIndex())
    live(0.1)


def seen(window) -> np.ndarray:
    image = window.canvas.grab().toImage().convertToFormat(QtGui.QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


def test_a_click_under_the_loupe_mixes_the_colour_there(window, picture) -> None:
    show(window, picture)
    view = window.panels.reference.view
    at = QtCore.QPointF(0.3 * view.width(), 0.5 * view.height() + 40.0)
    assert view.colour_at(at) == QtGui.QColor(200, 40, 30)
    mouse(view, KIND.MouseMove, at.x(), at.y())
    ring = view.grab().toImage().pixelColor(round(at.x()), round(at.y() - 46.0))
    assert ring.red() > 150
    assert ring.blue() < 100
    QtTest.QTest.mouseClick(view, BUTTON.LeftButton, pos=at.toPoint())
    dialog = window.inks.dialog
    assert dialog.picker.currentColor() == QtGui.QColor(200, 40, 30)
    wait_for(lambda: not dialog.is_busy)
    dialog.dip.click()
    settled(window)
    dialog.close()
    red, green, blue = ink_coat(window.document.inks[0])
    assert np.abs(np.array([red, green, blue]) - [200, 40, 30]).max() < 12


def test_the_wheel_comes_nearer_and_a_drag_moves_it(window, picture) -> None:
    show(window, picture)
    view = window.panels.reference.view
    middle = QtCore.QPointF(0.5 * view.width(), 0.5 * view.height())
    before = view.place_of(middle)
    for _ in range(5):
        event = QtGui.QWheelEvent(
            middle, view.mapToGlobal(middle), QtCore.QPoint(), QtCore.QPoint(0, 120),
            BUTTON.NoButton, HELD.NoModifier, QtCore.Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QtWidgets.QApplication.sendEvent(view, event)
    left = BUTTON.LeftButton
    mouse(view, KIND.MouseButtonPress, middle.x(), middle.y(), left, left)
    mouse(view, KIND.MouseMove, middle.x() + 40.0, middle.y(), buttons=left)
    mouse(view, KIND.MouseButtonRelease, middle.x() + 40.0, middle.y(), left)
    moved = view.place_of(middle)
    assert moved.x() < before.x() - 5
    assert window.inks.dialog is None or not window.inks.dialog.isVisible()


@pytest.mark.parametrize("place", ["pinned", "laid"])
def test_it_is_seen_over_the_work_as_densely_as_chosen(window, picture, place: str) -> None:
    show(window, picture)
    live(0.3)
    bare = seen(window)
    choose(window, place)
    height, width = bare.shape[:2]
    spot = np.s_[height // 2 + 30 : height // 2 + 34, width // 2 + 30 : width // 2 + 34]
    shifts = []
    for density in (30, 90):
        window.panels.reference.opacity.setValue(density)
        live(0.1)
        shown = seen(window)[spot].mean(axis=(0, 1))
        shifts.append(bare[spot].mean(axis=(0, 1)) - shown)
    assert shifts[1][0] > 2.0 * shifts[0][0] > 20.0  # blue takes red away
    assert shifts[1][0] > shifts[1][2] + 20.0


def test_laid_it_turns_with_the_object(window, picture) -> None:
    show(window, picture)
    choose(window, "laid")
    window.panels.reference.opacity.setValue(100)
    live(0.1)

    def red() -> float:
        shown = seen(window)
        at = np.argwhere(shown[:, :, 0] - shown[:, :, 2] > 80)
        return float(at[:, 1].mean())

    before = red()
    type_key(window.canvas, KEY.Key_Right, HELD.ShiftModifier)
    settled(window)
    live(0.3)
    assert abs(red() - before) > 5.0
    window.workspace.actions["look_top"].trigger()


def test_it_is_kept_with_the_painting_and_comes_back(window, picture, tmp_path) -> None:
    show(window, picture)
    choose(window, "pinned")
    window.panels.reference.opacity.setValue(35)
    settled(window)
    document = window.document
    document.save(tmp_path / "one.p3d")
    assert Document.open(tmp_path / "one.p3d").properties["reference"]["place"] == "pinned"
    window.reference.close()
    settled(window)
    pretend_saved(window.stage.paint_thread)
    assert window.opening.open_path(tmp_path / "one.p3d", asked=True)
    settled(window)
    assert window.panels.reference.view.image is not None
    assert window.panels.reference.values() == {"place": "pinned", "opacity": 0.35, "scale": 1.0}
    pretend_saved(window.stage.paint_thread)


def test_what_is_no_picture_is_told(window, tmp_path) -> None:
    (tmp_path / "no.png").write_bytes(b"no picture")
    window.workspace.error = None
    assert not window.reference.open(tmp_path / "no.png")
    assert window.panels.reference.view.image is None


def test_it_becomes_a_copybook(window, picture) -> None:
    pytest.importorskip("skimage", reason="scikit-image is not installed")
    show(window, picture)
    asked = []
    window.copying.layout_file, before = lambda *a: asked.append(a), window.copying.layout_file
    try:
        QtTest.QTest.mouseClick(window.panels.reference.copy_button, BUTTON.LeftButton)
    finally:
        window.copying.layout_file = before
    assert asked[0][0] == str(picture)
