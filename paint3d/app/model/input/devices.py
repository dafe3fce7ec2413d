"""Devices of both hands: which are there, their state, and the commands of their buttons."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.settings import Settings, stored_calibration
from paint3d.brush.spec import BrushSpec
from paint3d.colour.materials import Material
from paint3d.core.arrays import AnyArray
from paint3d.device.hid_nodes import HidNode, list_nodes
from paint3d.device.hot_plug import PluggedDevices
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.report_timing import measure_report_rate
from paint3d.device.sample import DIP, DeviceSample, StylusReading
from paint3d.device.space_mouse import DeflectionSettings, MouseEvent, SpaceMouse
from paint3d.device.stylus import Stylus
from paint3d.errors import DeviceError, Message, Paint3DError
from paint3d.haptics.servo import ForceFeedback, ServoStatus
from paint3d.haptics.settings import PHANTOM_DESKTOP, DeviceLimits, Feel, HapticSettings
from paint3d.haptics.stylus_choice import find_stylus
from paint3d.pose.calibration import DeviceCalibration
from paint3d.pose.mouse_settings import (
    DEFAULT_ACTIONS,
    MouseSettings,
    checked_actions,
    find_actions,
)
from paint3d.pose.steering import ObjectPose, apply_action
from paint3d.pose.two_hands import TwoHands

__all__ = [
    "DeviceHub",
    "DeviceView",
    "Feeling",
    "HandInput",
    "NoDevices",
    "StrokeCutter",
    "plug_in_mice",
    "plug_in_pens",
    "start_feeling",
    "went_down",
]

_DOCUMENT_COMMANDS: Mapping[str, str] = {"dip": "dip", "undo": "undo", "redo": "redo"}
"""Actions of buttons that are commands of a `Document`; the others steer the object."""

_SETTLE_NS = 10_000_000  # how long a device may be late before its readings are merged
_REMEMBERED = 400  # readings that the rate is computed from
_LEFT = ("mouse",)

log = logging.getLogger("paint3d")


class Devices(Protocol):
    """Interface of `device.hot_plug.PluggedDevices`."""

    failures: dict[str, DeviceError]

    def nodes(self) -> list[HidNode]:
        """The nodes that are open."""

    def mice(self) -> list[SpaceMouse]:
        """The 6-DOF mice that are open."""

    def styli(self) -> list[Stylus]:
        """The styli and pens that are open."""

    def take_mouse(self) -> list[MouseEvent]:
        """Events of the mouse since the last call."""

    def take_stylus(self) -> list[StylusReading]:
        """Readings of all styli since the last call."""

    def set_deflection(self, deflection: DeflectionSettings) -> None:
        """Change the settings of all caps; see `PluggedDevices`."""

    def stop(self) -> None:
        """Close everything."""


class NoDevices:
    """Stands where HID devices cannot be read: see `Devices`."""

    def __init__(self) -> None:
        self.failures: dict[str, DeviceError] = {}

    def nodes(self) -> list[HidNode]:
        """None."""
        return []

    def mice(self) -> list[SpaceMouse]:
        """None."""
        return []

    def styli(self) -> list[Stylus]:
        """None."""
        return []

    def take_mouse(self) -> list[MouseEvent]:
        """None."""
        return []

    def take_stylus(self) -> list[StylusReading]:
        """None."""
        return []

    def set_deflection(self, deflection: DeflectionSettings) -> None:
        """There are none."""

    def stop(self) -> None:
        """There is nothing to close."""


class Feedback(Protocol):
    """Interface of `haptics.servo.ForceFeedback`."""

    last_force: AnyArray
    settings: HapticSettings

    def take(self) -> list[StylusReading]:
        """Readings of the haptic stylus since the last call."""

    def publish(self, object_pose: AnyArray | None = None) -> None:
        """Give the servo the object's pose, (7,), and show that the program is alive."""

    def click(self) -> None:
        """Play a click."""

    def is_running(self) -> bool:
        """Return whether the servo runs; the device of one that was killed is asked to stop."""

    def status(self) -> ServoStatus:
        """State of the servo, and why it failed."""

    def stop(self) -> None:
        """Stop the servo."""


@dataclass(frozen=True)
class DeviceView:
    """A device as it is listed.

    Attributes
    ----------
    name : str
    kind : {"mouse", "stylus", "pen"}
    hand : {"left", "right"}
    is_open : bool
    error : DeviceError or None
        Why it could not be opened, with the rule that would help; None where it is.
    """

    name: str
    kind: str
    hand: str
    is_open: bool
    error: DeviceError | None = None


@dataclass(frozen=True, eq=False)
class HandInput:
    """Samples and commands of the hands since the last call.

    Attributes
    ----------
    samples : list of DeviceSample
        In the order of time.
    commands : list of str
        Methods of `Document` that buttons asked for.
    object_pose : ObjectPose
        Where the left hand holds the object now.
    failures : tuple of DeviceError
        Why what a button asked for could not be done.
    """

    samples: list[DeviceSample]
    commands: list[str]
    object_pose: ObjectPose
    failures: tuple[DeviceError, ...] = ()


def went_down(button: int, before: int | None, buttons: list[int]) -> tuple[bool, int | None]:
    """Return whether a button of a stylus went down, and which are held now.

    Parameters
    ----------
    button : int
        Its bit.
    before : int or None
        Held until now; None where that is not known, and then what is held first went down before.
    buttons : list of int
        Held by reading.
    """
    known = buttons if before is None else [before, *buttons]
    down = any(now & ~then & button for then, now in pairwise(known))
    return down, known[-1] if known else None


class DeviceHub:
    """The devices of both hands; ask it some ten to a hundred times a second.

    Parameters
    ----------
    plugged : PluggedDevices
        Stopped by `stop`.
    hands : TwoHands, optional
    actions : mapping of int to str
        Of the 6-DOF mouse's buttons; see `pose.mouse_settings`.
    clock : callable
        Returns ns of the clock that readings are stamped by.
    feedback : ForceFeedback, optional
        Of a haptic stylus: its readings count, and it is given the object's pose. It is stopped
        by `stop`, and let go of when its process has ended.
    stylus_name : str
        Of that stylus.

    Attributes
    ----------
    hands : TwoHands
    ended : Message or None
        Why the force feedback has ended; None while it goes on, or there was none.
    """

    def __init__(
        self,
        plugged: Devices,
        hands: TwoHands | None = None,
        actions: Mapping[int, str] = DEFAULT_ACTIONS,
        clock: Callable[[], int] = time.monotonic_ns,
        feedback: Feedback | None = None,
        stylus_name: str = "stylus",
    ) -> None:
        self.hands = hands or TwoHands(time_ns=clock())
        self.ended: Message | None = None
        self._stylus_name = stylus_name
        self._plugged = plugged
        self._feedback = feedback
        self._actions = checked_actions(actions)
        self._clock = clock
        self._buttons = 0
        self._held: int | None = None  # by the stylus; None where it has not been heard
        self._reading_times: dict[str, deque[int]] = {h: deque(maxlen=_REMEMBERED) for h in _HANDS}
        self._force = 0.0

    def views(self) -> list[DeviceView]:
        """All devices: the open ones first, then those that could not be opened."""
        views = [
            DeviceView(node.name, node.kind, "left" if node.kind in _LEFT else "right", True)
            for node in self._plugged.nodes()
        ]
        if self._feedback is not None:
            views.append(DeviceView(self._stylus_name, "stylus", "right", True))
        failures = dict(self._plugged.failures)
        return views + [DeviceView(path, "", "", False, why) for path, why in failures.items()]

    def set_mouse(self, settings: MouseSettings) -> None:
        """Set how the 6-DOF mouse is read from now on."""
        self.hands.steering = settings.steering()
        self._plugged.set_deflection(settings.deflection())

    def set_actions(self, actions: Mapping[int, str]) -> None:
        """Assign actions to the 6-DOF mouse's buttons; see `pose.mouse_settings`."""
        self._actions = checked_actions(actions)

    def take(self) -> HandInput:
        """Take what the devices sent, and do what their buttons ask of the object."""
        events, readings = self._plugged.take_mouse(), self._plugged.take_stylus()
        if self._feedback is not None:
            readings = sorted([*readings, *self._feedback.take()], key=lambda one: one.time_ns)
            if not self._feedback.is_running():
                self.ended = self._feedback.status().fault or Message("its process stopped")
                log.warning("force feedback has ended: %s", self.ended)
                self._feedback.stop()
                self._feedback, self._force = None, 0.0
        commands: list[str] = []
        failures: list[DeviceError] = []
        samples: list[DeviceSample] = []
        self.hands.add_stylus(readings)
        for event in events:
            self.hands.add_deflection(event.time_ns, event.deflection)
            for action in find_actions(self._buttons, event.buttons, self._actions):
                samples += self.hands.take(event.time_ns)  # what was before it
                try:
                    commands += self._run_action(action)
                except DeviceError as failure:
                    failures.append(failure)
            self._buttons = event.buttons
        by_stylus, self._held = went_down(DIP, self._held, [one.buttons for one in readings])
        if self._feedback is not None and (by_stylus or "dip" in commands):
            self._feedback.click()
        self._reading_times["left"].extend(event.time_ns for event in events)
        self._reading_times["right"].extend(reading.time_ns for reading in readings)
        if self._feedback is not None:
            self._force = float(np.linalg.norm(self._feedback.last_force))
            pose = self.hands.object_pose
            self._feedback.publish(np.concatenate([pose.position, pose.orientation]))
        elif readings:
            self._force = MAX_FORCE_N * (readings[-1].pressure or 0.0)
        samples += self.hands.take(self._clock() - _SETTLE_NS)
        return HandInput(samples, commands, self.hands.object_pose, tuple(failures))

    def _run_action(self, action: str) -> list[str]:
        """Do what concerns the object; what concerns the document."""
        if action in _DOCUMENT_COMMANDS:
            return [_DOCUMENT_COMMANDS[action]]
        if action == "recentre":
            self.hands.set_object_pose(ObjectPose())
        elif action == "calibrate_rest":
            for mouse in self._plugged.mice():
                mouse.calibrate_rest()
        else:
            self.hands.steering = apply_action(self.hands.steering, action)
        return []

    @property
    def force_n(self) -> float:
        """Force on the brush by the last reading, N, for a gauge up to 7.9 N."""
        return self._force

    def rate_hz(self, hand: str) -> float:
        """Rate of reports of a hand's device, Hz; 0 where there are none."""
        return measure_report_rate(np.array(self._reading_times[hand], np.int64)).rate_hz

    def lateness_ms(self, hand: str) -> float:
        """By how much one report in a hundred comes later than most, ms; 0 where there are few."""
        rate = measure_report_rate(np.array(self._reading_times[hand], np.int64))
        late = rate.interval_p99_ms - rate.interval_p50_ms
        return float(late) if np.isfinite(late) else 0.0

    def lost(self) -> int:
        """Number of reports of styli that never came."""
        return sum(stylus.lost for stylus in self._plugged.styli())

    def stop(self) -> None:
        """Close everything."""
        if self._feedback is not None:
            self._feedback.stop()
        self._plugged.stop()


_HANDS = ("left", "right")


class StrokeCutter:
    """Splits the stream of a hand into strokes: from before it touches until it has left.

    Parameters
    ----------
    touches : callable, optional
        Whether the brush touches in a sample; by default whether it is pressed, which a device
        without pressure cannot say: for that, ask `Painter.contact`.
    """

    def __init__(self, touches: Callable[[DeviceSample], bool] | None = None) -> None:
        self._touches = touches or (lambda sample: (sample.pressure or 0.0) > 0.0)
        self._before: DeviceSample | None = None
        self._down = False

    @property
    def is_down(self) -> bool:
        """True if a stroke is going on."""
        return self._down

    def cut(self, samples: Iterable[DeviceSample]) -> list[str | list[DeviceSample]]:
        """Split samples into strokes, with "begin_stroke" and "end_stroke" between them."""
        parts: list[str | list[DeviceSample]] = []
        for sample in samples:
            down = self._touches(sample)
            if down and not self._down:
                parts.append("begin_stroke")
                parts.append([] if self._before is None else [self._before])
            if down or self._down:
                if parts and isinstance(parts[-1], list):
                    parts[-1].append(sample)
                else:
                    parts.append([sample])
            if self._down and not down:
                parts.append("end_stroke")
            self._down, self._before = down, sample
        return [part for part in parts if part]

    def end(self) -> bool:
        """Stop listening to the hand; return whether a stroke was going on."""
        was_down, self._down, self._before = self._down, False, None
        return was_down


# ---- Plugging ------------------------------------------------------------------------------------
# Which devices the studio opens itself, and which it leaves to the window system.


def plug_in_mice(settings: MouseSettings | None = None) -> PluggedDevices | None:
    """Open the 6-DOF mice that are there or come; None where HID devices cannot be read.

    A pen is left to the window system, whose events say where it is in the picture, although its
    node may be opened: read here as well it would be a second brush, at the pad's place in the
    object's millimetres. Styli with motors are opened by who feels with them.
    """
    read = (settings or MouseSettings()).deflection()
    try:
        return PluggedDevices(find=lambda: list_nodes(("mouse",)), deflection=read)
    except (Paint3DError, ImportError, OSError):
        return None


def plug_in_pens() -> PluggedDevices | None:
    """Open the pads whose pens can be read, to calibrate one; None without HID devices."""
    try:
        return PluggedDevices(find=lambda: list_nodes(("pen",)))
    except (Paint3DError, ImportError, OSError):
        return None


@dataclass
class Feeling:
    """A stylus that pushes back, and what its force is made of.

    Attributes
    ----------
    feedback : Feedback
    name, key : str
        Of the device: see `DetectedStylus`.
    limits : DeviceLimits
    calibration : DeviceCalibration
        By which its readings come.
    """

    feedback: Feedback
    name: str = "stylus"
    key: str = "stylus"
    limits: DeviceLimits = PHANTOM_DESKTOP
    calibration: DeviceCalibration | None = None
    _felt: tuple[BrushSpec, Feel, Material] | None = None

    def follow(self, brush: BrushSpec, feel: Feel, material: Material) -> None:
        """Set the force from this brush, surface and choices, from the next step on."""
        now, before = (brush, feel, material), self._felt
        if before is None or before[0] is not brush or before[1:] != now[1:]:
            self._felt = now
            self.feedback.settings = feel.settings(brush, self.limits, material)


def start_feeling(document: Document, settings: Settings) -> Feeling | None:
    """Start the force feedback of the stylus that was chosen; None where there is none.

    Raises
    ------
    Paint3DError
        If the one that was chosen is not there, saying what is missing; or it does not start.
    """
    stylus = find_stylus(settings.stylus)
    if stylus is None:
        return None
    feel, brush = Feel.from_dict(settings.feel), document.painter.brush
    calibration = stored_calibration(stylus.key) or stylus.frame
    surface = document.surface
    felt = feel.settings(brush, stylus.limits, surface.material)
    feedback = ForceFeedback(stylus.port, surface.contact_tree, felt, calibration)
    return Feeling(feedback, stylus.name, stylus.key, stylus.limits, calibration)
