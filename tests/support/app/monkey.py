"""A monkey at the window: does anything at random, and sees whether the studio stands it.

Each action has its own random numbers, from the seed and its number, so that a part of them can be
done again (`Monkey.run` with `only`). What happens inside nested loops (a dialog, a bar) is done by
a timer: dialogs are answered at random, and while something loads without one, work goes on.
"""

from __future__ import annotations

import faulthandler
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.random import Generator
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.commands import SHORTCUTS
from paint3d.app.model.document import Document
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.window.studio import StudioWindow
from paint3d.errors import Paint3DError
from tests.support.app.event_player import DeviceEvent, EventPlayer
from tests.support.app.windows import pretend_saved

__all__ = ["Fault", "Monkey"]

POKE_MS = 5
DEEPEST = 3  # actions within actions: a load that is left to itself, and what is done meanwhile
STUCK_S = 60.0  # the main thread did not come round for so long: its stack is told
SLOW_S = 2.0
SETTLE_S = 180.0
OBJECTS = ("plane", "bowl", "sphere", "plate")
COARSE_MM = (2.0, 4.0)
NAMES = (
    "a.p3d", "b.p3d", "c", "d.glb", "e.ply", "f.png", "g.gif", "h.jsonl", "永.p3d", "", "bad.ply",
    "notes.txt", "notes.txt/under.p3d", "missing/x.p3d",
)  # fmt: skip
HARMLESS = (
    "Could not parse",
    "XDG_RUNTIME_DIR",
    "propagateSizeHints",
    "does not support",
    "QXcbConnection",
    "Populating font",
    "no target window",
    "Wayland",
)
WHOLE = QtWidgets.QSpinBox | QtWidgets.QAbstractSlider
ACTIONS = {
    "stroke": 14, "menu": 14, "key": 14, "click_panel": 16, "drag": 6, "wheel": 4, "hover": 3,
    "open_object": 2, "drop_file": 1.5, "undo_storm": 2, "switch_while_behind": 3, "fingers": 2,
    "resize": 1, "crash": 0.3, "rest": 5,
}  # fmt: skip
"""Methods of `Monkey`, and how often each is taken."""
QUIT = ("quit", "full_screen")
"""Actions that are done rarely."""


@dataclass(frozen=True)
class Fault:
    """Something that must not be.

    Attributes
    ----------
    number : int
        Of the action.
    kind : {"traceback", "internal", "qt", "stuck", "slow", "state", "session"}
    text : str
    """

    number: int
    kind: str
    text: str

    def short(self) -> str:
        """Its last line, by which alike ones are known."""
        lines = [line for line in self.text.strip().splitlines() if line.strip()]
        return f"{self.kind}: {lines[-1] if lines else ''}"


@dataclass
class _Hooks:
    """The hooks that were installed before the monkey's own."""

    excepthook: object = None
    thread_hook: object = None
    messages: object = None
    tell: object = None
    unraisable: object = None


class Monkey(QtCore.QObject):
    """Acts on a window of its own.

    Parameters
    ----------
    app : QApplication
    folder : Path
        Where it opens and saves; dialogs begin there.
    seed : int
    start : str, optional
        What is opened in a new window; by default nothing is.

    Attributes
    ----------
    actions : dict
        Names of its methods, and how often each is taken.
    faults : list of Fault
    done : list of str
        What it did, one after the other.
    slowest_s : float
        The longest that the window did not come round.
    """

    def __init__(
        self, app: QtWidgets.QApplication, folder: Path, seed: int = 0, start: str | None = None
    ) -> None:
        super().__init__()
        self._app, self.folder, self.seed, self.start = app, folder, seed, start
        self.actions = dict(ACTIONS)
        self.faults: list[Fault] = []
        self.done: list[str] = []
        self.number = -1
        self.slowest_s = 0.0
        self._depth = 0
        self._rng = np.random.default_rng(seed)
        self._last_round = time.monotonic()
        self._hooks = _Hooks()
        self._fill_folder()
        self._poking = self._starting = self._touching = False
        self._new_window()

    # -- running ----------------------------------------------------------------------------

    def run(
        self,
        n: int,
        only: Iterable[int] | None = None,
        told: Callable[[int, list[Fault]], None] | None = None,
    ) -> list[Fault]:
        """Do so many actions, or only those of these numbers; what went wrong.

        At the end the painting is saved, opened and compared.
        """
        self._hook()
        self._poking = True
        self._poke()
        watch = threading.Thread(target=self._watch, daemon=True)
        self._watching = True
        watch.start()
        try:
            for number in range(n) if only is None else only:
                before = len(self.faults)
                self.number = number
                self._rng = np.random.default_rng([self.seed, number])
                self._act()
                self._check()
                if told is not None:
                    told(number, self.faults[before:])
            self.number = n
            self._end()
        finally:
            self._watching = False
            self._poking = False
            self._unhook()
        return self.faults

    def close(self) -> None:
        """Close the window; nothing is asked."""
        paint_thread = self.window.stage.paint_thread
        if paint_thread is not None:
            pretend_saved(paint_thread)
        self.window.close()
        self._process()

    def _act(self) -> None:
        """Do one thing at random."""
        weights = np.array(list(self.actions.values()), float)
        name = str(self._rng.choice(list(self.actions), p=weights / weights.sum()))
        self._depth += 1
        self.done.append(f"{self.number}: {name}")
        try:
            detail = getattr(self, name)(self._rng)
            self.done.append(f"{self.number}: {name} {detail}")
        except Exception:
            self._fault("traceback", traceback.format_exc())
        finally:
            self._depth -= 1

    def _poke(self) -> None:
        """Within an action that waits in a loop of its own: answer, or do something else."""
        if not self._poking:
            return
        QtCore.QTimer.singleShot(POKE_MS, self._poke)  # also while what follows has a loop
        self._round()
        if self._depth == 0:
            return
        dialog = self._app.activeModalWidget() or self._app.activePopupWidget()
        if dialog is not None:
            if self._rng.random() < 0.3:
                self.done.append(f"{self.number}: answers {type(dialog).__name__}")
                try:
                    self._answer(dialog)
                except Exception:
                    self._fault("traceback", traceback.format_exc())
        elif self._may_act_within() and self._rng.random() < 0.05:
            self._act()

    def _may_act_within(self) -> bool:
        return not self._starting and self._depth < DEEPEST and self.window.isVisible()

    # -- what it does -----------------------------------------------------------------------

    def stroke(self, rng: Generator) -> str:
        """A stroke by pen or mouse; sometimes something else is done meanwhile."""
        if self._is_blocked() or self._touching:
            return "blocked"
        self._touching = True
        try:
            return self._stroke(rng)
        finally:
            self._touching = False

    def _stroke(self, rng: Generator) -> str:
        device = str(rng.choice(["pen", "pen", "pen", "mouse", "eraser"]))
        n = int(rng.integers(3, 25))
        way = np.linspace(rng.uniform(0.0, 1.0, 2), rng.uniform(0.0, 1.0, 2), n)
        tilt = tuple(rng.uniform(-60.0, 60.0, 2)) if rng.random() < 0.5 else (0.0, 0.0)
        modifiers = tuple(rng.choice(["alt", "ctrl", "shift"], 1)) if rng.random() < 0.1 else ()
        t = 0
        for k, place in enumerate(way):
            kind = "press" if k == 0 else "move"
            pressure = float(rng.uniform(0.0, 1.0))
            self._send(DeviceEvent(device, kind, tuple(place), pressure, tilt, 0.0, ("left",),
                                   modifiers, time_ms=t))  # fmt: skip
            t += int(rng.integers(0, 30))
            if rng.random() < 0.03:
                self._tap(str(rng.choice(["Ctrl+Z", "Esc", "7", "[", "D", "X", "R", "Home"])))
            if rng.random() < 0.1:
                self._process()
        self._send(DeviceEvent(device, "release", tuple(way[-1]), 0.0, tilt, time_ms=t + 5))
        return f"{device} {n} {tilt} {modifiers}"

    def menu(self, rng: Generator) -> str:
        """Choose something from a menu."""
        if self._is_blocked():
            return "blocked"
        names = sorted(self.window.workspace.actions)
        name = str(rng.choice(names))
        if name in QUIT and rng.random() < 0.7:
            return "not " + name
        action = self.window.workspace.actions[name]
        self.done.append(f"{self.number}: menu {name}{'' if action.isEnabled() else ' (off)'}")
        action.trigger()
        return name

    def key(self, rng: Generator) -> str:
        """Press and let go one of the keys that mean something."""
        if self._is_blocked():
            return "blocked"
        mouse = ("Left", "Middle", "Right", "Wheel", "Ctrl+Q", "F11")
        keys = [one.keys for one in SHORTCUTS if not one.keys.endswith(mouse)]
        name = str(rng.choice(keys))
        self.done.append(f"{self.number}: key {name}")
        self._tap(name)
        return name

    def click_panel(self, rng: Generator) -> str:
        """Use a control somewhere in the window, as a mouse does."""
        if self._is_blocked():
            return "blocked"
        widgets = [w for w in self.window.findChildren(QtWidgets.QWidget) if self._can_be_used(w)]
        if not widgets:
            return "nothing"
        widget = widgets[int(rng.integers(len(widgets)))]
        name = f"{type(widget).__name__} {widget.objectName()}"
        self.done.append(f"{self.number}: uses {name}")
        self._use(widget, rng)
        return name

    def drag(self, rng: Generator) -> str:
        """Drag with another button over the picture."""
        if self._is_blocked() or self._touching:
            return "blocked"
        button = str(rng.choice(["middle", "right", "left"]))
        keys = {"left": ["Alt"], "middle": ["", "Shift", "Control", "Alt"], "right": ["Alt", ""]}
        key = str(rng.choice(keys[button]))
        modifier = getattr(QtCore.Qt.KeyboardModifier, f"{key or 'No'}Modifier")
        held = getattr(QtCore.Qt.MouseButton, f"{button.title()}Button")
        canvas = self.window.canvas
        size = np.array([canvas.width(), canvas.height()])
        way = np.linspace(rng.uniform(0, 1, 2), rng.uniform(0, 1, 2), 8) * size
        kind, none = QtCore.QEvent.Type, QtCore.Qt.MouseButton.NoButton
        steps = [(kind.MouseButtonPress, held, held, way[0])]
        steps += [(kind.MouseMove, none, held, place) for place in way]
        steps += [(kind.MouseButtonRelease, held, none, way[-1])]
        for what, pressed, down, (x, y) in steps:
            place = QtCore.QPointF(x, y)
            self._app.sendEvent(canvas, QtGui.QMouseEvent(
                what, place, canvas.mapToGlobal(place), pressed, down, modifier))  # fmt: skip
        return f"{button} {key}"

    def wheel(self, rng: Generator) -> str:
        """Turn the wheel over the picture."""
        if self._is_blocked():
            return "blocked"
        canvas = self.window.canvas
        place = QtCore.QPointF(rng.uniform(0, canvas.width()), rng.uniform(0, canvas.height()))
        notches = int(rng.integers(-4, 5))
        self._app.sendEvent(canvas, QtGui.QWheelEvent(
            place, canvas.mapToGlobal(place), QtCore.QPoint(), QtCore.QPoint(0, 120 * notches),
            QtCore.Qt.MouseButton.NoButton, QtCore.Qt.KeyboardModifier.NoModifier,
            QtCore.Qt.ScrollPhase.NoScrollPhase, False,
        ))  # fmt: skip
        return str(notches)

    def hover(self, rng: Generator) -> str:
        """Move over the picture, or out of it."""
        if self._is_blocked():
            return "blocked"
        for place in rng.uniform(0, 1, (4, 2)) if not self._touching else ():
            self._send(DeviceEvent(str(rng.choice(["pen", "mouse"])), "move", tuple(place)))
        if rng.random() < 0.3:
            self._app.sendEvent(self.window.canvas, QtCore.QEvent(QtCore.QEvent.Type.Leave))
        return ""

    def open_object(self, rng: Generator) -> str:
        """Open something, small, without asking what becomes of the painting."""
        if self._is_blocked():
            return "blocked"
        name = str(rng.choice(OBJECTS))
        material = str(rng.choice(["porcelain", "xuan"]))
        self.window.opening.open_path(name, float(rng.uniform(*COARSE_MM)), material, asked=True)
        return f"{name} {material}"

    def drop_file(self, rng: Generator) -> str:
        """Drop a file on the picture."""
        if self._is_blocked():
            return "blocked"
        path = self.folder / str(rng.choice(NAMES))
        if path.suffix in (".ply", ".glb") and path.exists() and path.stat().st_size > 3_000_000:
            return "too large"
        self.window.canvas.dropped.emit(str(path))
        return path.name

    def undo_storm(self, rng: Generator) -> str:
        """Undo and redo many times."""
        if self._is_blocked():
            return "blocked"
        n = int(rng.integers(5, 25))
        for key in rng.choice(["Ctrl+Z", "Ctrl+Z", "Ctrl+Shift+Z"], n):
            self._tap(str(key))
        return str(n)

    def switch_while_behind(self, rng: Generator) -> str:
        """Keep the painting thread busy, change the brush, and paint on at once."""
        paint_thread = self.window.stage.paint_thread
        if paint_thread is None or self._is_blocked():
            return "nothing is open"
        seconds = float(rng.uniform(0.1, 0.6))
        paint_thread.post(lambda document: time.sleep(seconds))
        self._tap(str(rng.integers(1, 10)))
        return f"{seconds:.2f} s, {self.stroke(rng)}"

    def fingers(self, rng: Generator) -> str:
        """Touch the picture with two fingers, draw them apart, and let go."""
        if self._is_blocked():
            return "blocked"
        ends = rng.uniform(0.1, 0.9, (2, 2, 2))
        for share in np.linspace(0.0, 1.0, 5):
            for finger in (0, 1):
                place = (1.0 - share) * ends[0, finger] + share * ends[1, finger]
                kind = "press" if share == 0.0 else "move"
                self._send(DeviceEvent("touch", kind, tuple(place), id=finger + 1))
        for finger in (0, 1):
            self._send(DeviceEvent("touch", "release", tuple(ends[1, finger]), id=finger + 1))
        return ""

    def resize(self, rng: Generator) -> str:
        """Make the window another size."""
        size = (int(rng.integers(900, 1500)), int(rng.integers(650, 950)))
        self.window.resize(*size)
        return f"{size}"

    def crash(self, rng: Generator) -> str:
        """End the program without closing it, and start it again."""
        if self._is_blocked() or self._depth > 1:
            return "blocked"
        paint_thread = self.window.stage.paint_thread
        if paint_thread is not None:
            paint_thread.stop(keep=True)
        self.window.workspace.held.emit(True)  # it draws no more
        self.window.both_hands.close()
        self.window.panels.close_down()
        self.window.stage.close()
        self.window.hide()
        self.window.deleteLater()
        self._new_window()
        return str(self.window.recovery.offer())

    def rest(self, rng: Generator) -> str:
        """Do nothing for a while."""
        until = time.monotonic() + float(rng.uniform(0.0, 0.2))
        while time.monotonic() < until:
            self._process()
        return ""

    # -- how it does it ---------------------------------------------------------------------

    def _is_blocked(self) -> bool:
        """Return whether a dialog or menu takes the window's events."""
        return (self._app.activeModalWidget() or self._app.activePopupWidget()) is not None

    def _send(self, event: DeviceEvent) -> None:
        self._begun += 1000
        self._player.send(event, self._begun)

    def _tap(self, keys: str) -> None:
        """Press keys as the keyboard does, in the window."""
        combination = QtGui.QKeySequence(keys)[0]
        modifiers = combination.keyboardModifiers()
        key = combination.key()
        if key == QtCore.Qt.Key.Key_unknown:
            return
        for action in (QtTest.QTest.KeyAction.Press, QtTest.QTest.KeyAction.Release):
            QtTest.QTest.keyEvent(action, self.window, key, modifiers, 0)

    def _can_be_used(self, widget: QtWidgets.QWidget) -> bool:
        kinds = (
            QtWidgets.QAbstractButton, QtWidgets.QAbstractSlider, QtWidgets.QComboBox,
            QtWidgets.QAbstractSpinBox, QtWidgets.QLineEdit, QtWidgets.QAbstractItemView,
            QtWidgets.QTabBar,
        )  # fmt: skip
        own = type(widget).__module__.startswith("paint3d") and widget is not self.window
        return (
            (isinstance(widget, kinds) or own)
            and widget.isVisible()
            and widget.isEnabled()
            and widget is not self.window.canvas
            and widget.window() is self.window
            and min(widget.width(), widget.height()) > 2
        )

    def _use(self, widget: QtWidgets.QWidget, rng: Generator) -> None:
        """Use one control: by its own means, or by clicking into it anywhere."""
        if isinstance(widget, QtWidgets.QDoubleSpinBox) and rng.random() < 0.7:
            coarse = widget.suffix() == " mm" and widget.minimum() < 1.0
            limits = COARSE_MM if coarse else (widget.minimum(), widget.maximum())
            widget.setValue(float(rng.uniform(*limits)))
        elif isinstance(widget, WHOLE) and rng.random() < 0.7:
            widget.setValue(int(rng.integers(widget.minimum(), widget.maximum() + 1)))
        elif isinstance(widget, QtWidgets.QComboBox) and widget.count():
            k = int(rng.integers(widget.count()))
            widget.setCurrentIndex(k)
            widget.activated.emit(k)
        elif isinstance(widget, QtWidgets.QLineEdit):
            widget.setText(str(rng.choice(["永", "一", "12", "", "a b", "永和九年", "-1"])))
            if rng.random() < 0.5:
                widget.returnPressed.emit()
            widget.editingFinished.emit()
        else:
            place = QtCore.QPoint(
                int(rng.integers(1, widget.width())), int(rng.integers(1, widget.height()))
            )
            target = widget
            if isinstance(widget, QtWidgets.QAbstractItemView):
                target = widget.viewport()
            click = QtTest.QTest.mouseClick if rng.random() < 0.85 else QtTest.QTest.mouseDClick
            click(target, QtCore.Qt.MouseButton.LeftButton,
                  QtCore.Qt.KeyboardModifier.NoModifier, place)  # fmt: skip

    def _answer(self, dialog: QtWidgets.QWidget) -> None:
        """Answer a dialog or menu at random."""
        rng = self._rng
        if isinstance(dialog, QtWidgets.QMenu):
            actions = [a for a in dialog.actions() if a.isEnabled() and not a.menu()]
            if actions and rng.random() < 0.5:
                chosen = actions[int(rng.integers(len(actions)))]
                dialog.close()
                chosen.trigger()
            else:
                dialog.close()
        elif isinstance(dialog, QtWidgets.QProgressDialog):
            if rng.random() < 0.1:
                dialog.canceled.emit()
        elif isinstance(dialog, QtWidgets.QFileDialog):
            self._answer_file(dialog)
        elif isinstance(dialog, QtWidgets.QMessageBox):
            buttons = dialog.buttons()
            buttons[int(rng.integers(len(buttons)))].click()
        elif isinstance(dialog, QtWidgets.QDialog):
            kinds = (QtWidgets.QComboBox, QtWidgets.QAbstractSpinBox, QtWidgets.QAbstractButton)
            for widget in dialog.findChildren(QtWidgets.QWidget):
                usable = isinstance(widget, kinds) and widget.isVisible() and widget.isEnabled()
                if usable and rng.random() < 0.3 and dialog.isVisible():
                    self._use(widget, rng)
            if isinstance(dialog, QtWidgets.QInputDialog):
                dialog.setTextValue(str(rng.choice(["", "layer", "永", "x" * 300])))
            coarse = [w for w in dialog.findChildren(QtWidgets.QDoubleSpinBox)
                      if w.suffix() == " mm"]  # fmt: skip
            for widget in coarse:
                widget.setValue(max(COARSE_MM[0], widget.value()))
            dialog.accept() if rng.random() < 0.6 else dialog.reject()
        else:
            dialog.close()

    def _answer_file(self, dialog: QtWidgets.QFileDialog) -> None:
        """Type a name and accept, or go away."""
        box = dialog.findChild(QtWidgets.QDialogButtonBox)
        line = dialog.findChild(QtWidgets.QLineEdit, "fileNameEdit")
        name = str(self._rng.choice(NAMES))
        if box is None or line is None or self._rng.random() < 0.35:
            dialog.reject()
            return
        line.setText(name if name.startswith("/") else str(self.folder / name))
        self.done.append(f"{self.number}: types {name!r}")
        accepts = QtWidgets.QDialogButtonBox.ButtonRole.AcceptRole
        buttons = [button for button in box.buttons() if box.buttonRole(button) == accepts]
        if buttons and buttons[0].isEnabled():
            buttons[0].click()
        else:
            dialog.reject()

    def _new_window(self) -> StudioWindow:
        """A window as at a start, with nothing in it."""
        self._starting = True
        window = self.window = StudioWindow(self._app)
        window.show()
        self._player = EventPlayer(window)
        self._player.aspect = 1.0
        self._begun = time.monotonic_ns() // 1_000_000
        window.activateWindow()
        if self.start is not None:
            window.workspace.quiet = True
            window.opening.open_path(self.start, COARSE_MM[0], "xuan", asked=True)
            window.workspace.quiet = False
        self._process()
        self._starting = False
        return window

    def _fill_folder(self) -> None:
        """Put files there that can be opened, and some that cannot."""
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "bad.ply").write_text("ply\nno\n")
        (self.folder / "notes.txt").write_text("not a painting")
        (self.folder / "b.p3d").write_bytes(b"PK\x03\x04 cut short")
        Document.new("plane", 4.0, "xuan").save(self.folder / "a.p3d")

    def _process(self) -> None:
        self._round()
        QtWidgets.QApplication.processEvents(QtCore.QEventLoop.ProcessEventsFlag.AllEvents, 10)
        self._round()

    # -- what it sees -----------------------------------------------------------------------

    def _fault(self, kind: str, text: str) -> None:
        self.faults.append(Fault(self.number, kind, text))

    def _check(self) -> None:
        """After an action nothing is held, and the window comes round; there is one."""
        self._process()
        if not self.window.isVisible():  # by whatever way it was left
            self._new_window()
        if self.window.hand.in_stroke and not self._is_blocked():
            self._fault("state", "a stroke goes on though nothing touches")
            self.window.hand.end_stroke()

    def _round(self) -> None:
        now = time.monotonic()
        self.slowest_s = max(self.slowest_s, now - self._last_round)
        self._last_round = now

    def _watch(self) -> None:
        """Tell where the main thread is when it does not come round."""
        main, told = threading.main_thread().ident, 0.0
        while self._watching:
            time.sleep(0.1)
            since = time.monotonic() - self._last_round
            if since < SLOW_S:
                told = 0.0
            elif since > SLOW_S and not told:
                told = since
                stack = "".join(traceback.format_stack(sys._current_frames()[main])[-14:])
                self._fault("slow", stack)
            if since > STUCK_S:
                self._fault("stuck", "the window does not come round")
                faulthandler.dump_traceback()
                self._last_round = time.monotonic()

    def _settle(self) -> None:
        """Wait until everything is painted."""
        paint_thread = self.window.stage.paint_thread
        done = paint_thread.post(lambda document: None)
        until = time.monotonic() + SETTLE_S
        while not done.done():
            if time.monotonic() > until:
                self._fault("stuck", f"{paint_thread.queue_length} jobs are left")
                return
            self._process()

    def _end(self) -> None:
        """Save what is there, open it, and compare."""
        self._depth = 0
        while (dialog := self._app.activeModalWidget()) is not None:
            dialog.close()
            self._process()
        if self.window.stage.paint_thread is None:
            self.window.opening.open_path("plane", 4.0, "xuan", asked=True)
        self._settle()
        path = self.folder / "end.p3d"
        with self.window.stage.paint_thread.paused() as document:
            if document.in_stroke:
                self._fault("state", "the painting is in a stroke though nothing touches")
                document.end_stroke()
            document.save(path)
            kept = _sum_of(document)
        again = _sum_of(Document.open(path))
        if kept != again:
            self._fault("session", f"saved {kept}, opened {again}")

    # -- hooks ------------------------------------------------------------------------------

    def _hook(self) -> None:
        hooks = self._hooks
        hooks.excepthook, sys.excepthook = sys.excepthook, self._raised
        hooks.thread_hook, threading.excepthook = threading.excepthook, self._raised_beside
        hooks.unraisable, sys.unraisablehook = sys.unraisablehook, self._raised_beside
        hooks.messages = QtCore.qInstallMessageHandler(self._message)
        hooks.report = PaintThread.report
        found = self._fault

        def report(paint_thread: PaintThread, doing: str, error: Exception) -> None:
            hooks.report(paint_thread, doing, error)
            if not isinstance(error, Paint3DError):
                found("internal", "".join(traceback.format_exception(error)))

        PaintThread.report = report

    def _unhook(self) -> None:
        hooks = self._hooks
        sys.excepthook, threading.excepthook = hooks.excepthook, hooks.thread_hook
        sys.unraisablehook = hooks.unraisable
        QtCore.qInstallMessageHandler(hooks.messages)
        PaintThread.report = hooks.report

    def _raised(self, kind, error, trace) -> None:
        self._fault("traceback", "".join(traceback.format_exception(kind, error, trace)))

    def _raised_beside(self, told) -> None:
        trace = traceback.format_exception(told.exc_type, told.exc_value, told.exc_traceback)
        self._fault("traceback", "".join(trace))

    def _message(self, kind, context, text: str) -> None:
        bad = (QtCore.QtMsgType.QtWarningMsg, QtCore.QtMsgType.QtCriticalMsg)
        if kind in bad and not any(words in text for words in HARMLESS):
            self._fault("qt", text)


def _sum_of(document: Document) -> dict[str, object]:
    """Hash a painting, so that two can be compared."""
    surface = document.surface
    document.refresh()
    order = np.lexsort(surface.paint_mesh.vertices.T)
    return {
        "object": surface.source.name,
        "vertices": surface.n_vertices,
        "strokes": len(document.strokes),
        "layers": [layer.name for layer in document.layers],
        "brush": document.painter.brush.name,
        "colours": hash(surface.srgb[order].tobytes()),
    }
