"""A laid text that the brush writes: by button and key, in the ink in hand, taken back at once."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import trimesh

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.score.playing import painted
from paint3d.painter.ink_time import INK_STEP_S
from tests.support.app.gestures import BUTTON, type_key, wait_for
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, settled
from tests.support.cases import long_but
from tests.support.mugs import make_mug

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier
POEMS = {
    "江雪": (
        "千山鳥飛絕萬徑人蹤滅孤舟蓑笠翁獨釣寒江雪",
        "千山鸟飞绝万径人踪灭孤舟蓑笠翁独钓寒江雪",
    ),
    "蘭亭序": (
        "永和九年歲在癸丑暮春之初會于會稽山陰之蘭亭修禊事也",
        "永和九年岁在癸丑暮春之初会于会稽山阴之兰亭修禊事也",
    ),
    "登鸛雀樓": (
        "白日依山盡黃河入海流欲窮千里目更上一層樓",
        "白日依山尽黄河入海流欲穷千里目更上一层楼",
    ),
}


@pytest.fixture(scope="module")
def window(program):
    """A window with a small sheet in it."""
    with opened(program, "sheet:160x200", 1.0, "xuan", drawn=False) as window:
        yield window


@pytest.fixture(autouse=True)
def bare(window) -> None:
    window.player.stop()
    while window.document.can_undo:
        window.stage.paint_thread.post("undo").result(300)
    settled(window)
    wait_for(lambda: not window.copying._shown)


def lay(window, text: str, em: float) -> None:
    assert window.copying.layout_text(text, em, True)
    wait_for(lambda: window.document.texts)
    settled(window)


def written(window) -> None:
    wait_for(lambda: window.document.strokes and not window.player.is_playing)
    settled(window)


def test_the_button_has_the_brush_write_it_where_it_lies(window) -> None:
    lay(window, "十", 70.0)
    window.stage.paint_thread.post("dip", "cinnabar").result(300)
    brush = window.document.painter.brush
    QtTest.QTest.mouseClick(window.panels.copybook.write_button, BUTTON.LeftButton)
    written(window)
    (ghost,) = window.panels.copybook.copybook.ghosts
    likeness = ghost.compare(window.document.surface)
    assert likeness is not None
    assert likeness.iou > 0.5
    (stroke,) = window.document.strokes
    assert set(stroke.ink) == {"cinnabar"}
    assert window.document.painter.brush == brush
    type_key(window.canvas, KEY.Key_Z, HELD.ControlModifier)
    wait_for(lambda: not window.document.strokes)
    assert len(window.document.texts) == 1
    assert not window.document.surface.painted.any()


def test_the_key_writes_and_esc_stops_it(window) -> None:
    lay(window, "永和", 60.0)
    type_key(window.canvas, KEY.Key_T, HELD.ShiftModifier)
    window.replay_bar.speed.activated.emit(window.replay_bar.speed.findText("1 x"))
    wait_for(lambda: window.document.surface.painted.any())
    assert window.player.is_playing
    type_key(window.canvas, KEY.Key_Escape)
    written(window)


def test_a_text_around_a_mug_is_laid_and_written_beside_its_handle(
    window, program, tmp_path
) -> None:
    mug = make_mug(0.0)
    trimesh.Trimesh(mug.vertices, mug.faces).export(tmp_path / "mug.stl")
    with opened(program, str(tmp_path / "mug.stl"), 2.0, "porcelain", drawn=False) as cup:
        assert cup.copying.ask(
            {"text": "永和", "em_mm": 40.0, "order": "row", "around": True}, False
        )
        wait_for(lambda: cup.document.texts)
        book = cup.panels.copybook.copybook
        middles = np.array([square.chart.frame.origin for square in book.squares])
        assert (middles[:, 0] < 0.0).all(), "the handle is at +x"
        cup.writing.do_write_text()  # nothing is asked: the brush has room
        assert cup.player.is_playing
        cup.player.stop()


def test_with_no_text_there_it_says_what_to_do(window) -> None:
    type_key(window.canvas, KEY.Key_T, HELD.ShiftModifier)
    wait_for(lambda: "lay one out first" in window.status.message_label.text())
    assert not window.player.is_playing


@pytest.mark.parametrize(
    ("title", "script"), long_but([("江雪", 1), ("蘭亭序", 0)], product(POEMS, (0, 1)))
)
def test_poems_are_laid_in_both_scripts(window, title: str, script: int) -> None:
    text = POEMS[title][script]
    lay(window, text, 24.0)
    assert "".join(ghost.text for ghost in window.panels.copybook.copybook.ghosts) == text


def test_what_the_brush_has_written_is_counted_and_its_guide_goes(window) -> None:
    lay(window, "十一", 40.0)
    stage, panel = window.stage, window.panels.copybook
    shown: dict[str, int] = {}
    draw = stage.show_lines

    def note(name: str, lines, *how) -> None:
        shown[name] = len(lines)
        draw(name, lines, *how)

    stage.show_lines = note
    try:
        type_key(window.canvas, KEY.Key_T, HELD.ShiftModifier)
        written(window)
        wait_for(lambda: panel.message_label.text() == "All characters are written")
        assert (shown["ghosts"], shown["next ghost"], shown["ghost frames"]) == (0, 0, 0)
        counts = [panel.list.item(row).text() for row in range(2)]
        assert counts == ["✓  十   2 / 2", "✓  一   1 / 1"]
        type_key(window.canvas, KEY.Key_Z, HELD.ControlModifier)
        wait_for(lambda: shown["next ghost"] == 2 and shown["ghosts"] == 1)
        assert panel.message_label.text() == "0 of 2 written; next: 十"
    finally:
        del stage.show_lines


def test_where_nobody_keeps_the_time_ink_has_that_of_a_swift_hand(window) -> None:
    lay(window, "十", 40.0)
    window.workspace.actions["wet"].setChecked(True)
    type_key(window.canvas, KEY.Key_T, HELD.ShiftModifier)
    written(window)
    window.workspace.actions["wet"].setChecked(False)
    settled(window)
    document = window.document
    (stroke,) = document.strokes
    events = document.score.events
    lines = [one for one in events if isinstance(one, dict)]
    begun, ended = (
        max(k for k, one in enumerate(lines) if one["do"] == name)
        for name in ("begin_stroke", "end_stroke")
    )
    within = [one for one in lines[begun:ended] if one["do"] == "follow_time"]
    pieces = sum(one.get("times", 1) for one in within)
    assert pieces == pytest.approx(stroke.duration_s / (8 * INK_STEP_S), abs=1.0)
    again = painted(document.score, document.surface.source)
    same_vertices(document.surface, again.surface)


def test_a_text_is_written_on_without_spreading(window) -> None:
    lay(window, "十", 40.0)
    wet = window.workspace.actions["wet"]
    wet.setChecked(True)
    type_key(window.canvas, KEY.Key_T, HELD.ShiftModifier)
    wait_for(lambda: window.document.surface.painted.any())
    window.player.stop_spreading()
    assert not wet.isChecked()
    assert not window.stage.paint_thread.wet
    assert window.workspace.settings.wet is True  # of the next painting
    written(window)
    assert window.panels.copybook.copybook.next is None
