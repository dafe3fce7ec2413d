"""A laid text that the brush writes: by button and key, in the ink in hand, taken back at once."""

from __future__ import annotations

from itertools import product

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from tests.support.app.gestures import BUTTON, type_key, wait_for
from tests.support.app.windows import opened, settled
from tests.support.cases import long_but

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
        window.panels.history.pace.setCurrentIndex(window.panels.history.pace.count() - 1)
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
    window.stage.paint_thread.post("dip", "cinnabar").result(60)
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
    pace = window.panels.history.pace
    pace.setCurrentIndex(2)
    lay(window, "永和", 60.0)
    type_key(window.canvas, KEY.Key_T, HELD.ShiftModifier)
    wait_for(lambda: window.document.surface.painted.any())
    assert window.player.is_playing
    type_key(window.canvas, KEY.Key_Escape)
    written(window)
    pace.setCurrentIndex(pace.count() - 1)


def test_with_no_text_there_it_says_what_to_do(window) -> None:
    type_key(window.canvas, KEY.Key_T, HELD.ShiftModifier)
    wait_for(lambda: "lay one out first" in window.status.told.text())
    assert not window.player.is_playing


@pytest.mark.parametrize(
    ("title", "script"), long_but([("江雪", 1), ("蘭亭序", 0)], product(POEMS, (0, 1)))
)
def test_poems_are_laid_in_both_scripts(window, title: str, script: int) -> None:
    text = POEMS[title][script]
    lay(window, text, 24.0)
    assert "".join(ghost.text for ghost in window.panels.copybook.copybook.ghosts) == text
