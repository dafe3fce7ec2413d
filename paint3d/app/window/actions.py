"""The actions of a window: their texts, keys and icons, their menus and tools."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.commands import COMMANDS, MENUS, TITLES, TOOLS, Command
from paint3d.app.window.theme import Theme, make_icon
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["Actions"]

_LARGE, _SMALL = QtCore.QSize(19, 19), QtCore.QSize(16, 16)
_TIGHTEST = 2  # spacing of the tools: from 0, wide, to this
_NEVER_LOST = ("undo", "redo")  # work even while they look disabled: see `Actions.bind`


class Actions:
    """Menus and tools of one window.

    Parameters
    ----------
    workspace : Workspace
        Gets them as its `actions`.
    tapped : collection of str
        Names of those whose keys are handled elsewhere.

    Attributes
    ----------
    menus : dict of str to QMenu
    tools : QToolBar
    recent, unsaved : QMenu
        Of files, and of paintings that a crash left.
    """

    def __init__(self, workspace: Workspace, tapped: Iterable[str]) -> None:
        self._workspace, self._tapped = workspace, frozenset(tapped)
        self._do: dict[str, Callable[[], object]] = {}  # without asking whether it is enabled
        self.menus: dict[str, QtWidgets.QMenu] = {}
        for name, actions in MENUS.items():
            menu = self.menus[name] = workspace.window.menuBar().addMenu(say(TITLES[name]))
            for action in actions:
                if action == "-":
                    menu.addSeparator()
                    continue
                menu.addAction(self._make(action))
                if action == "open":
                    self.recent = menu.addMenu(say("Open recent"))
                    self.unsaved = menu.addMenu(say("Recover unsaved work"))
        self.tools = bar = QtWidgets.QToolBar(say("Tools"))
        bar.setObjectName("tools")
        bar.setMovable(False)
        bar.setIconSize(_LARGE)
        workspace.window.addToolBar(QtCore.Qt.ToolBarArea.LeftToolBarArea, bar)
        for name in TOOLS:
            if name == "-":
                bar.addSeparator()
            else:
                bar.addAction(workspace.actions[name])
        self._heights: dict[int, int] = {}  # of the tools, by how close together they are
        workspace.theme_changed.connect(self._set_theme)

    def _make(self, name: str) -> QtGui.QAction:
        workspace = self._workspace
        command = COMMANDS[name]
        text, keys = say(command.text), command.keys
        action = QtGui.QAction(text, workspace.window)
        if name not in self._tapped:
            action.setShortcuts([QtGui.QKeySequence(key) for key in keys])
        if command.on_picture:
            action.setShortcutContext(QtCore.Qt.ShortcutContext.WidgetShortcut)
            workspace.canvas.addAction(action)
        action.setToolTip(text.rstrip("…") + (f"  ({keys[0]})" if keys else ""))
        action.setCheckable(command.checkable)
        if command.icon:
            action.setIcon(make_icon(command.icon, workspace.theme))
        workspace.actions[name] = action
        return action

    def bind(self, handlers: Iterable[object]) -> None:
        """Connect each command to the handler that has a ``do_<name>``.

        One that only changes the painting, and needs no argument, is posted to the painting thread.
        Undo and redo are shown enabled or not by the last frame. Their keys and taps always work:
        commands since that frame may have brought something to undo or redo.
        """
        handlers = tuple(handlers)
        for name, action in self._workspace.actions.items():
            own = [getattr(d, f"do_{name}") for d in handlers if hasattr(d, f"do_{name}")]
            do = own[0] if own else partial(self._post, COMMANDS[name])
            if COMMANDS[name].checkable:
                action.toggled.connect(do)
            else:
                action.triggered.connect(_without_state(do))
            if name in _NEVER_LOST:
                self._bind_shortcut(name, do)

    def _post(self, command: Command) -> None:
        assert command.codec is not None, "what does not change the painting has its do_<name>"
        self._workspace.post(command.name)

    def _bind_shortcut(self, name: str, do: Callable[[], object]) -> None:
        """Do an action's command by its keys while it is disabled, and so does not."""
        action = self._workspace.actions[name]
        keys = QtGui.QShortcut(self._workspace.window)
        keys.setKeys(action.shortcuts())
        keys.activated.connect(do)
        keys.setEnabled(not action.isEnabled())  # or Qt calls them ambiguous, and does nothing
        action.changed.connect(lambda: keys.setEnabled(not action.isEnabled()))
        self._do[name] = do

    def trigger(self, name: str) -> None:
        """Trigger an action by its name."""
        if name in self._do:
            self._do[name]()
        else:
            self._workspace.actions[name].trigger()

    def set_open(self, is_open: bool) -> None:
        """Enable or disable commands that need a painting; uncheck those of the one before."""
        for name, action in self._workspace.actions.items():
            command = COMMANDS[name]
            action.setEnabled((is_open and name not in _NEVER_LOST) or command.always)
            if command.checkable and not command.always:
                self.check(name, False)

    def check(self, name: str, on: bool) -> None:
        """Show an action as on or off, without doing it."""
        with QtCore.QSignalBlocker(self._workspace.actions[name]):
            self._workspace.actions[name].setChecked(on)

    def fit(self, height: int) -> None:
        """Draw the tools closer together where the window is low, so that none is lost."""
        window = self._workspace.window
        around = [bar for bar in (window.menuBar(), window.statusBar()) if not bar.isHidden()]
        room = height - sum(bar.sizeHint().height() for bar in around)
        for tight in range(1 + _TIGHTEST):
            if tight not in self._heights:
                self._draw_tools(tight)
                self._heights[tight] = self._tools_layout().sizeHint().height()
            if self._heights[tight] <= room:
                break
        self._draw_tools(tight)

    def _draw_tools(self, tight: int) -> None:
        """Draw the tools with one of the spacings."""
        tools = self.tools
        if tools.property("tight") == tight:
            return
        tools.setProperty("tight", tight)
        tools.setIconSize(_SMALL if tight else _LARGE)
        for widget in (tools, *tools.findChildren(QtWidgets.QToolButton)):
            widget.style().unpolish(widget)
            widget.style().polish(widget)
        self._tools_layout().invalidate()

    def _tools_layout(self) -> QtWidgets.QLayout:
        layout = self.tools.layout()
        assert layout is not None, "a tool bar has one"
        return layout

    def _set_theme(self, theme: Theme) -> None:
        for name, action in self._workspace.actions.items():
            if COMMANDS[name].icon:
                action.setIcon(make_icon(COMMANDS[name].icon, theme))


def _without_state(do: Callable[[], object]) -> Callable[..., object]:
    return lambda _=False: do()
