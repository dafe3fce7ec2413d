"""Rate control of the object by a 6-DOF mouse: deflections integrated over time.

A deflection is a rate, and the object's pose its integral, independent of the rate of reports: a
device read at 60 Hz and one read at 1 kHz turn the object equally far. A deflection holds until the
next report, for at most `SILENCE_NS`.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.core.quaternion import Quaternion, Vector, multiply, normalized, turn, turn_by
from paint3d.device.space_mouse import SILENCE_NS
from paint3d.errors import DeviceError

__all__ = ["ObjectPose", "SteeringOptions", "SteeringState", "advance", "apply_action", "report"]

_IDENTITY = (1.0, 0.0, 0.0, 0.0)
_NONE: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False, slots=True)
class ObjectPose:
    """world_from_object: position (3,) mm and unit quaternion (4,), w first."""

    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    orientation: NDArray[np.float64] = field(default_factory=lambda: np.array(_IDENTITY))


@dataclass(frozen=True, slots=True)
class SteeringOptions:
    """Options of steering by a 6-DOF mouse.

    Parameters
    ----------
    mode : {"object", "camera"}
        Whether the cap moves the object, or the viewer around it.
    speed_mm_s, turn_rad_s : float
        At full deflection.
    order : tuple of 6 int
        The cap's axis for each motion: along x, y, z, and the turns about them.
    inverted : tuple of 6 bool
        Motions to be reversed.
    moving, turning : bool
        False locks them.
    dominant_axis : bool
        Follow only the axis that is deflected farthest.
    zoom_axis : {"y", "z"}
        The cap's axis that brings the object nearer: pushing it away (y) or lifting it (z); for z,
        the two axes are swapped.
    pivot : tuple of 3 float
        Point of the object about which it turns in object mode, mm in its own frame.
    world_from_view : tuple of 4 float
        The user's point of view: rotates x right, y away, z up into the world.

    Raises
    ------
    DeviceError
        If one is out of range.
    """

    mode: str = "object"
    speed_mm_s: float = 150.0
    turn_rad_s: float = 1.5
    order: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    inverted: tuple[bool, ...] = (False,) * 6
    moving: bool = True
    turning: bool = True
    dominant_axis: bool = False
    zoom_axis: str = "y"
    pivot: Vector = (0.0, 0.0, 0.0)
    world_from_view: Quaternion = _IDENTITY

    def __post_init__(self) -> None:
        if self.mode not in ("object", "camera"):
            raise DeviceError("mode is {mode!r}; expected 'object' or 'camera'", mode=self.mode)
        if self.zoom_axis not in ("y", "z"):
            raise DeviceError(
                "zoom_axis is {zoom_axis!r}; expected 'y' or 'z'",
                zoom_axis=self.zoom_axis,
            )
        if sorted(self.order) != list(range(6)):
            raise DeviceError("order is {order}; expected each of 0 to 5 once", order=self.order)
        if len(self.inverted) != 6:
            raise DeviceError("inverted has {n} entries; expected 6", n=len(self.inverted))
        as_number(self.speed_mm_s, "speed_mm_s", 0.0, 5000.0, DeviceError)
        as_number(self.turn_rad_s, "turn_rad_s", 0.0, 50.0, DeviceError)
        as_array(self.pivot, "pivot", (3,), error=DeviceError)
        turn = as_array(self.world_from_view, "world_from_view", (4,), error=DeviceError)
        if abs(float(np.linalg.norm(turn)) - 1.0) > 1e-6:
            raise DeviceError("world_from_view is no unit quaternion")


@dataclass(frozen=True, eq=False, slots=True)
class SteeringState:
    """The object's pose at `time_ns` and its rates from then on.

    Attributes
    ----------
    time_ns : int
    pose : ObjectPose
    velocity : tuple of 3 float
        In the world, mm/s.
    spin : tuple of 3 float
        About the world's axes, rad/s.
    last_report_ns : int
        When the device last reported.
    """

    time_ns: int
    pose: ObjectPose = field(default_factory=ObjectPose)
    velocity: Vector = _NONE
    spin: Vector = _NONE
    last_report_ns: int = 0


def report(
    options: SteeringOptions, state: SteeringState, time_ns: int, deflection: ArrayLike
) -> SteeringState:
    """Return the state after a report of the cap's deflection (6,) at `time_ns`."""
    moved = advance(options, state, time_ns)
    velocity, spin = _rates(options, as_array(deflection, "deflection", (6,), error=DeviceError))
    return dataclasses.replace(moved, velocity=velocity, spin=spin, last_report_ns=moved.time_ns)


def advance(options: SteeringOptions, state: SteeringState, time_ns: int) -> SteeringState:
    """Return the state at a later time; a time before the state's changes nothing."""
    if time_ns <= state.time_ns:
        return state
    pose, velocity, spin = state.pose, state.velocity, state.spin
    if velocity != _NONE or spin != _NONE:
        until = min(time_ns, max(state.last_report_ns + SILENCE_NS, state.time_ns))
        if until > state.time_ns:
            pose = _moved(options, state, (until - state.time_ns) * 1e-9)
        if time_ns > until:
            velocity = spin = _NONE
    return SteeringState(time_ns, pose, velocity, spin, state.last_report_ns)


def apply_action(options: SteeringOptions, action: str) -> SteeringOptions:
    """Return the options after a button's action; most actions do not change them."""
    if action == "toggle_turning":
        return dataclasses.replace(options, turning=not options.turning)
    if action == "toggle_moving":
        return dataclasses.replace(options, moving=not options.moving)
    if action == "toggle_dominant_axis":
        return dataclasses.replace(options, dominant_axis=not options.dominant_axis)
    if action == "toggle_camera":
        mode = "object" if options.mode == "camera" else "camera"
        return dataclasses.replace(options, mode=mode)
    return options


def _rates(options: SteeringOptions, deflection: AnyArray) -> tuple[Vector, Vector]:
    """Compute velocity, mm/s, and angular velocity, rad/s, in the world."""
    rates = deflection[list(options.order)]
    rates = np.where(options.inverted, -rates, rates)
    if options.zoom_axis == "z":
        rates = rates[[0, 2, 1, 3, 4, 5]]
    rates[:3] *= options.speed_mm_s if options.moving else 0.0
    rates[3:] *= options.turn_rad_s if options.turning else 0.0
    if options.dominant_axis:
        full = np.repeat([max(options.speed_mm_s, 1e-9), max(options.turn_rad_s, 1e-9)], 3)
        rates[np.arange(6) != np.argmax(np.abs(rates / full))] = 0.0
    x, y, z, rx, ry, rz = rates.tolist()
    return turn(options.world_from_view, (x, y, z)), turn(options.world_from_view, (rx, ry, rz))


def _moved(options: SteeringOptions, state: SteeringState, seconds: float) -> ObjectPose:
    """Move the object by constant rates, exactly: two half steps equal one whole step."""
    x, y, z = state.velocity
    rx, ry, rz = state.spin
    if options.mode == "camera":
        seconds = -seconds
    shift = (x * seconds, y * seconds, z * seconds)
    angles = (rx * seconds, ry * seconds, rz * seconds)
    position: Vector = tuple(state.pose.position.tolist())
    before: Quaternion = tuple(state.pose.orientation.tolist())
    step = turn_by(angles)
    after = normalized(multiply(step, before))
    if options.mode == "camera":
        base, added = turn(step, position), _twist_translation(shift, angles)
    else:
        # The pivot stays where it is while the object turns:
        a, b = turn(before, options.pivot), turn(after, options.pivot)
        base = (position[0] + a[0] - b[0], position[1] + a[1] - b[1], position[2] + a[2] - b[2])
        added = shift
    return ObjectPose(
        np.array((base[0] + added[0], base[1] + added[1], base[2] + added[2])), np.array(after)
    )


def _twist_translation(shift: Vector, angles: Vector) -> Vector:
    """Compute the translation of a constant twist about the origin (exponential map of SE(3))."""
    angle = math.sqrt(angles[0] ** 2 + angles[1] ** 2 + angles[2] ** 2)
    if angle < 1e-4:  # series, where the closed forms lose all digits
        one, two = 0.5 - angle**2 / 24.0, 1.0 / 6.0
    else:
        one = (1.0 - math.cos(angle)) / angle**2
        two = (angle - math.sin(angle)) / angle**3
    across = _cross(angles, shift)
    twice = _cross(angles, across)
    return (
        shift[0] + one * across[0] + two * twice[0],
        shift[1] + one * across[1] + two * twice[1],
        shift[2] + one * across[2] + two * twice[2],
    )


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
