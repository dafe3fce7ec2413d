"""Every command of the registry, by every way that leads to it: menu, tool bar, keys."""

from __future__ import annotations

import inspect
from collections.abc import Callable

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest

from paint3d.app.model.commands import COMMANDS, MENUS, TOOLS
from paint3d.app.model.document import Document
from paint3d.app.window.actions import Actions
from tests.support.app.gestures import wait_for
from tests.support.app.windows import opened

IN_MENUS = [name for names in MENUS.values() for name in names if name != "-"]


class _Recorder:
    """Does nothing that it is asked for, and writes down what it was."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def __getattr__(self, name: str) -> Callable[..., None]:
        if not name.startswith("do_"):
            raise AttributeError(name)
        return lambda *_: self.asked.append(name.removeprefix("do_"))


@pytest.fixture(scope="module")
def handlers() -> dict[str, tuple[object, ...]]:
    """What the window would have done its commands by."""
    return {}


@pytest.fixture(scope="module")
def every_command() -> _Recorder:
    return _Recorder()


@pytest.fixture
def recorder(every_command: _Recorder, window) -> _Recorder:
    """Of what is asked from now on, by who looks at the picture."""
    window.canvas.setFocus()
    wait_for(window.canvas.hasFocus)
    every_command.asked.clear()
    return every_command


@pytest.fixture(scope="module")
def window(program, handlers, every_command):
    """A window whose commands are written down, and not done."""
    bind = Actions.bind

    def bind_recorder(actions, parts) -> None:
        handlers["parts"] = tuple(parts)
        bind(actions, [every_command])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Actions, "bind", bind_recorder)
        with opened(program, "sphere", 6.0, "porcelain", drawn=False) as window:
            yield window


def press(window, keys: str) -> None:
    """Press keys as the system hands them over: to the window that has the keyboard."""
    held, pad, key = keys.rpartition("Num+") if "Num+" in keys else ("", "", keys)
    combined = QtGui.QKeySequence.fromString(held + key)[0]
    modifiers = combined.keyboardModifiers()
    if pad:
        modifiers |= QtCore.Qt.KeyboardModifier.KeypadModifier
    QtTest.QTest.keyClick(window.windowHandle(), combined.key(), modifiers)


@pytest.mark.parametrize("name", IN_MENUS)
def test_each_way_that_leads_to_a_command_asks_for_it_alone(window, recorder, name: str) -> None:
    """Its keys, its place in the menus, and the tool bar."""
    row, action = COMMANDS[name], window.workspace.actions[name]
    for keys in row.keys:
        press(window, keys)
        wait_for(lambda: recorder.asked)
        assert recorder.asked == [name], keys
        recorder.asked.clear()
    assert action in window.commands.menus[row.menu].actions()
    action.setEnabled(True)  # undo and redo follow the painting
    action.trigger()
    if name in TOOLS:
        window.commands.tools.widgetForAction(action).click()
    assert recorder.asked == [name] * (1 + (name in TOOLS))
    assert action.text()
    assert action.isCheckable() == row.checkable
    assert (not action.icon().isNull()) == bool(row.icon)


def test_what_no_part_of_the_window_does_the_document_does_without_arguments(
    window, handlers
) -> None:
    own = [n for n in IN_MENUS if not any(hasattr(part, f"do_{n}") for part in handlers["parts"])]
    assert own
    for name in own:
        assert COMMANDS[name].codec is not None, name
        _, *parameters = inspect.signature(getattr(Document, name)).parameters.values()
        assert all(one.default is not one.empty for one in parameters), name


def test_what_can_be_undone_is_written_down_and_done_by_the_document() -> None:
    undoable = [name for name, row in COMMANDS.items() if row.undo_label]
    assert undoable
    assert [name for name in undoable if COMMANDS[name].codec is None] == []
    assert all(callable(getattr(Document, name)) for name in undoable)
