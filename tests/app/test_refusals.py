"""What cannot be done is said in its own words, and only those."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore

from paint3d.app.model.document import Document
from paint3d.app.window.wording import choose_language, say_error
from paint3d.errors import InputError, MeshError
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.app.gestures import drag, live, pen_stroke, type_key, wait_for
from tests.support.app.windows import faults, opened, settled
from tests.support.cases import long_but


def test_a_layer_is_refused_in_the_language_that_is_spoken() -> None:
    document = Document.new("plane", 4.0)
    document.rename_layer(0, 'it\'s the "sky"')
    document.set_locked(0)
    with pytest.raises(InputError) as locked:
        document.begin_stroke()
    choose_language("zh")
    try:
        assert say_error(locked.value) == '“it\'s the "sky"”已锁定：请解锁，或换一个图层'
    finally:
        choose_language("en")


@pytest.fixture(scope="module")
def window(program):
    with opened(program, drawn=False) as window:
        yield window


@pytest.mark.parametrize("state", ["locked", "hidden"])
def test_a_layer_that_takes_no_paint_says_why_and_nothing_else(window, state) -> None:
    command = {"locked": ("set_locked", 0), "hidden": ("set_visible", 0, False)}[state]
    back = {"locked": ("set_locked", 0, False), "hidden": ("set_visible", 0, True)}[state]
    window.workspace.post(*command)
    settled(window)
    drag(window.canvas, (0.4, 0.5), (0.6, 0.5))
    settled(window)
    wait_for(lambda: state in window.status.message_label.text())
    live(0.2)
    assert window.status.message_label.text().startswith(
        f"■  “Layer 1” is {state}; "
    )  # as the panel calls it
    assert "stroke" not in window.status.message_label.text()
    assert not len(window.document.strokes)
    window.workspace.post(*back)
    drag(window.canvas, (0.4, 0.5), (0.6, 0.5))
    settled(window)
    assert len(window.document.strokes) == 1
    assert state not in window.status.message_label.text()  # it is no longer true
    window.workspace.post("undo")
    settled(window)


def test_layers_can_be_moved_right_after_the_colours_have_changed(window) -> None:
    """What the panel shows is drawn anew with the next picture, and a hand may be quicker."""
    window.workspace.post("add_layer")
    settled(window)
    names = [layer.name for layer in window.document.layers]
    wait_for(window.panels.layers.buttons["down"].isEnabled)
    with faults() as found:
        window.workspace.actions["dark"].trigger()
        window.panels.layers.buttons["down"].click()
    settled(window)
    assert found == []
    assert [layer.name for layer in window.document.layers] == names[::-1]
    window.workspace.actions["dark"].trigger()
    for _ in range(2):
        window.workspace.post("undo")
    settled(window)


@pytest.mark.parametrize(
    ("earlier", "counted"), long_but([(0, 0), (1, 0)], [(0, 0), (0, 1), (1, 0)])
)
def test_a_copybook_counts_no_stroke_that_a_layer_refused(window, earlier, counted) -> None:
    """Nor, in its stead, one that was painted before; nor does it fail where there is none."""
    window.workspace.actions["look_top"].trigger()
    assert window.copying.layout_text("一", 60.0, True)
    ghost = window.panels.copybook.copybook.ghosts[0]
    ends = [places(window, ghost.medians[0][k]) for k in (0, -1)]
    window.copying.hide()
    for _ in range(earlier):
        drag(window.canvas, *ends)
        settled(window)
    assert window.copying.layout_text("一", 60.0, True)
    ghost = window.panels.copybook.copybook.ghosts[0]
    for _ in range(counted):
        drag(window.canvas, *ends)
        wait_for(lambda: len(ghost.strokes) == 1)
    window.workspace.post("set_locked", 0)
    drag(window.canvas, *ends)
    settled(window)
    assert "locked" in window.status.message_label.text()
    assert len(ghost.strokes) == counted
    window.workspace.post("set_locked", 0, False)
    for _ in range(earlier + counted):
        window.workspace.post("undo")
    window.copying.hide()
    settled(window)


def places(window, point) -> tuple[float, float]:
    """Where a point is on the canvas, as shares of its size."""
    box, (width, height) = window.stage.scene.screen_box(point[None]), window.stage.scene.size
    return (box[0] + box[2]) / 2 / width, 1 - (box[1] + box[3]) / 2 / height


def test_what_is_refused_names_no_option_of_the_command_line() -> None:
    with pytest.raises(MeshError, match="--unit") as caught:
        PaintedSurface(TriangleMesh(1e8 * np.eye(3), [[0, 1, 2]]), 0.1)
    assert "--" not in say_error(caught.value)
    assert "expected another unit" in say_error(caught.value)


def test_a_locked_layer_takes_no_paint_from_a_pen_nor_from_the_brush_itself(window) -> None:
    """Whatever asks for paint says so, and changes nothing: a pen, a text, the keys that dry."""
    assert window.copying.layout_text("一", 60.0, True)
    wait_for(lambda: window.document.texts)
    settled(window)
    before = window.document.surface.painted.sum()
    window.workspace.post("set_locked", 0)
    settled(window)
    steps = list(window.document.steps.done)

    def is_changed() -> bool:
        done = window.document.steps.done
        return list(done) != steps or window.document.surface.painted.sum() != before

    def by_pen() -> None:
        pen_stroke(window.canvas, (0.4, 0.5), (0.6, 0.5), [0.5] * 12)

    shift, key = QtCore.Qt.KeyboardModifier.ShiftModifier, QtCore.Qt.Key
    keys = [
        partial(type_key, window.canvas, one, shift) for one in (key.Key_T, key.Key_W, key.Key_E)
    ]
    for act in (by_pen, *keys):
        window.workspace.tell("")
        act()
        wait_for(lambda: is_changed() or "is locked" in window.status.message_label.text())
        assert "“Layer 1” is locked" in window.status.message_label.text()
        wait_for(lambda: is_changed() or not window.player.is_playing)
        settled(window)
        assert list(window.document.steps.done) == steps
        assert window.document.surface.painted.sum() == before
    window.workspace.post("set_locked", 0, False)
    type_key(window.canvas, key.Key_T, shift)
    wait_for(lambda: window.document.strokes and not window.player.is_playing)
    for _ in range(2):
        window.workspace.post("undo")
    settled(window)
