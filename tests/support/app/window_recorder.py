"""Records what a hand does in the window, its dialogs and menus: see `tests/app/README.md`."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.hand.canvas import CanvasWidget
from paint3d.app.window.studio import StudioWindow
from tests.support.app.calm import Calm
from tests.support.app.controls import CANVAS, Control, control_at, open_popup, title_of
from tests.support.app.event_player import (
    BUTTONS,
    MODIFIERS,
    MOUSE_KINDS,
    PENS,
    TABLET_KINDS,
    DeviceEvent,
)

__all__ = ["PenOfMouse", "WindowRecorder"]

KIND, KEY = QtCore.QEvent.Type, QtCore.Qt.Key
_MOUSE = {kind: name for name, kind in MOUSE_KINDS.items()}
_PEN = {kind: name for name, kind in TABLET_KINDS.items()}
_HELD_ALONE = (KEY.Key_Shift, KEY.Key_Control, KEY.Key_Alt, KEY.Key_Meta, KEY.Key_AltGr)
_LOOK_MS = 50
_HOVER_MS = 40  # at most so often a hand is told that only moves over the picture


class WindowRecorder(QtCore.QObject):
    """Writes each event of mouse, pen and keys as one line, as it comes.

    Parameters
    ----------
    window : StudioWindow
    path : Path
        To be written.
    about : str
        What is recorded.
    """

    def __init__(self, window: StudioWindow, path: Path, about: str) -> None:
        super().__init__(window)
        self._window, self._calm = window, Calm(window)
        self._file = path.open("w", encoding="utf-8")
        size = [window.width(), window.height()]
        header = {"format": "paint3d device events", "version": 1, "about": about}
        self._write(header | {"window": size, "places": "controls"})
        self._pressed: Control | None = None
        self._last_key: tuple[int, int] | None = None
        self._first_ms: int | None = None
        self._hover_ms = 0
        self.pen_has_canvas = False
        """Whether mouse events over the picture are left out: a pen's are made of them."""
        QtWidgets.QApplication.instance().installEventFilter(self)
        self._looks = QtCore.QTimer(self)  # else the first press on something new would be hasty
        self._looks.timeout.connect(self._calm)
        self._looks.start(_LOOK_MS)

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Note down, and let pass."""
        kind = event.type()
        if kind in _PEN and isinstance(watched, CanvasWidget):
            self._note_pen(event)
        elif watched.isWindowType() and event.spontaneous():
            if kind in _MOUSE or kind == KIND.Wheel:
                self._note_mouse(event)
            elif kind in (KIND.KeyPress, KIND.KeyRelease):
                self._note_key(event)
        elif kind == KIND.ShortcutOverride and event.spontaneous():
            self._note_key(event)
        return False

    def _note_mouse(self, event: QtGui.QMouseEvent | QtGui.QWheelEvent) -> None:
        place = event.globalPosition().toPoint()
        kind = _MOUSE.get(event.type(), "wheel")
        control = self._pressed if self._pressed is not None else control_at(place)
        if control is None or (self.pen_has_canvas and control.name == CANVAS and kind != "wheel"):
            return
        if kind == "move" and not event.buttons() and not self._tells_hover(control, event):
            return
        window = QtWidgets.QApplication.widgetAt(place)
        row = DeviceEvent(
            "mouse", kind, control.share(event.globalPosition()),
            buttons=_names(BUTTONS, event.buttons()),
            modifiers=_names(MODIFIERS, event.modifiers()), on=control.name,
            window="" if window is None else title_of(window.window()),
        )  # fmt: skip
        if kind == "wheel":
            row = replace(row, notches=event.angleDelta().y() / 120.0)
        if kind in ("press", "release"):
            row = replace(row, button=_names(BUTTONS, event.button())[0])
        if kind == "press":
            self._pressed = control
        if kind == "release" and not event.buttons():
            self._pressed = None
        self._note(row, event.timestamp())

    def _tells_hover(self, control: Control, event: QtGui.QMouseEvent) -> bool:
        """Return whether to tell of a hand that only moves: over the picture, and not too often."""
        if control.name != CANVAS or event.timestamp() - self._hover_ms < _HOVER_MS:
            return False
        self._hover_ms = event.timestamp()
        return True

    def _note_pen(self, event: QtGui.QTabletEvent) -> None:
        canvas = self._window.canvas
        box = QtCore.QRect(canvas.mapToGlobal(QtCore.QPoint(0, 0)), canvas.size())
        eraser = event.pointerType() == QtGui.QPointingDevice.PointerType.Eraser
        self._note(
            DeviceEvent(
                "eraser" if eraser else "pen", _PEN[event.type()],
                Control(CANVAS, box).share(event.globalPosition()),
                pressure=round(event.pressure(), 4), tilt=(event.xTilt(), event.yTilt()),
                rotation=event.rotation(), buttons=_names(BUTTONS, event.buttons()),
                modifiers=_names(MODIFIERS, event.modifiers()), on=CANVAS,
            ),
            event.timestamp(),
        )  # fmt: skip

    def _note_key(self, event: QtGui.QKeyEvent) -> None:
        """Note a key once, whether a shortcut takes it or a window gets it."""
        press = event.type() != KIND.KeyRelease
        said = (event.timestamp(), event.key())
        if event.isAutoRepeat() or event.key() in (0, *_HELD_ALONE):
            return
        if press and said == self._last_key:
            return
        self._last_key = said if press else None
        window = open_popup() or QtWidgets.QApplication.activeWindow()
        key = QtGui.QKeySequence(event.keyCombination()).toString()
        row = DeviceEvent(
            "key", "press" if press else "release", key=key, text=event.text() if press else "",
            window=title_of(window or self._window),
        )  # fmt: skip
        self._note(row, event.timestamp())

    def _note(self, row: DeviceEvent, time_ms: int) -> None:
        if self._first_ms is None:
            self._first_ms = time_ms
        deliberate = row.kind in ("press", "wheel")
        row = replace(row, time_ms=time_ms - self._first_ms, hasty=deliberate and not self._calm())
        plain = DeviceEvent(row.device, row.kind)
        told = {k: v for k, v in asdict(row).items() if v != getattr(plain, k) and k != "place"}
        names = zip(("x", "y"), row.place or (), strict=False)
        self._write({"device": row.device, "kind": row.kind, **dict(names), **told})
        if row.kind != "move":
            self._calm.ask()

    def _write(self, row: dict) -> None:
        self._file.write(json.dumps(row, ensure_ascii=False) + "\n")
        self._file.flush()


class PenOfMouse(QtCore.QObject):
    """Makes a leaning pen of a mouse over the picture, that presses less where it is fast.

    Parameters
    ----------
    recorder : WindowRecorder
    canvas : CanvasWidget
    tilt : (float, float)
        Degrees to the right, and towards the user.
    """

    _FIRM, _LESS, _TOUCH_MS = 0.6, 0.3, 80.0  # at rest; for each pixel a ms; until it has come down

    def __init__(
        self, recorder: WindowRecorder, canvas: CanvasWidget, tilt: tuple[float, float]
    ) -> None:
        super().__init__(canvas)
        recorder.pen_has_canvas = True
        self._canvas, self._tilt = canvas, tilt
        self._at, self._last_ms, self._down_ms, self._pressure = QtCore.QPointF(), 0, 0, 0.0
        canvas.installEventFilter(self)

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Send the pen's event in place of the mouse's."""
        if event.type() not in _MOUSE:
            return False
        kind, place, now_ms = _MOUSE[event.type()], event.position(), event.timestamp()
        if kind == "press":
            self._at, self._down_ms, self._pressure = place, now_ms, 0.02
        elif kind == "release" or not event.buttons():
            self._at, self._pressure = place, 0.0
        else:
            way = place - self._at
            speed = (way.x() ** 2 + way.y() ** 2) ** 0.5 / max(1, now_ms - self._last_ms)
            come_down = min(1.0, (now_ms - self._down_ms) / self._TOUCH_MS)
            wanted = come_down * max(0.05, self._FIRM - self._LESS * speed)
            self._at += 0.5 * way
            self._pressure += 0.3 * (wanted - self._pressure)
        self._last_ms = now_ms
        made = QtGui.QTabletEvent(
            TABLET_KINDS[kind], PENS["pen"], self._at, self._canvas.mapToGlobal(self._at),
            self._pressure, *self._tilt, 0.0, 0.0, 0.0, event.modifiers(),
            event.button(), event.buttons(),
        )  # fmt: skip
        made.setTimestamp(now_ms)
        QtWidgets.QApplication.sendEvent(self._canvas, made)
        return True


def _names(of: dict, held: QtCore.Qt.MouseButton | QtCore.Qt.KeyboardModifier) -> tuple[str, ...]:
    return tuple(name for name, one in of.items() if one & held)
