"""The studio's window: menus, tools, panels and the picture in their middle."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.input.devices import Feedback, Plugged
from paint3d.app.model.persistence.saved_settings import in_hand
from paint3d.app.model.persistence.settings import Settings, save_settings
from paint3d.app.model.persistence.sitting import Sitting
from paint3d.app.window.begin_page import BeginPage
from paint3d.app.window.commands import (
    ALWAYS,
    CHECKABLE,
    ICONS_OF,
    MENUS,
    ON_PICTURE,
    TOOLS,
    keys_of,
    text_of,
)
from paint3d.app.window.copying import Copying
from paint3d.app.window.guard import TellOnce
from paint3d.app.window.hud import Hud
from paint3d.app.window.icons import make_icon
from paint3d.app.window.input.both_hands import BothHands
from paint3d.app.window.input.canvas import Canvas
from paint3d.app.window.input.hand import CanvasHand
from paint3d.app.window.input.keys import HeldKeys
from paint3d.app.window.input.steering import Steering
from paint3d.app.window.jobs.files import Files
from paint3d.app.window.jobs.job import is_waiting
from paint3d.app.window.jobs.opened import Opened
from paint3d.app.window.jobs.player import Player
from paint3d.app.window.jobs.recalling import Recalling
from paint3d.app.window.jobs.standing import Standing
from paint3d.app.window.keeping_up import keeping_up
from paint3d.app.window.named import described
from paint3d.app.window.paint_actions import PaintActions
from paint3d.app.window.panels.side_panels import Panels
from paint3d.app.window.stage import Stage
from paint3d.app.window.theme import (
    DARK_THEME,
    LIGHT_THEME,
    STATES,
    apply_theme,
    is_system_dark,
)
from paint3d.app.window.view_actions import ViewActions
from paint3d.app.window.window_place import first_size, restore_window, window_words
from paint3d.app.window.wording import choose_unit, say, say_error
from paint3d.errors import Paint3DError
from paint3d.view.live_scene import DARK, LIGHT

__all__ = ["StudioWindow"]

_TICK_MS = 12
_REST = 0.5  # of a picture's time, left to the hand's events before the next one
_UNTIMED = "This pen gives no times of its own; they are evened out"
_TOOLS, _SMALL_TOOLS = QtCore.QSize(19, 19), QtCore.QSize(16, 16)
_AROUND_TOOLS = 60  # pixels of the window's height that menus and status line take
_TOLD_EVERY_S = 0.25  # how the painting keeps up: oftener it cannot be read


class StudioWindow(QtWidgets.QMainWindow):
    """A painting in a window.

    Parameters
    ----------
    app : QApplication
    settings : Settings, optional
        A user's choices; what is chosen in the window is saved.
    dark : bool, optional
        Instead of the theme in the settings.
    plugged : PluggedDevices, optional
        Pens and 6-DOF mice.
    feel : callable, optional
        Starts the force feedback of a haptic stylus; see `BothHands`.
    """

    def __init__(
        self,
        app: QtWidgets.QApplication,
        settings: Settings | None = None,
        *,
        dark: bool | None = None,
        plugged: Plugged | None = None,
        feel: Callable[[Document], Feedback | None] | None = None,
    ) -> None:
        super().__init__()
        self._app = app
        self.settings = settings or Settings()
        choose_unit(self.settings.unit)
        self._system_dark = is_system_dark(app)
        dark = self.wants_dark() if dark is None else dark
        self.setObjectName("studio")
        self.theme = DARK_THEME if dark else LIGHT_THEME
        apply_theme(app, self.theme)
        self.canvas = Canvas()
        self.setCentralWidget(self.canvas)
        self.stage = Stage(self.canvas.pixel_size, DARK if dark else LIGHT)
        self.hand = CanvasHand(self.canvas, self.stage)
        self.steering = Steering(self.canvas, self.hand, lambda: self.theme)
        self.canvas.finger = self.settings.finger
        self.keys = HeldKeys(self, self.canvas, self.hand)
        self.files, self.standing = Files(self), Standing(self)
        self.player = Player(self)
        self.recalling = Recalling(self)
        self.painting, self.viewing = PaintActions(self), ViewActions(self)
        self.actions_by_name: dict[str, QtGui.QAction] = {}
        self.menus: dict[str, QtWidgets.QMenu] = {}
        self._make_actions()
        self.panels = Panels(self)
        self.copying, self.both_hands = Copying(self), BothHands(self, plugged, feel)
        for asked in (self.keys.tapped, self.steering.asked):
            asked.connect(lambda name: self.actions_by_name[name].trigger())
        self.hand.began.connect(self._forget_news)
        self.keys.alt_taken.connect(lambda: self.tell(say("hint.alt_taken"), state="bad"))
        for name, on in (("brush", True), ("dark", dark), ("grips", True), ("show_mask", True)):
            with QtCore.QSignalBlocker(self.actions_by_name[name]):
                self.actions_by_name[name].setChecked(on)
        self.hud = Hud(self)
        self.begin_page = BeginPage(self)
        self._show_open(False)
        self._make_status()
        self.hand.set_settings(
            curve=self.settings.curve,
            smoothing=self.settings.smoothing,
            pressure_by=self.settings.pressure_by,
        )
        self.hand.first_force = self.settings.force_n
        self.panels.hand.show_settings(self.hand.settings)
        self.resize(first_size(self))
        restore_window(self, self.settings.window)
        self._next_draw = self._next_told = 0.0
        self._timer = QtCore.QTimer(self)
        self._timer.setTimerType(QtCore.Qt.TimerType.PreciseTimer)
        self._guarded = TellOnce(lambda: self.tick(), self._tell_fault)
        self._timer.timeout.connect(self._guarded)
        self._timer.start(_TICK_MS)
        self.canvas.resized.connect(self._resized)
        self.canvas.dropped.connect(self.files.open_path)
        self.canvas.untimed.connect(lambda: self.tell(say(_UNTIMED)))

    # -- making it --------------------------------------------------------------------------

    def _make_actions(self) -> None:
        doers = (self.files, self.standing, self.painting, self.viewing)
        for name, actions in MENUS.items():
            menu = self.menuBar().addMenu(say(f"menu.{name}"))
            self.menus[name] = menu
            for action in actions:
                if action == "-":
                    menu.addSeparator()
                    continue
                do = next(getattr(d, f"do_{action}") for d in doers if hasattr(d, f"do_{action}"))
                menu.addAction(self._make_action(action, do))
                if action == "open":
                    self.recent_menu = menu.addMenu(say("menu.recent"))
                    self.unsaved_menu = menu.addMenu(say("Bring back what was not saved"))
                    menu.aboutToShow.connect(self.files.show_unsaved)
        bar = QtWidgets.QToolBar(say("Tools"))
        bar.setObjectName("tools")
        bar.setMovable(False)
        bar.setIconSize(_TOOLS)
        self.addToolBar(QtCore.Qt.ToolBarArea.LeftToolBarArea, bar)
        self.tools, self._tools_height = bar, None
        for name in TOOLS:
            if name == "-":
                bar.addSeparator()
            else:
                bar.addAction(self.actions_by_name[name])

    def _make_action(self, name: str, do: Callable) -> QtGui.QAction:
        text, keys = say(text_of(name)), keys_of(name)
        action = QtGui.QAction(text, self)
        if name not in self.keys.taps():
            action.setShortcuts([QtGui.QKeySequence(key) for key in keys])
        if name in ON_PICTURE:
            action.setShortcutContext(QtCore.Qt.ShortcutContext.WidgetShortcut)
            self.canvas.addAction(action)
        action.setToolTip(text.rstrip("…") + (f"  ({keys[0]})" if keys else ""))
        action.setCheckable(name in CHECKABLE)
        if name in ICONS_OF:
            action.setIcon(make_icon(ICONS_OF[name], self.theme))
        if name in CHECKABLE:
            action.toggled.connect(do)
        else:
            action.triggered.connect(lambda _=False: do())
        self.actions_by_name[name] = action
        return action

    def _make_status(self) -> None:
        self.told = QtWidgets.QLabel()  # as wide as there is room for, however long the text
        policy = QtWidgets.QSizePolicy.Policy
        self.told.setSizePolicy(policy.Ignored, policy.Preferred)
        self.state = QtWidgets.QLabel()
        self._told_state = self._state = "off"
        self.state.setObjectName("state")
        self.statusBar().addWidget(self.told, 1)
        self.statusBar().addPermanentWidget(self.state)
        self.statusBar().setSizeGripEnabled(False)
        self.statusBar().setContentsMargins(8, 0, 12, 0)
        self.tell(say("hint.turn"))

    # -- choices ----------------------------------------------------------------------------

    def wants_dark(self) -> bool:
        """Whether the settings ask for the dark theme."""
        dark = self.settings.theme == "dark"
        return dark or (self.settings.theme == "system" and self._system_dark)

    def set_dark(self, on: bool) -> None:
        """Change the theme."""
        self.theme = DARK_THEME if on else LIGHT_THEME
        apply_theme(self._app, self.theme)
        self.stage.set_mood(DARK if on else LIGHT)
        for name, icon in ICONS_OF.items():
            self.actions_by_name[name].setIcon(make_icon(icon, self.theme))
        self.panels.set_theme(self.theme)
        for label, state in ((self.told, self._told_state), (self.state, self._state)):
            label.setStyleSheet(f"color: {self.theme.state_colour(state)}")
        self.canvas.update()

    def keep(self, **changes: object) -> None:
        """Change settings, and save them."""
        self.settings = dataclasses.replace(self.settings, **changes)
        try:
            save_settings(self.settings)
        except Paint3DError as error:
            self.tell(say_error(error), state="bad")

    def show_unit(self) -> None:
        """Tell lengths in the unit of the settings."""
        choose_unit(self.settings.unit)
        self.panels.brushes.show_unit()
        self.panels.surface.show_unit()
        if self.stage.easel is not None:
            self.panels.surface.show_surface(self.document.surface)
        self.canvas.update()

    # -- the document -----------------------------------------------------------------------

    @property
    def document(self) -> Document:
        """What is being painted; only for reading, and what is posted changes it."""
        return self.stage.easel.document

    def show_document(self, opened: Opened) -> None:
        """Paint on this from now on; what was painted on before is let go of."""
        document = opened.document
        self.player.stop()
        if self._told_state != "bad":  # what was good news of the one before
            self.tell(say("hint.turn"))
        wet = self.settings.wants_wet(document.surface.material)
        self.keep_in_hand()
        self.stage.close_document()
        self._show_open(False)
        sitting = self._sitting(document)
        every = self.settings.autosave_s
        self.stage.open(opened, wet=wet, sitting=sitting, base_every_s=every)
        self._show_open(True)
        with QtCore.QSignalBlocker(self.actions_by_name["wet"]):
            self.actions_by_name["wet"].setChecked(wet)
        self.hand.open(opened.surface)
        self.both_hands.open(document)
        self.panels.open()
        self._draw_first()
        self.show_title()

    def _draw_first(self) -> None:
        """Have the picture there with the title; that of millions of triangles takes a while."""
        pixels = self.stage.draw()
        if pixels is not None:
            self.canvas.show_pixels(pixels)
            self.canvas.repaint()

    def _show_open(self, is_open: bool) -> None:
        """Let what needs a painting be asked for, or not; what was lit for another one goes out."""
        for name, action in self.actions_by_name.items():
            action.setEnabled((is_open and name not in ("undo", "redo")) or name in ALWAYS)
            if name in CHECKABLE and name not in ALWAYS:
                with QtCore.QSignalBlocker(action):
                    action.setChecked(False)
        self.panels.set_open(is_open)

    def _sitting(self, document: Document) -> Sitting | None:
        """Where what is painted is kept; without one, painting goes on and it is said."""
        try:
            return Sitting(document)
        except Paint3DError as error:
            self.tell(say_error(error), state="bad", stays=True)
            return None

    def show_title(self) -> None:
        """Name the painting, and say whether something is unsaved."""
        document = self.document
        name = document.path.name if document.path else described(document)
        self.setWindowTitle(f"{name}[*] – paint3d")
        self.setWindowModified(document.modified)

    # -- frame by frame ---------------------------------------------------------------------

    def tick(self) -> None:
        """Follow the easel, and draw when there is something new and time for it."""
        self.begin_page.show_page(self.stage.easel is None and not is_waiting(self))
        if self.stage.easel is None:
            return
        self.both_hands.tick()
        self.player.tick()
        self.copying.follow()
        if self.panels.show_brush_asked(self.stage.easel.brush):  # also while it is still to come
            self.hud.refresh()
        for event in self.stage.easel.take_events():
            refused = event.kind == "error"
            self.tell(
                say_error(event.error if refused else event.message),
                state="bad",
                stays=not refused or event.doing == "keeping",
            )
        if time.perf_counter() < self._next_draw:
            return
        started = time.thread_time()
        frame = self.stage.follow()
        if frame is not None:
            self._show_state(frame)
            self.panels.follow(frame)
        pixels = self.stage.draw()
        if pixels is not None:
            self.canvas.show_pixels(pixels)
            spent = time.thread_time() - started
            self._next_draw = time.perf_counter() + _REST * spent
        elif frame is not None:  # another brush or ink, while no brush is in the picture
            self.hud.refresh()

    def _show_state(self, frame) -> None:
        self.actions_by_name["undo"].setEnabled(frame.can_undo)
        self.actions_by_name["redo"].setEnabled(frame.can_redo)
        if self.isWindowModified() != self.document.modified:
            self.setWindowModified(self.document.modified)
        (state, text), now = keeping_up(frame), time.perf_counter()
        if state == self._state and now < self._next_told:
            return
        if state != self._state:
            self.state.setStyleSheet(f"color: {self.theme.state_colour(state)}")
        self._state, self._next_told = state, now + _TOLD_EVERY_S
        seen = ""
        if self.stage.picture_s > 0.0:  # something has been drawn
            every_s = max(1e-3 * _TICK_MS, (1.0 + _REST) * self.stage.picture_s)
            seen = "   ·   " + say("{fps:.0f} pictures/s", fps=1.0 / every_s)
        self.state.setText(f"{STATES[state]} {say('Painting')} {text}{seen}")

    def tell(self, text: str, *, state: str = "off", stays: bool = False) -> None:
        """Say something in the status line, marked by its shape.

        Parameters
        ----------
        text : str
        state : str
            One of `STATES`.
        stays : bool
            Whether it is so until something else is said; if not, the next stroke takes its place.
        """
        mark = "" if state == "off" else f"{STATES[state]}  "
        self._told_state, self._told_stays = state, stays
        self.told.setText(mark + text)
        self.told.setToolTip(text)
        self.told.setStyleSheet(f"color: {self.theme.state_colour(state)}")

    def _forget_news(self) -> None:
        """Leave off saying what was done or refused: something else is being painted."""
        if not self._told_stays:
            self.tell(say("hint.turn"))

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Draw the tools closer together where the window is low, so that none is lost."""
        super().resizeEvent(event)
        if self._tools_height is None:
            self._tools_height = self.tools.layout().sizeHint().height()
        tight = self._tools_height > event.size().height() - _AROUND_TOOLS
        if tight is self.tools.property("tight"):
            return
        self.tools.setProperty("tight", tight)
        self.tools.setIconSize(_SMALL_TOOLS if tight else _TOOLS)
        for widget in (self.tools, *self.tools.findChildren(QtWidgets.QToolButton)):
            widget.style().unpolish(widget)
            widget.style().polish(widget)
        self.tools.layout().invalidate()

    def _tell_fault(self, message: str) -> None:
        self.tell(say("problem.internal", message=message), state="bad")

    def _resized(self) -> None:
        if self._timer.isActive():
            self.stage.set_size(self.canvas.pixel_size)
        self.begin_page.place()

    def hold(self) -> None:
        """Draw and follow nothing until `go_on`."""
        self._timer.stop()

    def go_on(self) -> None:
        """Draw and follow again."""
        self.stage.touch()
        self._timer.start(_TICK_MS)

    def post(self, command: str, *arguments: object) -> None:
        """Have the easel do something; what goes wrong is told. Nothing, while nothing is open."""
        if self.stage.easel is not None:
            self.stage.easel.post(command, *arguments)

    def keep_in_hand(self) -> None:
        """Remember the brush, the inks and the force for the next painting."""
        if self.stage.easel is None:
            return
        chosen = in_hand(self.stage.easel.brush, list(self.document.inks))
        force = self.hand.hand.force if self.hand.hand is not None else self.settings.force_n
        self.settings = dataclasses.replace(self.settings, **chosen, force_n=force)

    def event(self, event: QtCore.QEvent) -> bool:
        """End a stroke that a dialog or a bar interrupts: it will not hear of the pen's lift."""
        if event.type() == QtCore.QEvent.Type.WindowBlocked and self.stage.easel is not None:
            self.hand.interrupt()
        return super().event(event)

    def closeEvent(self, event: QtGui.QCloseEvent) -> None:
        """Ask about what is unsaved, then let go of everything."""
        if not self.files.may_leave():
            event.ignore()
            return
        self._timer.stop()
        self.both_hands.close()
        self.panels.close_down()
        self.keep_in_hand()
        self.keep(smoothing=self.hand.settings.smoothing, window=window_words(self))
        self.stage.close()
        event.accept()
