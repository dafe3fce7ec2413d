"""The panels beside the canvas, and their connection to the painting."""

from __future__ import annotations

import dataclasses
from concurrent.futures import Future
from functools import partial
from typing import Any, Protocol

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.frame import PaintingFrame
from paint3d.app.model.input.pressure_curve import PressureCurve
from paint3d.app.window.brush.brush_panel import BrushPanel
from paint3d.app.window.copybook.copybook_panel import CopybookPanel
from paint3d.app.window.hand.device_panel import DevicePanel
from paint3d.app.window.hand.hand_panel import HandPanel
from paint3d.app.window.history.history_panel import HistoryPanel
from paint3d.app.window.ink.ink_panel import InkPanel
from paint3d.app.window.layer_panel import PICTURE, LayerPanel, layer_pictures
from paint3d.app.window.object.surface_panel import SurfacePanel
from paint3d.app.window.reference.reference_panel import ReferencePanel
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.brush.spec import BrushSpec
from paint3d.painter.painter import Ink
from paint3d.surface.layer_stack import Layer

__all__ = ["Panels"]

_WIDTH = 316
_AGAIN_MS = 20
_LEAST = 160  # pixels of height that stay for the other panels
_RIGHT = QtCore.Qt.DockWidgetArea.RightDockWidgetArea
_LEFT = QtCore.Qt.DockWidgetArea.LeftDockWidgetArea


class _Themed(Protocol):
    def set_theme(self, theme: Theme) -> None: ...


class Panels:
    """All panels of one window.

    Parameters
    ----------
    workspace : Workspace
    menu : QMenu
        Where each can be hidden and shown.
    """

    def __init__(self, workspace: Workspace, menu: QtWidgets.QMenu) -> None:
        self._workspace = workspace
        window, theme, actions = workspace.window, workspace.theme, workspace.actions
        self.brushes, self.inks = BrushPanel(theme), InkPanel(theme)
        self.layers, self.history = LayerPanel(theme), HistoryPanel(theme)
        self.hand, self.copybook = HandPanel(theme), CopybookPanel(theme)
        self.devices, self.reference = DevicePanel(theme), ReferencePanel(theme)
        self.surface = SurfacePanel(
            actions[name] for name in ("wet", "dry", "refine", "set_detail")
        )
        self.docks: dict[str, QtWidgets.QDockWidget] = {}
        self._tall = (
            self.inks, self.hand, self.copybook, self.devices, self.surface, self.reference
        )  # fmt: skip
        upper = [
            self._dock("brushes", say("Brushes"), self.brushes),
            self._dock("inks", say("Inks"), self.inks),
            self._dock("hand", say("Hand"), self.hand),
            self._dock("surface", say("Surface"), self.surface),
        ]
        lower = [
            self._dock("layers", say("Layers"), self.layers),
            self._dock("history", say("History"), self.history),
            self._dock("copybook", say("Text and seal"), self.copybook),
            self._dock("devices", say("Devices"), self.devices),
        ]
        for group in (upper, lower):
            for dock in group[1:]:
                window.tabifyDockWidget(group[0], dock)
            group[0].raise_()
        self._dock("reference", say("Reference"), self.reference, _LEFT).hide()
        window.setTabPosition(_RIGHT, QtWidgets.QTabWidget.TabPosition.North)
        window.resizeDocks([upper[0], lower[0]], [480, 220], QtCore.Qt.Orientation.Vertical)
        window.resizeDocks([upper[0]], [_WIDTH], QtCore.Qt.Orientation.Horizontal)
        for dock in self.docks.values():
            menu.addAction(dock.toggleViewAction())
        self._drawn: object = None  # what the layers' pictures show
        self._drawing: Future[Any] | None = None
        self._asked_of_layers: Future[Any] | None = None
        self._turned: dict[tuple[str, str | int, int], tuple[bool, Future[Any] | None]] = {}
        self._groups = upper, lower
        window.tabifiedDockWidgetActivated.connect(self._give_room)
        self._connect()
        workspace.theme_changed.connect(self._set_theme)

    def _dock(
        self,
        name: str,
        title: str,
        panel: QtWidgets.QWidget,
        area: QtCore.Qt.DockWidgetArea = _RIGHT,
    ) -> QtWidgets.QDockWidget:
        dock = QtWidgets.QDockWidget(title, self._workspace.window)
        dock.setObjectName(f"dock-{name}")
        least = panel.minimumSizeHint().width()
        if panel in self._tall:
            scrolled = _scrolled(panel)
            least += scrolled.verticalScrollBar().sizeHint().width()
            dock.setWidget(scrolled)
        else:
            dock.setWidget(panel)
        dock.setTitleBarWidget(QtWidgets.QWidget())  # the tab says it
        dock.setMinimumWidth(max(_WIDTH, least))
        self._workspace.window.addDockWidget(area, dock)
        self.docks[name] = dock
        return dock

    def _tab_clicked(self, bar: QtWidgets.QTabBar, index: int) -> None:
        titles = {dock.windowTitle(): dock for dock in self.docks.values()}
        dock = titles.get(bar.tabText(index))
        if dock is not None and index == bar.currentIndex():
            self._give_room(dock)

    def _give_room(self, dock: QtWidgets.QDockWidget) -> None:
        """Give a panel whose tab was clicked the height that it needs and others can spare.

        Height that it does not need goes to the other one, as far as that needs it.
        """
        upper, lower = self._groups
        if dock not in upper and dock not in lower:
            return
        others = lower if dock in upper else upper
        beside = [one for one in others if one.isVisible() and not one.visibleRegion().isEmpty()]
        if not beside or dock.isFloating():
            return
        other = beside[0]
        need, height, both = _needed(dock), dock.height(), dock.height() + other.height()
        if height < need:
            given = max(height, min(need, both - _LEAST))
        else:
            given = max(need, both - max(other.height(), _needed(other)))
        if given != height:
            vertical = QtCore.Qt.Orientation.Vertical
            self._workspace.window.resizeDocks([dock, other], [given, both - given], vertical)

    def _connect(self) -> None:
        post = self._workspace.post
        self.brushes.chosen.connect(self._take_brush)
        self.brushes.failed.connect(lambda why: self._workspace.tell(why, state="bad"))
        self._workspace.hand.sized.connect(self.brushes.resize_brush)
        self._workspace.hand.watered.connect(self.inks.water_by)
        self.inks.watering.connect(
            lambda share: self._workspace.tell(say("Water {share:.0f} %", share=100.0 * share))
        )
        self.surface.failed.connect(lambda why: self._workspace.tell(why, state="bad"))
        self.inks.dipped.connect(self._dip)
        self.inks.rinsed.connect(lambda: post("rinse"))
        self.layers.asked.connect(self._ask_layers)
        self.layers.turned.connect(self._toggle)
        self.history.reported.connect(self._workspace.tell)
        self.hand.read.connect(self._read_hand)
        self.hand.pressed.connect(self._workspace.hand.set_force)
        self.hand.curve.changed.connect(self._save_curve)
        self.hand.ruled.connect(lambda on: self._workspace.actions["ruler"].setChecked(on))

    def _ask_layers(self, what: str, arguments: tuple[Any, ...]) -> None:
        """Post a command of the layers, after which they may have another order."""
        paint_thread = self._workspace.stage.paint_thread
        if paint_thread is not None:
            self._asked_of_layers = paint_thread.post(what, *arguments)

    def _toggle(self, what: str, index: int, shown: Layer) -> None:
        """Toggle a property of a layer or its group, from its state or the one last asked for.

        Clicks may come faster than the painting thread follows, or the panel shows it: the layer is
        found by its name, the nearest to the index shown, once pending moves are done.
        """
        paint_thread = self._workspace.stage.paint_thread
        if paint_thread is None:
            return
        asked_before = self._asked_of_layers
        if asked_before is not None and not asked_before.done():
            QtCore.QTimer.singleShot(_AGAIN_MS, lambda: self._toggle(what, index, shown))
            return
        flag, of_group = what.rpartition("_")[2], what.startswith("set_group")
        name = _key_of(shown, of_group)
        layers = paint_thread.painting.layers
        indices = [k for k, layer in enumerate(layers) if _key_of(layer, of_group) == name]
        if name is None or not indices:  # it was removed since
            return
        now = min(indices, key=lambda k: abs(k - index))
        asked, done = self._turned.get((what, name, now), (False, None))
        if done is None or done.done():
            asked = getattr(layers[now].group if of_group else layers[now], flag)
        self._turned[what, name, now] = not asked, paint_thread.post(what, now, not asked)

    def _read_hand(self, changes: dict[str, Any]) -> None:
        """Change how the hand is read; the source of a mouse's pressure is a preference, too."""
        self._workspace.hand.set_settings(**changes)
        if "pressure_by" in changes:
            self._workspace.update_settings(**changes)

    def _save_curve(self, curve: PressureCurve) -> None:
        self._workspace.settings = dataclasses.replace(
            self._workspace.settings, pressure_curve=curve.points
        )

    def set_open(self, is_open: bool) -> None:
        """Enable or disable the panels that need a painting."""
        for panel in (self.brushes, self.inks, self.surface, self.layers, self.history):
            panel.setEnabled(is_open)
        self.copybook.setEnabled(is_open)
        self.reference.setEnabled(is_open)

    # -- following the painting -------------------------------------------------------------

    def open(self) -> None:
        """Show another document."""
        painting = self._workspace.painting
        # Qt makes the tab bars when the docks are shown; its own signal leaves out the tab in front
        for bar in self._workspace.window.findChildren(QtWidgets.QTabBar):
            if not bar.property("watched"):
                bar.setProperty("watched", True)
                bar.tabBarClicked.connect(partial(self._tab_clicked, bar))
        self._drawn = self._drawing = None
        self._turned, self._asked_of_layers = {}, None
        self.layers.show_pictures(())
        self.brushes.show_brush(painting.brush)
        self.inks.show_inks(painting.inks)
        self.brushes.set_ink(painting.inks[0])
        self.inks.show_pickup(painting.pickup)
        self.inks.show_amount(painting.amount, anew=True)
        self.layers.show_layers(painting.layers, painting.active_layer)
        self.copybook.show_copybook(None)
        self.history.open(painting)
        if painting.refused_history:
            why = painting.refused_history
            self._workspace.tell(say("Its undo steps cannot be used: {why}", why=why), state="bad")

    def follow(self, frame: PaintingFrame) -> None:
        """Show a frame's painting."""
        painting = frame.painting
        self.surface.show_surface(painting)
        self.layers.show_layers(painting.layers, painting.active_layer)
        self._follow_layers(frame)
        self.history.follow(frame)
        self.inks.show_pickup(painting.pickup)
        self.inks.show_amount(painting.amount)
        if painting.inks[0] != self.inks.ink:
            self.inks.show_inks(painting.inks)
            self.brushes.set_ink(painting.inks[0])

    def _follow_layers(self, frame: PaintingFrame) -> None:
        """Draw the layers' pictures anew when something was painted and nothing waits."""
        if self._drawing is not None and self._drawing.done():
            drawing, self._drawing = self._drawing, None
            if not drawing.cancelled() and drawing.exception() is None:
                self.layers.show_pictures(drawing.result())
        painting = frame.painting
        state = painting.layers, painting.active_layer, tuple(map(id, painting.strokes))
        if state == self._drawn or self._drawing is not None or frame.queue_length:
            return
        if not self._workspace.hand.in_stroke:
            self._drawn = state
            self._drawing = self._workspace.paint_thread.post(
                lambda document: layer_pictures(document.surface, PICTURE)
            )

    def show_brush_asked(self, brush: BrushSpec) -> bool:
        """Show the brush that was chosen last; return whether another one was shown before."""
        if brush == self.brushes.brush or self.brushes.is_settling:
            return False
        self.brushes.show_brush(brush)
        return True

    def show_unit(self) -> None:
        """Show lengths in the chosen unit."""
        self.brushes.show_unit()
        self.surface.show_unit()
        if self._workspace.stage.paint_thread is not None:
            self.surface.show_surface(self._workspace.painting)

    def ink_name(self) -> str:
        """Return the name of the ink that the brush is dipped in."""
        return self.inks.ink_name()

    def _set_theme(self, theme: Theme) -> None:
        """Change the colours of the panels' own drawings."""
        panels: tuple[_Themed, ...] = (
            self.brushes, self.inks, self.hand, self.layers, self.history, self.copybook,
            self.reference, self.devices, self.surface,
        )  # fmt: skip
        for panel in panels:
            panel.set_theme(theme)
        frame = self._workspace.stage.frame
        if frame is not None:
            self.follow(frame)  # rows have icons in these colours

    def toggle(self) -> None:
        """Hide all, or show them again."""
        shown = [dock for dock in self.docks.values() if dock.isVisible()]
        for name, dock in self.docks.items():
            dock.setVisible(not shown and not self._is_idle(name))

    def _is_idle(self, name: str) -> bool:
        """Return whether a panel has nothing to show."""
        return name == "reference" and self.reference.view.image is None

    def step(self, by: int) -> None:
        """Bring the focus to the next panel (by 1), or the one before (-1), or to the picture."""
        names = [name for name in self.docks if not self._is_idle(name)]
        focus = self._workspace.window.focusWidget()
        inside = [n for n in names if focus is not None and self.docks[n].isAncestorOf(focus)]
        at = names.index(inside[0]) if inside else (-1 if by > 0 else len(names))
        for name in names[at + 1 :] if by > 0 else names[:at][::-1]:
            first = next(
                filter(_takes_keys, self.docks[name].findChildren(QtWidgets.QWidget)), None
            )
            if first is not None:
                self.docks[name].show()
                self.docks[name].raise_()
                first.setFocus(QtCore.Qt.FocusReason.TabFocusReason)
                return
        self._workspace.canvas.setFocus(QtCore.Qt.FocusReason.OtherFocusReason)

    def close_down(self) -> None:
        """Stop the work beside the window."""
        self.brushes.close_down()

    def _take_brush(self, brush: BrushSpec) -> None:
        self.brushes.show_brush(brush)
        self._workspace.post("set_brush", brush)

    def _dip(self, ink: Ink, reach: float | None) -> None:
        self._workspace.dip(ink, reach)
        self.brushes.set_ink(ink)


def _needed(dock: QtWidgets.QDockWidget) -> int:
    """Return the height at which all of a panel is seen, pixels."""
    shown = dock.widget()
    content = shown.widget() if isinstance(shown, QtWidgets.QScrollArea) else shown
    assert content is not None, "each panel was put into its dock"
    if isinstance(content, InkPanel):
        return content.height_with_dishes(dock.width())
    if isinstance(content, BrushPanel):
        return content.height_with_brushes()
    wide = content.heightForWidth(dock.width())
    return wide if wide > 0 else content.sizeHint().height()


def _takes_keys(widget: QtWidgets.QWidget) -> bool:
    """Return whether a widget takes keys for more than scrolling."""
    tab = bool(widget.focusPolicy() & QtCore.Qt.FocusPolicy.TabFocus)
    can = tab and widget.isEnabled() and not widget.isHidden()
    return can and not isinstance(widget, QtWidgets.QScrollArea)


def _key_of(layer: Layer, of_group: bool) -> str | int | None:
    """Return a layer's name, or the key of the group that it is in."""
    if not of_group:
        return layer.name
    return None if layer.group is None else layer.group.key


def _scrolled(panel: QtWidgets.QWidget) -> QtWidgets.QScrollArea:
    """Return a panel that scrolls where the window is too low for it."""
    area = QtWidgets.QScrollArea()
    area.setObjectName("plain")
    area.setWidgetResizable(True)
    area.setHorizontalScrollBarPolicy(QtCore.Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setFocusPolicy(QtCore.Qt.FocusPolicy.NoFocus)
    area.setWidget(panel)
    return area
