"""Views kept by name and with the painting, the ends of zooming, and pictures in other lights."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.window.files.exporting import ExportDialog
from tests.support.app.gestures import (
    KIND,
    answer,
    live,
    mouse,
    pen_stroke,
    take_file,
    type_key,
    wait_for,
)
from tests.support.app.windows import opened, pretend_saved, settled

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier
BOTH = HELD.ControlModifier | HELD.ShiftModifier


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "bowl", 4.0, "porcelain", drawn=False) as window:
        yield window


@pytest.fixture(autouse=True)
def whole(window) -> None:
    window.hand.show_all()


def height_mm(window) -> float:
    """Of the picture at its focus."""
    camera = window.hand.camera
    away = np.linalg.norm(camera.position - camera.focus)
    return float(2.0 * away * np.tan(0.5 * camera.view_angle))


def same(one, other) -> bool:
    return all(
        np.allclose(getattr(one, name), getattr(other, name))
        for name in ("position", "focus", "up", "view_angle")
    )


def name_it(name: str):
    def fill(dialog: QtWidgets.QInputDialog) -> None:
        dialog.setTextValue(name)
        dialog.accept()

    return fill


def test_a_view_is_kept_by_name_and_comes_back_with_the_file(window, tmp_path) -> None:
    window.workspace.actions["look_left"].trigger()
    left = window.hand.camera
    answer(name_it("inside"), QtWidgets.QInputDialog)
    type_key(window.canvas, KEY.Key_B, BOTH)
    window.workspace.actions["look_top"].trigger()
    answer(name_it("inside"), QtWidgets.QInputDialog)
    type_key(window.canvas, KEY.Key_B, HELD.ControlModifier)
    assert same(window.hand.camera, left)
    window.workspace.actions["look_back"].trigger()
    back = window.hand.camera
    assert window.saving.save_to(tmp_path / "one.p3d")
    window.hand.show_all()
    assert window.opening.open_path(tmp_path / "one.p3d", asked=True)
    settled(window)
    assert same(window.hand.camera, back)
    assert same(window.views.views["inside"], left)
    pretend_saved(window.stage.paint_thread)
    document = window.document
    document.properties["view"] = {"position": [0, 0, 0], "focus": [0, 0, 0], "up": 3}
    window.views.recall_last(document)
    assert same(window.hand.camera, back)


def test_with_no_view_kept_it_is_told(window) -> None:
    window.views.views = {}
    type_key(window.canvas, KEY.Key_B, HELD.ControlModifier)
    wait_for(lambda: "No view is kept" in window.status.message_label.text())


@pytest.mark.parametrize("notches", [120, -120])
def test_the_wheel_ends_between_a_vertex_and_ten_objects(window, notches: int) -> None:
    canvas = window.canvas
    at = QtCore.QPointF(0.6 * canvas.width(), 0.55 * canvas.height())
    mouse(canvas, KIND.MouseMove, at.x(), at.y())
    for k in range(90):
        event = QtGui.QWheelEvent(
            at, canvas.mapToGlobal(at), QtCore.QPoint(), QtCore.QPoint(0, notches),
            QtCore.Qt.MouseButton.NoButton, HELD.NoModifier,
            QtCore.Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QtWidgets.QApplication.sendEvent(canvas, event)
        if k == 80:
            before = window.hand.camera
    size = float(np.linalg.norm(np.ptp(window.stage.points, axis=0)))
    assert 0.49 <= height_mm(window) <= 10.01 * size
    assert same(window.hand.camera, before)  # at the end it stays where it is


def test_f_comes_near_what_is_under_the_pointer(window) -> None:
    canvas = window.canvas
    mouse(canvas, KIND.MouseMove, 0.5 * canvas.width(), 0.6 * canvas.height())
    whole = height_mm(window)
    window.keys.tapped.emit("frame_selected")
    assert height_mm(window) < 0.45 * whole


def test_from_above_a_sheet_fills_the_picture(program) -> None:
    with opened(program, "sheet:200x200", 8.0, "xuan", drawn=False) as window:
        window.workspace.actions["look_top"].trigger()
        corners = window.hand.pixels_of(window.stage.points)
        share = np.ptp(corners, axis=0) / [window.canvas.width(), window.canvas.height()]
        assert share.max() > 0.8


@pytest.mark.usefixtures("few_pixels")
def test_a_picture_of_a_sheet_to_its_edges_has_its_shape(program, tmp_path) -> None:
    def choose(dialog: ExportDialog) -> None:
        view = dialog.choices["view"]
        view.setCurrentIndex(view.findData("flat"))
        assert dialog.picture_size() == (231, 693)
        dialog.accept()

    def name(dialog: QtWidgets.QFileDialog) -> None:
        take_file(tmp_path / "sheet.png")(dialog)
        answer(choose, ExportDialog)

    with opened(program, "sheet:60x180", 8.0, "xuan", drawn=False) as window:
        window.workspace.update_settings(exports={})
        answer(name, QtWidgets.QFileDialog)
        window.workspace.actions["export"].trigger()
        wait_for((tmp_path / "sheet.png").exists)
    with Image.open(tmp_path / "sheet.png") as picture:
        assert picture.size == (231, 693)
        pixels = np.array(picture.convert("RGB"))[2:-2, 2:-2].reshape(-1, 3)
    assert np.ptp(pixels.astype(int), axis=0).max() < 24  # paper alone, and nothing beside it


def test_a_picture_is_taken_flat_and_without_ground(window, tmp_path) -> None:
    pen_stroke(window.canvas, (0.4, 0.5), (0.6, 0.5), [0.5] * 12)
    settled(window)
    window.workspace.update_settings(exports={})

    def choose(dialog: ExportDialog) -> None:
        view, light = dialog.choices["view"], dialog.choices["light"]
        assert not light.isEnabled()
        view.setCurrentIndex(view.findData("above"))
        assert light.isEnabled()
        light.setCurrentIndex(light.findData("none"))
        dialog.checks["transparent"].setChecked(True)
        dialog.size_boxes.width_box.setValue(240)
        dialog.size_boxes.height_box.setValue(180)
        dialog.accept()

    def name(dialog: QtWidgets.QFileDialog) -> None:
        take_file(tmp_path / "bowl.png")(dialog)
        answer(choose, ExportDialog)

    answer(name, QtWidgets.QFileDialog)
    window.workspace.actions["export"].trigger()
    wait_for((tmp_path / "bowl.png").exists)
    with Image.open(tmp_path / "bowl.png") as picture:
        assert picture.mode == "RGBA"
        pixels = np.array(picture)
    assert pixels[0, 0, 3] == 0
    assert pixels[90, 120, 3] == 255
    seen = pixels[pixels[:, :, 3] == 255][:, :3]
    shares = np.unique(seen, axis=0, return_counts=True)[1] / len(seen)
    assert shares.max() > 0.5  # the porcelain is one colour without light
    live()


def test_shift_j_takes_another_light_and_j_held_turns_the_lamp(program, tmp_path) -> None:
    with opened(program, "bowl", 4.0, "porcelain") as window:
        stage, canvas = window.stage, window.canvas

        def shown() -> np.ndarray:
            wait_for(lambda: stage.is_lit)
            settled(window)
            live(0.3)
            return stage.picture()[:, :, :3].astype(int)

        studio = shown()
        type_key(canvas, KEY.Key_J, HELD.ShiftModifier)
        assert stage.light[0] == "soft"
        soft = shown()
        assert np.abs(soft - studio).max() > 20
        type_key(canvas, KEY.Key_J, HELD.ShiftModifier)
        low = shown()
        x, y = 0.5 * canvas.width(), 0.5 * canvas.height()
        mouse(canvas, KIND.MouseMove, x, y)
        QtTest.QTest.keyPress(canvas, KEY.Key_J)
        for k in range(1, 19):
            mouse(canvas, KIND.MouseMove, x + 20.0 * k, y)
        QtTest.QTest.keyRelease(canvas, KEY.Key_J)
        assert stage.light[1] == pytest.approx(np.pi, abs=0.02)
        turned = shown()
        half = canvas.width() // 2
        left, right = np.s_[:, : half - 60], np.s_[:, half + 60 :]
        gain = [turned[part].mean() - low[part].mean() for part in (left, right)]
        assert abs(gain[0] - gain[1]) > 2.0  # the lit side is the other one
        type_key(canvas, KEY.Key_J, HELD.ShiftModifier)
        even = shown()
        most = [
            np.unique(c.reshape(-1, 3), axis=0, return_counts=True)[1].max() for c in (even, low)
        ]
        assert most[0] > 5 * most[1]  # the bowl is one colour without light, whatever is behind it

        def choose(dialog: QtWidgets.QDialog) -> None:
            dialog.kind_box.setCurrentIndex(dialog.kind_box.findData("raking"))
            dialog.turn.setValue(90)
            assert stage.light == ("raking", pytest.approx(0.5 * np.pi))  # it is shown at once
            dialog.accept()

        answer(choose)
        window.workspace.actions["choose_light"].trigger()
        settled(window)
        assert window.document.properties["light"]["kind"] == "raking"
        assert window.saving.save_to(tmp_path / "lit.p3d")
        light = stage.light
        type_key(canvas, KEY.Key_J, HELD.ShiftModifier)
        assert window.opening.open_path(tmp_path / "lit.p3d", asked=True)
        assert stage.light == light
        pretend_saved(stage.paint_thread)
