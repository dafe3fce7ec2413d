"""Controls of the window by the names that a screen reader tells: where each of them is seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.hand.canvas import CanvasWidget
from paint3d.app.window.studio import StudioWindow

__all__ = [
    "CANVAS",
    "POPUP",
    "Control",
    "control_at",
    "find_control",
    "named_controls",
    "open_popup",
    "title_of",
    "windows",
]

CANVAS = "canvas"
POPUP = "popup"  # a menu, or a box's list
_NAME = QtGui.QAccessible.Text.Name
_PLAIN = frozenset(
    {"Window", "Dialog", "Pane", "Client", "Border", "PopupMenu", "List", "Grouping"}
)
"""Roles of what only holds others: it is told by none of them what is pressed there."""


@dataclass(frozen=True)
class Control:
    """What a screen reader calls a part of a window ("Button: Begin"), and its box on the screen.

    A place in it is told by shares of its box; in the picture both are counted in its height, x
    from half of one left of its middle, so that a wider picture has it in the same place.
    """

    name: str
    box: QtCore.QRect

    def share(self, place: QtCore.QPointF) -> tuple[float, float]:
        """Return a place of the screen as shares."""
        x, y = place.x() - self.box.left(), place.y() - self.box.top()
        wide, high = self.box.width(), self.box.height()
        if self.name == CANVAS:
            return round(0.5 + (x - 0.5 * wide) / high, 5), round(y / high, 5)
        return round(x / max(1, wide), 3), round(y / max(1, high), 3)

    def place(self, share: Sequence[float]) -> QtCore.QPointF:
        """Return the place on the screen of shares."""
        wide, high = self.box.width(), self.box.height()
        x = 0.5 * wide + (share[0] - 0.5) * high if self.name == CANVAS else share[0] * wide
        return QtCore.QPointF(self.box.left() + x, self.box.top() + share[1] * high)


def title_of(window: QtWidgets.QWidget) -> str:
    """Return what a window is called: "" the studio's, "popup" a menu, a dialog by its title."""
    if isinstance(window, StudioWindow):
        return ""
    if window.windowType() == QtCore.Qt.WindowType.Popup:
        return POPUP
    return window.windowTitle()


def open_popup() -> QtWidgets.QWidget | None:
    """Return the menu or the box's list that is open; what a line proposes is none."""
    popup = QtWidgets.QApplication.activePopupWidget()
    return None if isinstance(popup, QtWidgets.QAbstractItemView) else popup


def windows(title: str) -> list[QtWidgets.QWidget]:
    """Return the windows of a title that take clicks now, the one opened last first."""
    popup, modal = open_popup(), QtWidgets.QApplication.activeModalWidget()
    if popup is not None:
        open_now = [popup, *_popups_behind(popup)]
    elif modal is not None:
        open_now = [modal]
    else:
        open_now = [w for w in QtWidgets.QApplication.topLevelWidgets() if w.isVisible()]
    return [window for window in open_now if title_of(window) == title]


def _popups_behind(popup: QtWidgets.QWidget) -> list[QtWidgets.QWidget]:
    """Return the menus that a menu has come from."""
    return [
        w
        for w in QtWidgets.QApplication.topLevelWidgets()
        if w.isVisible() and w is not popup and title_of(w) == POPUP
    ]


def control_at(place: QtCore.QPoint) -> Control | None:
    """Return the control that is seen at a place of the screen; None where none is."""
    under = QtWidgets.QApplication.widgetAt(place)
    if isinstance(under, CanvasWidget):
        return Control(CANVAS, _box_of(under))
    found = None
    while under is not None and found is None:
        here = QtGui.QAccessible.queryAccessibleInterface(under)
        while here is not None and here.isValid():
            found = _control(here) or found
            here = here.childAt(place.x(), place.y()) if here.childCount() else None
        under = None if under.isWindow() else under.parentWidget()
    return found


def find_control(window: QtWidgets.QWidget, name: str, share: Sequence[float]) -> Control | None:
    """Return the control of a name that is seen at shares of its box; None where there is none.

    Of several the first is taken, in the order in which they are read out.
    """
    if name == CANVAS:
        canvas = window.findChild(CanvasWidget)
        found = [] if canvas is None else [Control(CANVAS, _box_of(canvas))]
    else:
        found = [control for control in named_controls(window) if control.name == name]
    for control in found:
        there = control_at(control.place(share).toPoint())
        if there is not None and there.name == name:
            return control
    return None


def named_controls(window: QtWidgets.QWidget) -> Iterator[Control]:
    """Yield the controls of a window that are shown, in the order in which they are read out."""
    yield from _below(QtGui.QAccessible.queryAccessibleInterface(window))


def _below(interface: QtGui.QAccessibleInterface) -> Iterator[Control]:
    for number in range(interface.childCount()):
        child = interface.child(number)
        if child is None or not child.isValid() or child.state().invisible:
            continue
        if (control := _control(child)) is not None:
            yield control
        yield from _below(child)


def _control(interface: QtGui.QAccessibleInterface) -> Control | None:
    role, name = interface.role().name, interface.text(_NAME)
    if role in _PLAIN or not name or interface.state().disabled != 0:
        return None
    return Control(f"{role}: {name}", interface.rect())


def _box_of(widget: QtWidgets.QWidget) -> QtCore.QRect:
    return QtCore.QRect(widget.mapToGlobal(QtCore.QPoint(0, 0)), widget.size())
