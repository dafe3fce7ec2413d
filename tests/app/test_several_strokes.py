"""Several strokes chosen by a loop or by clicks, and edited as one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore

from paint3d.app.model.commands import encode_command, replay_command
from paint3d.app.window.history.stroke_editing import ShapeDialog
from paint3d.app.window.history.stroke_mark import ways_of
from paint3d.errors import Paint3DError
from tests.support.app.gestures import BUTTON, KIND, answer, mouse, type_key, wait_for
from tests.support.app.hands import paint, small_plane
from tests.support.app.windows import opened, settled

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier
LINES = (
    ((-40.0, 20.0), (-10.0, 20.0)),
    ((-40.0, 0.0), (-10.0, 0.0)),
    ((20.0, -30.0), (40.0, -30.0)),
)


@pytest.fixture(scope="module")
def window(program):
    """A sheet with three strokes, seen from above."""
    with opened(program, "sheet:160x160", 2.0, "xuan", drawn=False) as window:
        window.workspace.actions["look_top"].trigger()
        for start, end in LINES:
            lead(window, [start, end], press=True)
            settled(window)
        assert len(window.document.strokes) == 3
        window.start_edits = window.document.edits.n_done
        yield window


@pytest.fixture(autouse=True)
def as_it_was(window) -> None:
    window.editing.chooser.end()
    while window.document.edits.n_done > window.start_edits:
        window.stage.paint_thread.post("undo").result(300)
    settled(window)
    assert len(window.document.strokes) == 3


def pixel(window, x: float, y: float) -> tuple[float, float]:
    found = window.hand.pixels_of(np.array([[x, y, 0.0]]))[0]
    return float(found[0]), float(found[1])


def lead(window, corners, *, press: bool = True, pixels: bool = False, n: int = 10) -> None:
    """Lead the mouse from corner to corner, mm on the sheet, with its left button."""
    canvas = window.canvas
    at = [c if pixels else pixel(window, *c) for c in corners]
    way = [np.array(at[0])]
    for a, b in pairwise(at):
        way += [np.array(a) + (np.array(b) - np.array(a)) * k / n for k in range(1, n + 1)]
    left = BUTTON.LeftButton
    mouse(canvas, KIND.MouseMove, *way[0])
    mouse(canvas, KIND.MouseButtonPress, *way[0], left, left)
    for place in way:
        mouse(canvas, KIND.MouseMove, *place, buttons=left)
    mouse(canvas, KIND.MouseButtonRelease, *way[-1], left)


def middles(window) -> list[np.ndarray]:
    ground = window.hand.surface
    return [np.concatenate(ways_of(s, ground)).mean(axis=0) for s in window.document.strokes]


def choose_two(window) -> None:
    type_key(window.canvas, KEY.Key_Q)
    wait_for(lambda: window.editing.chooser.is_on)
    lead(window, [(-50.0, 30.0), (0.0, 30.0), (0.0, -10.0), (-50.0, -10.0), (-50.0, 28.0)])
    assert window.mark.indices == (0, 1)


def test_a_loop_and_clicks_choose_strokes(window) -> None:
    choose_two(window)
    assert "2 strokes" in window.status.message_label.text()
    bold = [k for k in range(3) if window.panels.history.list.item(k).font().bold()]
    assert bold == [0, 1]
    lead(window, [(30.0, -30.0), (30.0, -30.0)])
    assert window.mark.indices == (0, 1, 2)
    lead(window, [(-25.0, 20.0), (-25.0, 20.0)])
    assert window.mark.indices == (1, 2)
    lead(window, [(60.0, 60.0), (60.0, 60.0)])
    assert window.mark.indices == ()
    type_key(window.canvas, KEY.Key_Escape)
    assert not window.workspace.actions["choose_strokes"].isChecked()
    assert len(window.document.strokes) == 3


def test_a_drag_moves_all_and_one_undo_brings_them_back(window) -> None:
    before = middles(window)
    choose_two(window)
    lead(window, [(-25.0, 20.0), (-5.0, 30.0)])
    settled(window)
    after = middles(window)
    for k in (0, 1):
        np.testing.assert_allclose(after[k] - before[k], [20.0, 10.0, 0.0], atol=0.6)
    np.testing.assert_allclose(after[2], before[2], atol=1e-6)
    assert window.mark.indices == (0, 1)
    type_key(window.canvas, KEY.Key_Z, HELD.ControlModifier)
    wait_for(lambda: np.allclose(middles(window)[0], before[0]))


def test_grips_turn_and_scale_about_the_middle_of_all(window) -> None:
    before = middles(window)
    choose_two(window)
    grips = window.editing.chooser.grips()
    middle = np.array(pixel(window, *(0.5 * (before[0] + before[1]))[:2]))
    turn = np.array([grips["turn"].x(), grips["turn"].y()])
    arm = turn - middle
    lead(window, [turn, middle + np.array([arm[1], -arm[0]])], pixels=True)  # a quarter to the left
    settled(window)
    apart = middles(window)[0] - middles(window)[1]
    np.testing.assert_allclose(apart, [-20.0, 0.0, 0.0], atol=1.5)
    grip = window.editing.chooser.grips()["scale"]
    corner = np.array([grip.x(), grip.y()])
    brush = window.document.strokes[0].brush
    lead(window, [corner, middle + 1.5 * (corner - middle)], pixels=True)
    settled(window)
    apart = middles(window)[0] - middles(window)[1]
    np.testing.assert_allclose(apart, [-30.0, 0.0, 0.0], atol=2.0)
    assert window.document.strokes[0].brush.length_mm == pytest.approx(
        1.5 * brush.length_mm, rel=0.05
    )


def test_menu_and_keys_mirror_ink_and_delete_them(window) -> None:
    choose_two(window)
    ways = [np.concatenate(ways_of(s, window.hand.surface)) for s in window.document.strokes]
    type_key(window.canvas, KEY.Key_M, HELD.ControlModifier)
    settled(window)
    way = np.concatenate(ways_of(window.document.strokes[0], window.hand.surface))
    assert way[0, 0] == pytest.approx(ways[0][-1, 0], abs=1.5)
    assert way[-1, 0] == pytest.approx(ways[0][0, 0], abs=1.5)
    window.stage.paint_thread.post("dip", "cinnabar").result(300)
    settled(window)
    window.workspace.actions["ink_strokes"].trigger()
    settled(window)
    inks = [set(s.ink) for s in window.document.strokes]
    assert inks == [{"cinnabar"}, {"cinnabar"}, {"pine soot", "water"}]
    type_key(window.canvas, KEY.Key_Delete)
    wait_for(lambda: len(window.document.strokes) == 1)
    settled(window)


def test_numbers_move_turn_and_scale_them(window) -> None:
    before = middles(window)
    choose_two(window)

    def fill(dialog: ShapeDialog) -> None:
        dialog.right.setValue(12.0)
        dialog.scale.setValue(50.0)
        dialog.accept()

    answer(fill, ShapeDialog)
    window.workspace.actions["shape_strokes"].trigger()
    settled(window)
    after = middles(window)
    np.testing.assert_allclose(
        0.5 * (after[0] + after[1]), 0.5 * (before[0] + before[1]) + [12.0, 0.0, 0.0], atol=1.0
    )
    np.testing.assert_allclose(after[0] - after[1], [0.0, 10.0, 0.0], atol=1.0)


def test_with_none_chosen_it_says_how(window) -> None:
    window.workspace.actions["mirror_strokes"].trigger()
    wait_for(lambda: "press Q" in window.status.message_label.text())


def test_the_journal_says_an_edit_of_several_and_what_is_none_changes_nothing() -> None:
    documents = []
    for _ in range(2):
        document = small_plane()
        for y in (-5.0, 0.0, 5.0):
            paint(document, (-10.0, y), (10.0, y))
        documents.append(document)
    edit = {"do": "move", "along": [3.0, 0.0], "turn_deg": 20.0}
    line = encode_command(documents[0], "edit_strokes", ([0, 2], edit), {})
    documents[0].edit_strokes([0, 2], edit)
    replay_command(documents[1], line)
    np.testing.assert_array_equal(documents[0].surface.srgb, documents[1].surface.srgb)
    seen = documents[0].surface.srgb.copy()
    for numbers, bad in (
        ([], edit),
        ([0, 7], edit),
        ([0, 1], {"do": "fold"}),
        ([0, 1], {"do": "scale", "factor": 1e6}),
        ([0, 1], {"do": "mirror", "across": "z"}),
        ([0, 1], {"do": "move", "along": [9e5, 0.0]}),
    ):
        with pytest.raises(Paint3DError):
            documents[0].edit_strokes(numbers, bad)
        np.testing.assert_array_equal(documents[0].surface.srgb[: len(seen)], seen)
