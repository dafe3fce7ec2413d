"""The studio's window: menus, tools, panels and the picture in their middle."""

from __future__ import annotations

import math
import sys
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.frame import PaintingFrame
from paint3d.app.model.input.devices import Devices, Feeling
from paint3d.app.model.paint_thread import Event
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder
from paint3d.app.model.persistence.settings import Settings
from paint3d.app.window.actions import Actions
from paint3d.app.window.brush.brush_making import BrushMaking
from paint3d.app.window.copybook.copybook_guide import CopybookGuide
from paint3d.app.window.copybook.text_writing import TextWriting
from paint3d.app.window.files.begin_page import BeginPage
from paint3d.app.window.files.exporting import Exporting
from paint3d.app.window.files.open_result import OpenResult, described
from paint3d.app.window.files.opening import Opening
from paint3d.app.window.files.recovery import Recovery
from paint3d.app.window.files.saving import RecentFiles, Saving
from paint3d.app.window.files.target_dialog import Targets
from paint3d.app.window.forms import leave_wheel_to_scrolling
from paint3d.app.window.garbage import collect_later
from paint3d.app.window.hand.device_input import DeviceInput
from paint3d.app.window.hand.keys import HeldKeys
from paint3d.app.window.hand.steering import Steering
from paint3d.app.window.history.stroke_editing import Recalling, StrokeEditing
from paint3d.app.window.history.stroke_mark import StrokeMark
from paint3d.app.window.hud import Hud
from paint3d.app.window.ink.ink_making import InkMaking
from paint3d.app.window.lamp import Lamp
from paint3d.app.window.object.detail import Detail
from paint3d.app.window.object.standing import Standing
from paint3d.app.window.paint_actions import PaintActions
from paint3d.app.window.panels import Panels
from paint3d.app.window.playing.pictures import Pictures
from paint3d.app.window.playing.player import Player
from paint3d.app.window.playing.recordings import Recordings
from paint3d.app.window.reference.reference import Reference
from paint3d.app.window.seal import Sealing
from paint3d.app.window.status_line import ReplayBar, StatusLine
from paint3d.app.window.theme import DARK_THEME
from paint3d.app.window.tour import Tour
from paint3d.app.window.view_actions import ViewActions
from paint3d.app.window.view_keeping import ViewKeeping
from paint3d.app.window.wording import say, say_error
from paint3d.app.window.workspace import Workspace
from paint3d.colour.materials import Material
from paint3d.errors import Message, Paint3DError

__all__ = ["StudioWindow"]

# ---- Size, position and panels -------------------------------------------------------------------
# As the settings store them.


_VERSION = 1  # of the arrangement of tool bars and panels: another one is not restored
_SIZE = QtCore.QSize(1280, 800)
_FRAME = QtCore.QSize(2, 38)  # that a window manager puts around it, about


def first_size(window: QtWidgets.QMainWindow) -> QtCore.QSize:
    """Return a window's size at its first opening: no larger than its screen."""
    available = window.screen().availableGeometry().size() - _FRAME
    return _SIZE.boundedTo(available).expandedTo(window.minimumSizeHint())


def window_words(window: QtWidgets.QMainWindow) -> dict[str, object]:
    """Return the state that `restore_window` takes, as JSON can hold it."""
    return {
        "geometry": _text(window.saveGeometry()),
        "panels": _text(window.saveState(_VERSION)),
    }


def restore_window(window: QtWidgets.QMainWindow, words: Mapping[str, object]) -> None:
    """Restore a window's size, position and panels; what cannot be used is ignored.

    Qt moves what would lie beside the screens back onto one.
    """
    geometry, panels = words.get("geometry"), words.get("panels")
    if isinstance(geometry, str):
        window.restoreGeometry(_bytes(geometry))
    if isinstance(panels, str):
        window.restoreState(_bytes(panels), _VERSION)


def _text(data: QtCore.QByteArray) -> str:
    return bytes(data.toBase64().data()).decode("ascii")


def _bytes(text: str) -> QtCore.QByteArray:
    return QtCore.QByteArray.fromBase64(text.encode("utf-8", "replace"))


# ---- Faults of timers ----------------------------------------------------------------------------
# A timer repeats its action, and must not repeat its error messages.


class ReportOnce:
    """Runs an action and reports each distinct exception once, by where it was raised.

    Parameters
    ----------
    action : callable
    tell : callable
        Called with the fault's text, for the user.
    """

    def __init__(self, action: Callable[[], object], tell: Callable[[str], object]) -> None:
        self._action, self._tell = action, tell
        self._known: set[tuple[object, ...]] = set()

    def __call__(self) -> None:
        """Run the action; report an exception that is new."""
        try:
            self._action()
        except Exception as error:  # the next call may well succeed
            last = traceback.extract_tb(error.__traceback__)[-1]
            fault = type(error), last.filename, last.lineno
            if fault not in self._known:
                self._known.add(fault)
                sys.excepthook(type(error), error, error.__traceback__)
                self._tell(f"{type(error).__name__}: {error}")


# ---- The window ----------------------------------------------------------------------------------


_TICK_MS = 12
_RESTING_S, _REST_TICK_MS = 2.0, 80  # after which ticks come less often, and how often
_REST = 0.25  # of a picture's time, left to hand and painting before the next one
_UNTIMED = Message("This pen reports no times; its events are spaced evenly")
_MISREAD = Message("This pen reports pressures outside 0 to 1; they are clipped")


class StudioWindow(QtWidgets.QMainWindow):
    """The window: makes the parts, and connects them.

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
        Starts the force feedback of a haptic stylus; see `DeviceInput`.

    Attributes
    ----------
    workspace : Workspace
        What the parts have in common.
    """

    def __init__(
        self,
        app: QtWidgets.QApplication,
        settings: Settings | None = None,
        *,
        dark: bool | None = None,
        plugged: Devices | None = None,
        feel: Callable[[Document, Settings], Feeling | None] | None = None,
    ) -> None:
        super().__init__()
        self.setObjectName("studio")
        workspace = self.workspace = Workspace(self, app, settings or Settings(), dark)
        self.canvas, self.stage, self.hand = workspace.canvas, workspace.stage, workspace.hand
        self.setCentralWidget(self.canvas)
        self.steering = Steering(self.canvas, self.hand, lambda: workspace.theme)
        self.keys = HeldKeys(self, self.canvas, self.hand)
        self.commands = Actions(workspace, self.keys.taps())
        self.panels = Panels(workspace, self.commands.menus["window"])
        for dock in self.panels.docks.values():
            leave_wheel_to_scrolling(dock)
        self._make_jobs()
        self.copying = CopybookGuide(workspace, self.panels.copybook)
        self.writing = TextWriting(
            workspace, self.player, self.copying.chosen_text,
            lambda em_mm: self.copying.change({"em_mm": em_mm}), self.detail,
        )  # fmt: skip
        self.copying.laid_out = self.writing.prepare
        self.sealing.of_signature = self.copying.signature
        self.sealing.is_writing = lambda: self.player.is_playing
        self.tour = Tour(workspace, self.opening, self.copying)
        self._bind_actions()
        self.both_hands = DeviceInput(workspace, self.panels.devices, plugged, feel)
        self.hud, self.status = Hud(workspace), StatusLine(workspace)
        self.replay_bar = ReplayBar(workspace, self.player)
        self.begin_page = BeginPage(workspace, self.opening, self.recovery, self.recent)
        self._show_open(False)
        self._take_settings()
        self._next_draw = 0.0
        self._collector = collect_later(self)
        self._timer = QtCore.QTimer(self)
        self._timer.setTimerType(QtCore.Qt.TimerType.PreciseTimer)
        # a lambda, as tests and scripts may put another `tick` there
        self._guarded = ReportOnce(lambda: self.tick(), self._tell_fault)
        self._timer.timeout.connect(self._guarded)
        self._connect()
        self._timer.start(_TICK_MS)

    # -- parts ------------------------------------------------------------------------------

    def _make_jobs(self) -> None:
        workspace, history = self.workspace, self.panels.history
        self.targets = Targets(workspace)
        self.recent = RecentFiles(workspace, self.commands.recent)
        self.saving = Saving(workspace, self.targets, self.recent)
        self.recovery = Recovery(workspace, self.commands.unsaved, self.saving.may_leave)
        self.standing = Standing(workspace, self.saving.may_leave)
        self.opening = Opening(workspace, self.saving, self.standing, self.recent)
        self.pictures = Pictures(workspace, self.targets)
        self.exporting = Exporting(workspace, self.targets, self.pictures)
        self.player = Player(workspace)
        self.recordings = Recordings(
            workspace, self.targets, self.player, history.speed, self.saving.may_leave,
            lambda mesh, mm, material: self.opening.open_path(mesh, mm, material, asked=True),
        )  # fmt: skip
        self.recalling = Recalling(workspace, history.refuse)
        self.mark = StrokeMark(workspace)
        self.editing = StrokeEditing(workspace, self.mark)
        self.sealing = Sealing(workspace)
        self.detail = Detail(workspace)

    def _bind_actions(self) -> None:
        self.painting = PaintActions(self.workspace, self.panels, self.recalling, self.player)
        self.brushes = BrushMaking(self.workspace, self.panels)
        self.inks = InkMaking(self.workspace, self.panels)
        self.reference = Reference(
            self.workspace, self.panels.reference, self.copying, self.inks.mix_colour
        )
        self.lamp = Lamp(self.workspace)
        self.views = ViewKeeping(self.workspace, self.lamp)
        self.viewing = ViewActions(self.workspace, self.panels, self.steering)
        self.commands.bind(
            (self.opening, self.saving, self.exporting, self.pictures, self.recordings,
             self.standing, self.detail, self.sealing, self.copying, self.writing, self.editing,
             self.painting, self.brushes, self.inks, self.reference, self.views, self.lamp,
             self.viewing, self.tour)
        )  # fmt: skip
        for name in ("brush", "grips", "show_mask"):
            self.commands.check(name, True)
        self.commands.check("dark", self.workspace.theme is DARK_THEME)

    def _take_settings(self) -> None:
        settings = self.workspace.settings
        self.canvas.finger = settings.finger
        self.hand.set_settings(
            curve=settings.curve,
            smoothing=settings.smoothing,
            mouse_smoothing=settings.mouse_steadiness,
            pressure_by=settings.pressure_by,
        )
        self.hand.set_force(settings.force_n)
        self.panels.hand.show_settings(self.hand.settings)
        self.panels.hand.show_force(self.hand.force)
        self.resize(first_size(self))
        restore_window(self, settings.window)

    def _connect(self) -> None:
        """Connect the parts' signals."""
        workspace, panels = self.workspace, self.panels
        workspace.opened.connect(self._show_document)
        workspace.saved.connect(self._show_title)
        workspace.held.connect(self._hold)
        for asked in (self.keys.tapped, self.steering.asked):
            asked.connect(self.commands.trigger)
        self.keys.alt_taken.connect(
            lambda: workspace.tell(
                say("Alt moves the window here: hold Space and drag to turn the view"), state="bad"
            )
        )
        # first the message of before is removed, then a replay that gives way leaves its own
        self.hand.began.connect(self.status.forget_passing)
        self.hand.began.connect(self.player.give_way)
        self.hand.began.connect(self.panels.history.give_way)
        self.player.moved.connect(self._allow_undo)
        self.player.moved.connect(lambda share: self.sealing.say_how() if share < 0.0 else None)
        canvas = self.canvas
        for moved in (canvas.touched, canvas.steered, canvas.gestured, canvas.wheeled):
            moved.connect(self._wake)
        self.canvas.resized.connect(self._resized)
        self.canvas.dropped.connect(self.opening.open_path)
        self.canvas.untimed.connect(lambda: workspace.tell(say(_UNTIMED)))
        self.canvas.misread.connect(lambda: workspace.tell(say(_MISREAD), state="bad", stays=True))
        self.recent.chosen.connect(self.opening.open_path)
        self.commands.menus["file"].aboutToShow.connect(self.recovery.fill_menu)
        panels.history.asked.connect(self.recalling.go_to)
        panels.surface.asked.connect(self._take_material)
        panels.history.edited.connect(self.editing.ask)
        panels.history.seal_edited.connect(self.sealing.edit)
        panels.history.chosen.connect(self.mark.choose)
        self.mark.changed.connect(panels.history.mark)
        panels.history.exported.connect(self.recordings.do_save_recording)
        panels.copybook.written.connect(self.writing.do_write_text)
        panels.copybook.sealed.connect(self.sealing.do_seal)
        panels.hand.turns.connect(self.painting.set_turns)
        panels.hand.mask_degrees.connect(self.painting.set_mask_degrees)

    def _take_material(self, material: str | Material) -> None:
        """Begin anew in another material; if that is declined, show the current one."""
        if not self.standing.take_material(material):
            self.panels.surface.show_surface(self.workspace.painting)

    # -- the document -----------------------------------------------------------------------

    @property
    def document(self) -> Document:
        """The document, for scripts and tests that look on: the window reads `painting`.

        The current step has ended, if it does so within a second.
        """
        return self.workspace.paint_thread.look(1.0)

    def _show_document(self, opened: OpenResult) -> None:
        """Close the painting before, and show another one."""
        document, settings = opened.document, self.workspace.settings
        self.player.stop()
        self.status.forget_good()
        wet = settings.wants_wet(document.surface.material)
        self.workspace.remember_in_hand()
        self.stage.close_document()
        self._show_open(False)
        recovery: RecoveryFolder | None = None
        try:
            recovery = RecoveryFolder(document)
        except Paint3DError as error:  # painting goes on without
            self.workspace.tell(say_error(error), state="bad", stays=True)
        self.stage.open(opened, wet=wet, recovery=recovery, autosave_interval_s=settings.autosave_s)
        self._show_open(True)
        self.commands.check("wet", wet)
        self.hand.open(opened.surface)
        self.views.recall_last(document)
        self.both_hands.open()
        self.panels.open()
        pixels = self.stage.draw()
        if pixels is not None:  # with the title: millions of triangles take a while
            self.canvas.show_pixels(pixels)
            self.canvas.repaint()
        self._show_title()
        self._collector.start()

    def _show_open(self, is_open: bool) -> None:
        """Enable or disable commands and panels that need a painting."""
        self.commands.set_open(is_open)
        self.panels.set_open(is_open)

    def _show_title(self) -> None:
        """Show the painting's name, and whether something is unsaved."""
        painting = self.workspace.painting
        name = (
            painting.path.name if painting.path else described(painting.source, painting.material)
        )
        self.setWindowTitle(f"{name}[*] – paint3d")
        self.setWindowModified(painting.modified)

    # -- frame by frame ---------------------------------------------------------------------

    def tick(self) -> None:
        """Follow the painting thread, and draw when there is something new and time for it."""
        if self._timer.interval() != _TICK_MS:
            self._timer.setInterval(_TICK_MS)
        self.begin_page.show_page(self.stage.paint_thread is None and not self.workspace.is_waiting)
        if self.stage.paint_thread is None:
            return
        self.stage.paint_thread.heartbeat()
        self.both_hands.tick()
        self.player.tick()
        self.copying.follow()
        self.mark.follow()
        self.panels.hand.show_force(self.hand.force)
        if self.panels.show_brush_asked(
            self.stage.paint_thread.brush
        ):  # also while it is still to come
            self.hud.refresh()
        for event in self.stage.paint_thread.take_events():
            self._tell_event(event)
        if time.perf_counter() < self._next_draw:
            return
        is_still = self.stage.is_drawn and not self.player.is_playing
        if is_still and self.stage.rested_s > _RESTING_S:
            self._tick_in(1e-3 * _REST_TICK_MS)
        started = time.thread_time()
        frame = self.stage.follow()
        if frame is not None:
            self._show_state(frame)
            self.panels.follow(frame)
        pixels = self.stage.draw()
        if pixels is not None:
            self.canvas.show_pixels(pixels, self.stage.changed)
            self.hud.follow()
            # rest after painting alone: where only the view has moved, nothing waits for the time
            rest = _REST * (time.thread_time() - started) if frame is not None else 0.0
            self._next_draw = time.perf_counter() + rest
            self._tick_in(rest)
        elif frame is not None:  # another brush or ink, while no brush is in the picture
            self.hud.refresh()

    def _tick_in(self, seconds: float) -> None:
        """Delay the next tick by so long; later ones come as always."""
        if self._timer.isActive():  # `_hold` may have stopped it
            self._timer.start(max(1, math.ceil(1e3 * seconds)))

    def _wake(self) -> None:
        """Tick often again at once: a hand has moved over the picture."""
        if self._timer.isActive() and self._timer.interval() > _TICK_MS:
            self._timer.start(_TICK_MS)

    def _tell_event(self, event: Event) -> None:
        if event.kind == "kept":
            self.workspace.tell(say("Recovery data is being saved again"), state="good")
            return
        refused, keeping = event.kind == "error", event.doing == "keeping"
        message = say_error((event.error if refused else None) or event.message)
        if keeping:
            message = say("Recovery data cannot be saved: {message}", message=message)
        self.workspace.tell(message, state="bad", stays=not refused or keeping)

    def _show_state(self, frame: PaintingFrame) -> None:
        workspace = self.workspace
        workspace.actions["undo"].setEnabled(frame.painting.can_undo or self.player.is_playing)
        workspace.actions["redo"].setEnabled(frame.painting.can_redo)
        if self.isWindowModified() != frame.painting.modified:
            self.setWindowModified(frame.painting.modified)
        picture_s = None
        if self.stage.picture_s > 0.0:  # something has been drawn
            picture_s = max(1e-3 * _TICK_MS, (1.0 + _REST) * self.stage.picture_s)
        self.status.show(frame, picture_s, plays=self.player.is_playing)

    def _allow_undo(self, fraction: float) -> None:
        """Enable undo for a replay."""
        if fraction >= 0.0:
            self.workspace.actions["undo"].setEnabled(True)

    def _tell_fault(self, message: str) -> None:
        self.workspace.tell(say("Internal error: {message}", message=message), state="bad")

    def _resized(self) -> None:
        if self._timer.isActive():
            self.stage.set_size(self.canvas.pixel_size)
        self.begin_page.place()

    def _hold(self, on: bool) -> None:
        if on:
            self._timer.stop()
        else:
            self._timer.start(_TICK_MS)

    # -- the window's own events ------------------------------------------------------------

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Fit the tools and the inks into the new height."""
        super().resizeEvent(event)
        self.commands.fit(event.size().height())
        self.panels.inks.fit(event.size().height())

    def event(self, event: QtCore.QEvent) -> bool:
        """End a stroke that a dialog or a bar interrupts, which gets the pen's release itself."""
        if event.type() == QtCore.QEvent.Type.WindowBlocked and self.stage.paint_thread is not None:
            self.hand.interrupt()
        return super().event(event)

    def closeEvent(self, event: QtGui.QCloseEvent) -> None:
        """Ask about unsaved work, then close everything."""
        if not (self.saving.may_leave() and self.workspace.may_let_go()):
            event.ignore()
            return
        self._timer.stop()
        self.both_hands.close()
        self.panels.close_down()
        self.brushes.close_down()
        self.inks.close_down()
        self.workspace.remember_in_hand()
        now, settings = self.hand.settings, self.workspace.settings
        if now.mouse_smoothing != settings.mouse_steadiness:
            settings = replace(settings, mouse_smoothing=now.mouse_smoothing)
        self.workspace.settings = settings
        self.workspace.update_settings(smoothing=now.smoothing, window=window_words(self))
        self.stage.close()
        event.accept()
