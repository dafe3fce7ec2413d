"""The studio's window: menus, tools, panels and the picture in their middle."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.sitting import Sitting
from paint3d.app.model.symmetry import MirrorPlane, Symmetry
from paint3d.app.window.canvas import Canvas
from paint3d.app.window.commands import COMMANDS, MENUS, TOOLS, Command
from paint3d.app.window.files import Files
from paint3d.app.window.hand import CanvasHand
from paint3d.app.window.hud import Hud
from paint3d.app.window.icons import make_icon
from paint3d.app.window.panels import Panels
from paint3d.app.window.stage import Stage
from paint3d.app.window.theme import DARK_THEME, LIGHT_THEME, STATES, apply_theme
from paint3d.app.window.wording import say
from paint3d.errors import Paint3DError
from paint3d.view.live_scene import DARK, LIGHT

__all__ = ["StudioWindow"]

_TICK_MS = 12
_REST = 0.5  # of a picture's time, left to the hand's events before the next one
_SLOW_S = 0.1  # what was painted last had waited so long: it is said to be behind
_TOLD_MS = 6000


class StudioWindow(QtWidgets.QMainWindow):
    """A painting in a window.

    Parameters
    ----------
    app : QApplication
    dark : bool
    """

    def __init__(self, app: QtWidgets.QApplication, *, dark: bool = False) -> None:
        super().__init__()
        self._app = app
        self.setObjectName("studio")
        self.theme = DARK_THEME if dark else LIGHT_THEME
        apply_theme(app, self.theme)
        self.canvas = Canvas()
        self.setCentralWidget(self.canvas)
        self.stage = Stage(self.canvas.pixel_size, DARK if dark else LIGHT)
        self.hand = CanvasHand(self.canvas, self.stage)
        self.files = Files(self)
        self.actions_by_name: dict[str, QtGui.QAction] = {}
        self._make_actions()
        self.panels = Panels(self)
        self.hud = Hud(self)
        self._make_status()
        self.resize(1280, 800)
        self._next_draw = 0.0
        self._timer = QtCore.QTimer(self)
        self._timer.setTimerType(QtCore.Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self.tick)
        self._timer.start(_TICK_MS)
        self.canvas.resized.connect(self._resized)
        self.canvas.dropped.connect(self.files.open_path)

    # -- making it --------------------------------------------------------------------------

    def _make_actions(self) -> None:
        menus: dict[str, QtWidgets.QMenu] = {}
        for name, text in MENUS.items():
            menus[name] = self.menuBar().addMenu(say(text))
        self.recent_menu = QtWidgets.QMenu(say("Open recent"), self)
        for command in COMMANDS:
            if command.name == "-":
                menus[command.menu].addSeparator()
                continue
            menus[command.menu].addAction(self._make_action(command))
            if command.name == "open":
                menus["file"].addMenu(self.recent_menu)
        self.layer_menu = menus["layers"]
        self.view_menu = menus["view"]
        bar = QtWidgets.QToolBar(say("Tools"))
        bar.setObjectName("tools")
        bar.setMovable(False)
        bar.setIconSize(QtCore.QSize(20, 20))
        self.addToolBar(QtCore.Qt.ToolBarArea.LeftToolBarArea, bar)
        for name in TOOLS:
            if name == "-":
                bar.addSeparator()
            else:
                bar.addAction(self.actions_by_name[name])

    def _make_action(self, command: Command) -> QtGui.QAction:
        action = QtGui.QAction(say(command.text), self)
        action.setShortcuts([QtGui.QKeySequence(key) for key in command.keys])
        keys = f"  ({command.keys[0]})" if command.keys else ""
        action.setToolTip(say(command.text).rstrip("…") + keys)
        action.setCheckable(command.checkable)
        if command.icon:
            action.setIcon(make_icon(command.icon, self.theme))
        do: Callable = getattr(self, f"do_{command.name}")
        if command.checkable:
            action.toggled.connect(do)
        else:
            action.triggered.connect(lambda _=False: do())
        self.actions_by_name[command.name] = action
        return action

    def _make_status(self) -> None:
        self.told = QtWidgets.QLabel()
        self.state = QtWidgets.QLabel()
        self.state.setObjectName("state")
        self.statusBar().addWidget(self.told, 1)
        self.statusBar().addPermanentWidget(self.state)
        self.statusBar().setSizeGripEnabled(False)
        self.tell(say("Paint with the left button or a pen; turn with Alt or the middle button"))

    # -- the document -----------------------------------------------------------------------

    @property
    def document(self) -> Document:
        """What is being painted; only for reading, and what is posted changes it."""
        return self.stage.easel.document

    def show_document(self, document: Document) -> None:
        """Paint on this from now on; what was painted on before is let go of."""
        wet = self.actions_by_name["wet"].isChecked()
        self.stage.close_document()
        self.stage.open(document, wet=wet, sitting=self._sitting(document))
        self.hand.open()
        self.panels.open()
        self.show_title()

    def _sitting(self, document: Document) -> Sitting | None:
        """Where what is painted is kept; without one, painting goes on and it is said."""
        try:
            return Sitting(document)
        except Paint3DError as error:
            self.tell(str(error), state="bad")
            return None

    def show_title(self) -> None:
        """Name the painting, and say whether something is unsaved."""
        document = self.document
        name = document.path.name if document.path else say(document.surface.source.name)
        self.setWindowTitle(f"{name}[*] – paint3d")
        self.setWindowModified(document.modified)

    # -- frame by frame ---------------------------------------------------------------------

    def tick(self) -> None:
        """Follow the easel, and draw when there is something new and time for it."""
        if self.stage.easel is None:
            return
        now = time.perf_counter()
        frame = self.stage.follow()
        if frame is not None:
            self._show_state(frame)
            self.panels.follow(frame)
        for event in self.stage.easel.take_events():
            self.tell(event.message, state="bad")
        if now < self._next_draw:
            return
        pixels = self.stage.draw()
        if pixels is not None:
            self.canvas.show_pixels(pixels)
            self._next_draw = time.perf_counter() + _REST * self.stage.scene.frame_s

    def _show_state(self, frame) -> None:
        self.actions_by_name["undo"].setEnabled(frame.can_undo)
        self.actions_by_name["redo"].setEnabled(frame.can_redo)
        self.setWindowModified(self.document.modified)
        slow = frame.lag_s > _SLOW_S
        word = say("behind by {ms:.0f} ms") if slow else say("keeps up, {ms:.1f} ms")
        state = "slow" if slow else "good"
        text = word.format(ms=1e3 * frame.lag_s)
        seen = say("{fps:.0f} pictures/s").format(fps=1.0 / max(self.stage.scene.frame_s, 1e-3))
        self.state.setText(f"{STATES[state]} {say('Painting')} {text}   ·   {seen}")
        self.state.setStyleSheet(f"color: {self.theme.state_colour(state)}")

    def tell(self, text: str, *, state: str = "off") -> None:
        """Say something in the status line, marked by its shape."""
        mark = "" if state == "off" else f"{STATES[state]}  "
        self.told.setText(mark + text)
        self.told.setStyleSheet(f"color: {self.theme.state_colour(state)}")

    def _resized(self) -> None:
        self.stage.set_size(self.canvas.pixel_size)
        self.hand.resized()

    def post(self, command: str, *arguments: object) -> None:
        """Have the easel do something; what goes wrong is told."""
        self.stage.easel.post(command, *arguments)

    def closeEvent(self, event: QtGui.QCloseEvent) -> None:
        """Ask about what is unsaved, then let go of everything."""
        if not self.files.may_leave():
            event.ignore()
            return
        self._timer.stop()
        self.panels.close_down()
        self.stage.close()
        event.accept()

    # -- what can be asked for: one method a command ----------------------------------------

    def do_new(self) -> None:
        """Begin a painting."""
        self.files.new()

    def do_open(self) -> None:
        """Ask for a file, and open it."""
        self.files.open()

    def do_save(self) -> None:
        """Save where it was saved before."""
        self.files.save()

    def do_save_as(self) -> None:
        """Ask where to save."""
        self.files.save_as()

    def do_export(self) -> None:
        """Ask for a name, whose suffix is the format."""
        self.files.export()

    def do_save_recording(self) -> None:
        """Save the strokes of this sitting."""
        self.files.save_recording()

    def do_replay(self) -> None:
        """Paint a recording on what is here."""
        self.files.replay()

    def do_screenshot(self) -> None:
        """Save the picture as it is seen."""
        self.files.screenshot()

    def do_turntable(self) -> None:
        """Save a film of the object turning."""
        self.files.turntable()

    def do_quit(self) -> None:
        """Leave."""
        self.close()

    def do_undo(self) -> None:
        """Take the last step back."""
        self.post("undo")

    def do_redo(self) -> None:
        """Do it again."""
        self.post("redo")

    def do_dry(self) -> None:
        """Let everything dry at once."""
        self.post("dry")

    def do_wet(self, on: bool) -> None:
        """Let ink spread in real time, or not."""
        if self.stage.easel is not None:
            self.stage.easel.wet = on

    def do_frame_all(self) -> None:
        """See the whole object."""
        self.hand.frame()

    def do_front(self) -> None:
        """See it from the front."""
        self.hand.frame("front")

    def do_right(self) -> None:
        """See it from the right."""
        self.hand.frame("right")

    def do_top(self) -> None:
        """See it from above."""
        self.hand.frame("top")

    def do_show_brush(self, on: bool) -> None:
        """Draw the brush, or not."""
        self.stage.shows_brush = on
        if not on:
            self.stage.hide_brush()

    def do_dark(self, on: bool) -> None:
        """Change the theme."""
        self.theme = DARK_THEME if on else LIGHT_THEME
        apply_theme(self._app, self.theme)
        self.stage.set_mood(DARK if on else LIGHT)
        for command in COMMANDS:
            if command.icon:
                self.actions_by_name[command.name].setIcon(make_icon(command.icon, self.theme))
        self.panels.set_theme(self.theme)

    def do_full_screen(self, on: bool) -> None:
        """Fill the screen, or not."""
        self.showFullScreen() if on else self.showNormal()

    def do_english(self) -> None:
        """Speak English from the next start."""
        self.files.choose_language("en")

    def do_chinese(self) -> None:
        """Speak Chinese from the next start."""
        self.files.choose_language("zh")

    def do_dip(self) -> None:
        """Load the brush again."""
        self.post("dip")

    def do_rinse(self) -> None:
        """Wash the brush out."""
        self.post("rinse")

    def do_wipe(self) -> None:
        """Wipe half of the ink off."""
        self.post("wipe")

    def do_swap_inks(self) -> None:
        """Take the other ink."""
        self.post("swap_inks")

    def do_pick(self) -> None:
        """Take the ink that lies under the pointer."""
        self.hand.pick()

    def do_smaller(self) -> None:
        """Take a smaller brush of the same kind."""
        self.post("step_brush", -1)

    def do_larger(self) -> None:
        """Take a larger brush of the same kind."""
        self.post("step_brush", 1)

    def do_mirror(self, on: bool) -> None:
        """Paint left and right at once."""
        self.post("set_symmetry", self._symmetry() if on else Symmetry())

    def _symmetry(self) -> Symmetry:
        """The plane through the object's middle that parts left from right."""
        low, high = self.stage.points.min(axis=0), self.stage.points.max(axis=0)
        middle = tuple(float(x) for x in 0.5 * (low + high))
        return Symmetry((MirrorPlane(middle, (1.0, 0.0, 0.0)),))

    def do_keys(self) -> None:
        """Show all keys and gestures."""
        self.files.show_keys()

    def do_about(self) -> None:
        """Say what this is."""
        self.files.show_about()
