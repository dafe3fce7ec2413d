"""Plays recordings of device events into the real window, with the times of the devices.

Recordings are made by `scripts/make_event_recordings.py`; their format is in `README.md` beside
this file.
"""

from __future__ import annotations

import contextlib
import json
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.input import navigation
from paint3d.app.window.studio import StudioWindow
from paint3d.mesh.bvh import ClosestPoints
from paint3d.view.camera import Camera, picture_axes
from tests.support.app.gestures import wait_for
from tests.support.app.windows import pretend_saved

__all__ = [
    "DeviceEvent",
    "EventPlayer",
    "EventRecording",
    "buttons_of",
    "hand_over",
    "modifiers_of",
    "open_for",
    "pen_ways",
    "pixel_of",
    "surface_of",
    "without_slips",
]

FOLDER = Path(__file__).parents[2] / "app" / "recordings"
KIND, TYPE = QtCore.QEvent.Type, QtGui.QInputDevice.DeviceType
POINTER, CAN = QtGui.QPointingDevice.PointerType, QtGui.QInputDevice.Capability
PEN_CAN = CAN.Position | CAN.Pressure | CAN.XTilt | CAN.YTilt | CAN.Rotation | CAN.Hover
PENS = {
    "pen": QtGui.QPointingDevice("pen", 11, TYPE.Stylus, POINTER.Pen, PEN_CAN, 1, 3),
    "eraser": QtGui.QPointingDevice("eraser", 12, TYPE.Stylus, POINTER.Eraser, PEN_CAN, 1, 3),
}
TABLET_KINDS = {
    "press": KIND.TabletPress,
    "move": KIND.TabletMove,
    "release": KIND.TabletRelease,
}
MOUSE_KINDS = {
    "press": KIND.MouseButtonPress,
    "move": KIND.MouseMove,
    "release": KIND.MouseButtonRelease,
}
TIMED = (
    KIND.TouchBegin, KIND.TouchUpdate, KIND.TouchEnd, KIND.TouchCancel,
    KIND.KeyPress, KIND.KeyRelease,
)  # fmt: skip
NO_BUTTON = QtCore.Qt.MouseButton.NoButton
BUTTONS = {
    "left": QtCore.Qt.MouseButton.LeftButton,
    "middle": QtCore.Qt.MouseButton.MiddleButton,
    "right": QtCore.Qt.MouseButton.RightButton,
}
MODIFIERS = {
    "shift": QtCore.Qt.KeyboardModifier.ShiftModifier,
    "ctrl": QtCore.Qt.KeyboardModifier.ControlModifier,
    "alt": QtCore.Qt.KeyboardModifier.AltModifier,
}
SLIP_MM = 2.0  # beyond that, a place between two events that lie nearer is none
PAUSE_MS = 500  # between two recordings played after each other
_surfaces: list[tuple[object, ClosestPoints]] = []  # of the object that was asked about last


@dataclass(frozen=True)
class DeviceEvent:
    """One event of a device.

    Attributes
    ----------
    device : {"pen", "eraser", "mouse", "touch", "key", "painting"}
        "painting" is no device: its "hold" and "go on" say when the painting stands still.
    kind : {"press", "move", "release", "wheel", "hold", "go on"}
    place : tuple or None
        See the header's `places`.
    pressure : float
        0 to 1.
    notches : float
        Of a wheel.
    tilt : (float, float)
        Degrees to the right, and towards the user.
    rotation : float
        Degrees clockwise about the pen's axis.
    buttons, modifiers : tuple of str
        That are held after it.
    key, text : str
        As `QKeySequence` writes it, and what it types.
    id : int
        Of a finger.
    time_ms, handled_ms : int
        When it happened, by the device's clock, and when it reached the program.
    on, window : str
        The control, as a screen reader calls it, and the window: see `controls`.
    hasty : bool
        It was done before all was done that was asked for earlier.
    button : str
        That is pressed or let go.
    """

    device: str
    kind: str
    place: tuple[float, ...] | None = None
    pressure: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    buttons: tuple[str, ...] = ()
    modifiers: tuple[str, ...] = ()
    key: str = ""
    text: str = ""
    notches: float = 0.0
    id: int = 0
    time_ms: int = 0
    handled_ms: int = 0
    on: str = ""
    window: str = ""
    hasty: bool = False
    button: str = "left"

    @classmethod
    def from_row(cls, row: dict) -> DeviceEvent:
        """Read an event from a line of a recording."""
        given = {name: tuple(v) if isinstance(v, list) else v for name, v in row.items()}
        place = tuple(given.pop(name) for name in ("x", "y", "z") if name in given)
        return cls(**given, place=place or None)


@dataclass(frozen=True)
class EventRecording:
    """Events of devices, recorded while somebody did something.

    Attributes
    ----------
    header : dict
        Object, material, brush, ink, view ..., see `README.md`.
    events : tuple of DeviceEvent
    """

    header: dict
    events: tuple[DeviceEvent, ...]

    @classmethod
    def load(cls, name: str | Path) -> EventRecording:
        """Load one of `recordings`, or any file."""
        path = Path(name) if isinstance(name, Path) else FOLDER / f"{name}.jsonl"
        header, *rows = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
        assert header["format"] == "paint3d device events", path
        assert header["version"] == 1, path
        return cls(header, tuple(DeviceEvent.from_row(row) for row in rows))

    def strokes(self) -> list[tuple[DeviceEvent, ...]]:
        """Events of each stroke by pen or mouse, from press to release."""
        found: list[list[DeviceEvent]] = []
        down = False
        for event in self.events:
            if event.device not in ("pen", "mouse"):
                continue
            if event.kind == "press":
                found.append([])
                down = True
            if down:
                found[-1].append(event)
            down = down and event.kind != "release"
        return [tuple(stroke) for stroke in found]

    def part(self, first: int, last: int | None = None) -> EventRecording:
        """Only some strokes, with the events that come before each of them."""
        number, kept = 0, []
        for event in self.events:
            wanted = first <= number and (last is None or number < last)
            if wanted:
                kept.append(event)
            if event.device in ("pen", "mouse") and event.kind == "release":
                number += 1
        return EventRecording(self.header, tuple(kept))

    def changed(self, **changes: object) -> EventRecording:
        """The same by pens and mice that are held otherwise, as with ``tilt=(0, 0)``."""
        hands = ("pen", "mouse")
        events = tuple(replace(e, **changes) if e.device in hands else e for e in self.events)
        return EventRecording(self.header, events)


def hand_over(
    events: Sequence[DeviceEvent],
    how: str = "one by one",
    n: int = 12,
    pictures_a_second: float = 60.0,
) -> Iterator[tuple[DeviceEvent, ...]]:
    """Batches of events as a program gets them; between two the program lives for a moment.

    Parameters
    ----------
    events : sequence of DeviceEvent
    how : {"one by one", "burst", "pictures", "as recorded", "at once"}
        Each by itself; `n` at a time; what came during each of so many pictures a second; what was
        handled in the same millisecond; all.
    n : int
    pictures_a_second : float
    """
    if how == "at once":
        yield tuple(events)
        return
    labels = {
        "one by one": lambda k, event: k,
        "burst": lambda k, event: k // n,
        "pictures": lambda k, event: math.floor(event.time_ms * pictures_a_second / 1000.0),
        "as recorded": lambda k, event: event.handled_ms,
    }
    batch: list[DeviceEvent] = []
    label = None
    for k, event in enumerate(events):
        now = labels[how](k, event)
        if batch and now != label:
            yield tuple(batch)
            batch = []
        label = now
        batch.append(event)
    yield tuple(batch)


def open_for(
    window: StudioWindow, header: dict, resolution: float | None = 0.8, **instead: object
) -> None:
    """Open what a recording is played on: object, view, brush and ink; `instead` of the header's.

    The camera is looked through at once; everything else is done in the painting's thread.
    """
    header = {**header, **instead}
    window.workspace.quiet = True
    if window.stage.paint_thread is not None:
        pretend_saved(window.stage.paint_thread)
    opened = window.opening.open_path(
        header["object"], resolution, header.get("material", "xuan"), asked=True
    )
    assert opened, window.workspace.error
    look(window, header.get("view", "first"))
    wet = window.workspace.actions["wet"]
    if wet.isChecked() != bool(header.get("wet", False)):
        wet.trigger()
    window.workspace.post("set_brush", header.get("brush", "full"))
    window.workspace.post("dip", header.get("ink", "pine soot"))
    settle(window)


def look(window: StudioWindow, view: str | dict) -> None:
    """Look from a named side, "first" for the view that an object is opened with, or a camera."""
    if isinstance(view, dict):
        vectors = (np.array(view[name], float) for name in ("position", "focus", "up"))
        window.hand.look(Camera(*vectors, view["view_angle"]))
    elif view == "first":
        window.hand.show_all()
    else:
        window.hand.look_from(view)


def settle(window: StudioWindow, seconds: float = 600.0) -> None:
    """Wait until everything asked for is painted."""
    done = window.stage.paint_thread.post(lambda document: None)
    until = time.monotonic() + seconds
    while not done.done():
        assert time.monotonic() < until, "the painting stands still"
        process(2)
    process()


def process(milliseconds: int = 0) -> None:
    """Process the events that are queued."""
    QtWidgets.QApplication.processEvents(
        QtCore.QEventLoop.ProcessEventsFlag.AllEvents, milliseconds
    )
    if milliseconds:
        time.sleep(1e-3 * milliseconds)


class EventPlayer(QtCore.QObject):
    """Sends device events to one window, with times of a clock that goes on from play to play.

    Parameters
    ----------
    window : StudioWindow

    Attributes
    ----------
    now_ms : int
        The time of the event sent last, by the devices' clock.
    aspect : float or None
        Of the picture that places are counted in (`pixel_of`); of the recording played last.
    """

    def __init__(self, window: StudioWindow) -> None:
        super().__init__(window)
        self._window, self._canvas = window, window.canvas
        self.now_ms = 0
        self.aspect: float | None = None
        self._sending = False
        touch = QtTest.QTest.createTouchDevice()
        self._touches = QtTest.QTest.touchEvent(self._canvas, touch, autoCommit=False)
        self._fingers: set[int] = set()
        self._held: contextlib.ExitStack | None = None
        QtWidgets.QApplication.instance().installEventFilter(self)

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Give keys and fingers, which reach the program through Qt's window, their times."""
        if not self._sending or event.type() not in TIMED or not watched.isWidgetType():
            return False
        if event.type() != KIND.TouchBegin:
            event.setTimestamp(self.now_ms)
            return False
        copy = event.clone()  # Qt loses hold of a finger whose first event was changed
        copy.setTimestamp(self.now_ms)
        self._sending = False
        taken = watched.event(copy)
        self._sending = True
        event.setAccepted(copy.isAccepted())
        return taken

    def play(
        self,
        recording: EventRecording,
        how: str = "one by one",
        *,
        n: int = 12,
        pictures_a_second: float = 60.0,
        begin_ms: int | None = None,
        real_time: bool = False,
        late: bool = False,
        after_stroke: Callable[[int], None] | None = None,
    ) -> None:
        """Play a recording to its end, and wait until all of it is painted.

        Parameters
        ----------
        recording : EventRecording
        how, n, pictures_a_second
            See `hand_over`.
        begin_ms : int, optional
            Time of the recording's time 0 by the devices' clock; by default the computer's own
            monotonic clock, or later, so that time never goes back.
        real_time : bool
            Wait until the events would have happened, before they are handed over.
        late : bool
            Hand everything over only after all of it happened, as a program gets what queued while
            it was busy; a hover that comes in time goes before it.
        after_stroke : callable, optional
            Called with the number of each stroke, once it is painted.
        """
        if any(event.device == "key" for event in recording.events):
            self._window.activateWindow()
            wait_for(self._window.isActiveWindow)  # shortcuts are heard there only
        if begin_ms is None:
            begin_ms = max(time.monotonic_ns() // 1_000_000, self.now_ms + PAUSE_MS)
        if late:
            begin_ms = self._wait_for(recording)
        n_strokes, started = 0, time.monotonic()
        self.aspect = recording.header.get("aspect")
        try:
            for batch in hand_over(recording.events, how, n, pictures_a_second):
                due = started + 1e-3 * (
                    batch[-1].handled_ms if how == "as recorded" else batch[-1].time_ms
                )
                while real_time and time.monotonic() < due:
                    process(2)
                for event in batch:
                    self.send(event, begin_ms)
                    lifted = event.device in ("pen", "mouse") and event.kind == "release"
                    if lifted and after_stroke is not None:
                        settle(self._window)
                        after_stroke(n_strokes)
                    n_strokes += lifted
                process()
        finally:
            self._go_on()
        settle(self._window)

    def _wait_for(self, recording: EventRecording) -> int:
        """Hover now, and live on until a recording that begins now has ended; its time 0."""
        self.aspect = recording.header.get("aspect")
        hands = [event for event in recording.events if event.device in ("pen", "mouse")]
        now_ms = time.monotonic_ns() // 1_000_000
        hover = replace(hands[0], kind="move", pressure=0.0, buttons=(), time_ms=0)
        self.send(hover, now_ms)
        until = time.monotonic() + 1e-3 * (PAUSE_MS + recording.events[-1].time_ms)
        while time.monotonic() < until:
            process(5)
        return now_ms + PAUSE_MS

    def send(self, event: DeviceEvent, begin_ms: int) -> None:
        """Send one event."""
        self.now_ms = begin_ms + event.time_ms
        if event.device == "painting":
            self._hold() if event.kind == "hold" else self._go_on()
        elif event.device in ("key", "touch"):
            self._sending = True
            self._send_key(event) if event.device == "key" else self._send_touch(event)
            self._sending = False
        else:
            made = self._tablet(event) if event.device in PENS else self._mouse(event)
            made.setTimestamp(self.now_ms)
            QtWidgets.QApplication.sendEvent(self._canvas, made)

    def pixel(self, place: Sequence[float]) -> QtCore.QPointF:
        """Project a point to the canvas, pixels."""
        return QtCore.QPointF(*pixel_of(self._window, place, self.aspect))

    def _tablet(self, event: DeviceEvent) -> QtGui.QTabletEvent:
        place = self.pixel(event.place)
        button = NO_BUTTON if event.kind == "move" else BUTTONS["left"]
        return QtGui.QTabletEvent(
            TABLET_KINDS[event.kind], PENS[event.device], place, self._canvas.mapToGlobal(place),
            event.pressure, *event.tilt, 0.0, event.rotation, 0.0, modifiers_of(event), button,
            buttons_of(event),
        )  # fmt: skip

    def _mouse(self, event: DeviceEvent) -> QtGui.QMouseEvent:
        place = self.pixel(event.place)
        button = NO_BUTTON if event.kind == "move" else BUTTONS["left"]
        return QtGui.QMouseEvent(
            MOUSE_KINDS[event.kind], place, self._canvas.mapToGlobal(place), button,
            buttons_of(event), modifiers_of(event),
        )  # fmt: skip

    def _send_key(self, event: DeviceEvent) -> None:
        combination = QtGui.QKeySequence(event.key)[0]
        press = event.kind == "press"
        action = QtTest.QTest.KeyAction.Press if press else QtTest.QTest.KeyAction.Release
        modifiers = combination.keyboardModifiers() | modifiers_of(event)
        QtTest.QTest.keyEvent(action, self._window, combination.key(), modifiers, 0)

    def _send_touch(self, event: DeviceEvent) -> None:
        sequence = self._touches
        place = self.pixel(event.place).toPoint()
        if event.kind == "press":
            sequence.press(event.id, place, self._canvas)
            self._fingers.add(event.id)
        elif event.kind == "move":
            sequence.move(event.id, place, self._canvas)
        else:
            sequence.release(event.id, place, self._canvas)
            self._fingers.discard(event.id)
        for other in self._fingers - {event.id}:
            sequence.stationary(other)
        sequence.commit()

    def _hold(self) -> None:
        """Hold the painting where it is, as something that lasts does."""
        self._go_on()
        self._held = contextlib.ExitStack()
        self._held.enter_context(self._window.stage.paint_thread.paused())

    def _go_on(self) -> None:
        if self._held is not None:
            self._held.close()
            self._held = None


def buttons_of(event: DeviceEvent) -> QtCore.Qt.MouseButton:
    """Return the buttons that are held after an event."""
    held = NO_BUTTON
    for name in event.buttons:
        held |= BUTTONS[name]
    return held


def modifiers_of(event: DeviceEvent) -> QtCore.Qt.KeyboardModifier:
    """Return the keys that are held with an event."""
    held = QtCore.Qt.KeyboardModifier.NoModifier
    for name in event.modifiers:
        held |= MODIFIERS[name]
    return held


def pixel_of(
    window: StudioWindow, place: Sequence[float], aspect: float | None
) -> tuple[float, float]:
    """A place of a recording in the canvas, pixels from its upper left corner.

    With `aspect`, the width over the height of the picture that shares are counted in, they are of
    a picture as high as the canvas in its middle. Without, places are on the object, mm.
    """
    width, height = window.canvas.width(), window.canvas.height()
    if aspect is not None:
        return 0.5 * width + (place[0] - 0.5) * aspect * height, place[1] * height
    camera = window.hand.camera
    point = np.array([*place, 0.0][:3])
    right, up, back = picture_axes(camera)
    off = point - camera.position
    scale = 0.5 * height / math.tan(0.5 * camera.view_angle) / -float(off @ back)
    return 0.5 * width + scale * float(off @ right), 0.5 * height - scale * float(off @ up)


def surface_of(window: StudioWindow) -> ClosestPoints:
    """The object that is open, to be asked where rays meet it; made once for each."""
    mesh = window.workspace.painting.source
    if not _surfaces or _surfaces[0][0] is not mesh:
        _surfaces[:] = [(mesh, ClosestPoints(mesh))]
    return _surfaces[0][1]


def pen_ways(
    window: StudioWindow, recording: EventRecording, step_px: float = 1.0
) -> list[NDArray]:
    """The way (N, 3) of each stroke on the object, mm, where the pen's ray meets it; else nan.

    Between two events a ray may slip through a crack to what lies far behind, where the pen never
    said that it was: nan, too. The view must be that in which it is played.
    """
    surface = surface_of(window)
    size = (window.canvas.width(), window.canvas.height())
    aspect = recording.header.get("aspect")
    ways = []
    for stroke in recording.strokes():
        pixels = np.array([pixel_of(window, event.place, aspect) for event in stroke])
        lengths = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
        behind = np.concatenate([[0.0], np.cumsum(lengths)])
        at = np.linspace(0.0, behind[-1], max(2, math.ceil(behind[-1] / step_px) + 1))
        dense = np.stack([np.interp(at, behind, column) for column in pixels.T], axis=1)
        rays = [navigation.ray_at(window.hand.camera, x, y, size) for x, y in (*dense, *pixels)]
        hits = surface.cast(
            np.array([ray.origin for ray in rays]), np.array([ray.direction for ray in rays])
        )
        met = np.where(hits.hit[:, None], hits.points, np.nan)
        ways.append(without_slips(met[: len(at)], at, met[len(at) :], behind))
    return ways


def without_slips(way: NDArray, at: NDArray, events: NDArray, behind: NDArray) -> NDArray:
    """A way (N, 3) with nan where it lies farther from both events beside it than they lie apart.

    `at` (N,) and `behind` (E,) say how far the places and the events (E, 3) lie along the line.
    """
    k = np.clip(np.searchsorted(behind, at, side="right") - 1, 0, len(behind) - 2)
    before, after = events[k], events[k + 1]
    apart = np.linalg.norm(after - before, axis=1)
    off = np.minimum(*(np.linalg.norm(way - end, axis=1) for end in (before, after)))
    return np.where((off > apart + SLIP_MM)[:, None], np.nan, way)
