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
from tests.support.app.windows import opened, settled

IN_MENUS = [name for names in MENUS.values() for name in names if name != "-"]
KEYS = [(name, keys) for name in IN_MENUS for keys in COMMANDS[name].keys]


class _Recorder:
    """Does nothing that it is asked for, and writes down what it was."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def __getattr__(self, name: str) -> Callable[..., None]:
        if not name.startswith("do_"):
            raise AttributeError(name)
        return lambda *_: self.asked.append(name.removeprefix("do_"))


@pytest.fixture(scope="module")
def doers() -> dict[str, tuple[object, ...]]:
    """What the window would have done its commands by."""
    return {}


@pytest.fixture(scope="module")
def recorder(doers) -> _Recorder:
    return _Recorder()


@pytest.fixture(scope="module")
def window(program, doers, recorder):
    """A window whose commands are written down, and not done."""
    bind = Actions.bind

    def bind_recorder(actions, parts) -> None:
        doers["parts"] = tuple(parts)
        bind(actions, [recorder])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Actions, "bind", bind_recorder)
        with opened(program, "sphere", 6.0, "porcelain") as window:
            yield window


@pytest.fixture(autouse=True)
def nothing_asked(window, recorder):
    window.canvas.setFocus()
    wait_for(window.canvas.hasFocus)
    recorder.asked.clear()
    yield
    settled(window)


def press(window, keys: str) -> None:
    """Press keys as the system hands them over: to the window that has the keyboard."""
    held, pad, key = keys.rpartition("Num+") if "Num+" in keys else ("", "", keys)
    combined = QtGui.QKeySequence.fromString(held + key)[0]
    modifiers = combined.keyboardModifiers()
    if pad:
        modifiers |= QtCore.Qt.KeyboardModifier.KeypadModifier
    QtTest.QTest.keyClick(window.windowHandle(), combined.key(), modifiers)


@pytest.mark.parametrize(("name", "keys"), KEYS)
def test_keys_ask_for_their_command_alone(window, recorder, name: str, keys: str) -> None:
    press(window, keys)
    wait_for(lambda: recorder.asked, 30.0)
    assert recorder.asked == [name]


@pytest.mark.parametrize("name", IN_MENUS)
def test_menus_and_tools_ask_for_their_command_alone(window, recorder, name: str) -> None:
    menu = window.commands.menus[COMMANDS[name].menu]
    action = window.workspace.actions[name]
    assert action in menu.actions()
    action.setEnabled(True)  # undo and redo follow the painting
    action.trigger()
    assert recorder.asked == [name]
    if name in TOOLS:
        window.commands.tools.widgetForAction(action).click()
        assert recorder.asked == [name, name]
    assert action.isCheckable() == COMMANDS[name].checkable
    assert (not action.icon().isNull()) == bool(COMMANDS[name].icon)


@pytest.mark.parametrize("name", IN_MENUS)
def test_what_no_part_of_the_window_does_the_document_does_without_arguments(
    window, doers, name: str
) -> None:
    if any(hasattr(part, f"do_{name}") for part in doers["parts"]):
        return
    assert COMMANDS[name].codec is not None
    _, *parameters = inspect.signature(getattr(Document, name)).parameters.values()
    assert all(one.default is not one.empty for one in parameters)
