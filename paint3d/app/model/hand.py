"""From a pointer over a picture of the object to a brush standing on it.

A window says where the pointer's ray meets the object, or gives the ray; the brush stands there
on the surface's normal, leaning as the tablet's pen leans. What a mouse cannot say is made up: the
pressure from keys, wheel or speed, and the bend from the way, for the tuft trails behind. Strokes
can be steadied by a string that pulls the brush; its end is reached when the stroke ends.

One step after the other over events; nothing here has a clock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from paint3d.app.model.pressure_curve import PressureCurve
from paint3d.arrays import as_array, as_number
from paint3d.brush.bending import build_tuft
from paint3d.brush.spec import BrushSpec
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.sample import DeviceSample
from paint3d.errors import InputError
from paint3d.frames import quaternions_from_matrices
from paint3d.kernels.tuft import (
    OUTLINE_CAPACITY,
    SCRATCH_SIZE,
    Tuft,
    greatest_descent,
    trace_outline,
)
from paint3d.mesh.closest import ClosestPoints

__all__ = ["Hand", "HandSettings", "PointerInput"]

_REST = np.array([1.0, 0.0, 0.0, 0.0])
_MOST_LEAN = math.radians(60.0)
_HOVER = 0.25  # of the tuft's length: the gap under a brush that is lifted
_STEP_NS = 1_000_000
_GLIDE_MM_S = 150.0  # how fast a steadied brush is brought to the end of its string
_GLIDE_STEP_MM = 0.5
_LEAST_GAP_MM = 3.0
_PLACES_BETWEEN = (0.25, 0.5, 0.75)
_MOST_OFF = 0.2  # of the way between two events: a quarter of a sphere's outline leaves it by 0.21
_RISE_STEPS = 6  # in which a centred brush is lifted
_FILTER_S = 0.03  # over which the pointer's speed is taken


@dataclass(frozen=True, eq=False)
class PointerInput:
    """What a pointer said at one instant; all vectors in the object's frame.

    Attributes
    ----------
    time_ns : int
    point, normal : (3,) or None
        Where it meets the surface, mm, and the normal there; or:
    origin, direction : (3,) or None
        The ray through it.
    right, up : (3,) or None
        The picture's axes, which tilt is counted by; None: the pen has no tilt.
    pressure : float or None
        0 to 1; None where the device has none.
    x_tilt, y_tilt : float
        Degrees that the pen leans to the right, and towards the user (down in the picture).
    rotation : float or None
        Degrees clockwise about the pen's own axis; None where the device does not tell.
    buttons : int
        Bit field of `DeviceSample`.
    harder, softer : bool
        Whether these keys are held, for a device without pressure.
    wheel : float
        Notches since the last event, for the same.
    """

    time_ns: int
    point: Sequence[float] | None = None
    normal: Sequence[float] | None = None
    origin: Sequence[float] | None = None
    direction: Sequence[float] | None = None
    right: Sequence[float] | None = None
    up: Sequence[float] | None = None
    pressure: float | None = None
    x_tilt: float = 0.0
    y_tilt: float = 0.0
    rotation: float | None = None
    buttons: int = 0
    harder: bool = False
    softer: bool = False
    wheel: float = 0.0


@dataclass(frozen=True)
class HandSettings:
    """How the hand is read.

    Attributes
    ----------
    curve : PressureCurve
    smoothing : float
        0 to 1: the string's length over `longest_string_mm`.
    longest_string_mm : float
    trail : float
        Share of the tuft's length that its tip trails behind the brush.
    pressure_by : {"keys", "speed"}
        What gives the pressure of a device that has none.
    newtons_per_s, newtons_per_notch : float
        How fast keys and wheel change it.
    steady_mm_s : float
        By speed: that at which the pressure has fallen to a half of the set one.
    landing_s : float
        Over which the pressure of a device that has none rises when it goes down.
    centred : bool
        Whether the middle of the footprint is brought under the pointer; else the foot of the
        tuft's root, behind which the tip trails.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    curve: PressureCurve = field(default_factory=PressureCurve)
    smoothing: float = 0.0
    longest_string_mm: float = 20.0
    trail: float = 0.12
    pressure_by: str = "keys"
    newtons_per_s: float = 3.0
    newtons_per_notch: float = 0.25
    steady_mm_s: float = 150.0
    landing_s: float = 0.06
    centred: bool = True

    def __post_init__(self) -> None:
        as_number(self.smoothing, "smoothing", 0.0, 1.0)
        as_number(self.longest_string_mm, "longest string (mm)", 0.0, 1000.0)
        as_number(self.trail, "trail", 0.01, 1.0)
        as_number(self.steady_mm_s, "steady speed (mm/s)", 1.0, 1e5)
        as_number(self.landing_s, "landing (s)", 0.0, 1.0)
        if self.pressure_by not in ("keys", "speed"):
            raise InputError(f"pressure by {self.pressure_by!r}; expected 'keys' or 'speed'")


@dataclass
class _State:
    """What is remembered between events."""

    time_ns: int
    target: NDArray  # where the pointer is, on the surface
    point: NDArray  # where the brush is
    normal: NDArray
    tip: NDArray  # where the tuft's tip trails
    lean: NDArray  # unit, up the handle
    began_ns: int | None = None
    beside: bool = False
    speed: float = 0.0
    pressure: float = 0.0
    twist: float | None = None
    buttons: int = 0
    sent_ns: int = 0


class Hand:
    """Reads one pointer over one object.

    Parameters
    ----------
    surface : ClosestPoints
        Of the object's mesh.
    settings : HandSettings
    force : float
        Of a device that has no pressure, at first, N.

    Attributes
    ----------
    settings : HandSettings
    force : float
        N; see `HandSettings.newtons_per_s`.
    """

    def __init__(
        self, surface: ClosestPoints, settings: HandSettings | None = None, force: float = 1.5
    ) -> None:
        self.settings = settings or HandSettings()
        self.force = as_number(force, "force (N)", 0.0, MAX_FORCE_N)
        self._surface = surface
        self._state: _State | None = None

    def hover(self, event: PointerInput, brush: BrushSpec) -> DeviceSample | None:
        """The brush above the surface; None where the pointer is beside the object."""
        if not self._move(event, brush, pulled=False):
            return None
        return self._sample(brush, event.time_ns, lifted=True)

    def begin(self, event: PointerInput, brush: BrushSpec) -> list[DeviceSample]:
        """The brush comes down; no samples where the pointer is beside the object."""
        if not self._move(event, brush, pulled=False):
            return []
        state = self._state
        state.began_ns = event.time_ns
        state.beside = False
        state.speed, state.sent_ns = 0.0, 0
        state.pressure = 0.0
        state.tip = state.point + _any_tangent(state.normal, state.tip - state.point)
        return [self._sample(brush, event.time_ns, pressure=0.0)]

    def move(self, event: PointerInput, brush: BrushSpec) -> list[DeviceSample]:
        """The pointer went on; no samples where it is beside the object or time stood still.

        Where it comes back from beside the object, or from one part of it to another that lies
        behind, the brush is lifted and put down again.
        """
        state = self._state
        if state is None or state.began_ns is None or event.time_ns <= state.sent_ns:
            return []
        found = self._meet(event)
        if found is None:
            state.beside = True
        elif state.beside or self._is_apart(found[0]):
            return self._step_over(event, brush)
        if not self._move(event, brush, pulled=True):
            return []
        return [self._sample(brush, event.time_ns, pressure=self._pressure(event))]

    def end(self, time_ns: int, brush: BrushSpec) -> list[DeviceSample]:
        """The brush goes to where the pointer is, and up."""
        state = self._state
        if state is None or state.began_ns is None:
            return []
        samples = self._glide(brush)
        state.began_ns = None
        at = max(time_ns, state.sent_ns + _STEP_NS)
        return samples + self._rise(brush, at)

    # -- steps ------------------------------------------------------------------------------

    def _is_apart(self, point: NDArray) -> bool:
        """Whether the way to a point leaves the surface, as from a rim to what is behind it."""
        way = point - self._state.target
        distance = float(np.linalg.norm(way))
        if distance < _LEAST_GAP_MM:
            return False
        between = self._state.target + np.outer(_PLACES_BETWEEN, way)
        off = np.linalg.norm(self._surface.find(between).points - between, axis=1)
        return bool(off.max() > _MOST_OFF * distance)

    def _step_over(self, event: PointerInput, brush: BrushSpec) -> list[DeviceSample]:
        """Up where the brush is, and down where the pointer is now."""
        lifted = self.end(self._state.sent_ns, brush)
        landed = max(event.time_ns, self._state.sent_ns + _STEP_NS)
        return lifted + self.begin(replace(event, time_ns=landed), brush)

    def _move(self, event: PointerInput, brush: BrushSpec, pulled: bool) -> bool:
        """Take the pointer's new place; False where it has none."""
        found = self._meet(event)
        self._press_keys(event)
        if found is None:
            return False
        point, normal = found
        state = self._state
        if state is None:
            trail = _any_tangent(normal, np.zeros(3)) * self._trail(brush)
            state = _State(event.time_ns, point, point, normal, point + trail, normal)
            self._state = state
        self._follow_speed(event.time_ns, point)
        state.time_ns, state.target = event.time_ns, point
        string = self.settings.smoothing * self.settings.longest_string_mm if pulled else 0.0
        if string > 0.0:
            point, normal = self._pull(point, string)
        self._put(point, normal, brush)
        state.lean = _lean(normal, event)
        state.twist = None if event.rotation is None else math.radians(event.rotation)
        state.buttons = event.buttons
        return True

    def _meet(self, event: PointerInput) -> tuple[NDArray, NDArray] | None:
        """Where the pointer meets the surface, and the normal there."""
        if event.point is not None and event.normal is not None:
            normal = as_array(event.normal, "normal", (3,))
            return as_array(event.point, "point", (3,)), normal / np.linalg.norm(normal)
        if event.origin is None or event.direction is None:
            return None
        origin = as_array(event.origin, "origin", (3,))
        hits = self._surface.cast(origin[None], as_array(event.direction, "direction", (3,))[None])
        return self._on_surface(hits.points[0]) if hits.hit[0] else None

    def _on_surface(self, point: NDArray) -> tuple[NDArray, NDArray]:
        found = self._surface.find(point[None])
        return found.points[0], found.normals[0]

    def _pull(self, target: NDArray, string: float) -> tuple[NDArray, NDArray]:
        """Where a string of this length pulls the brush."""
        state = self._state
        way = target - state.point
        distance = float(np.linalg.norm(way))
        if distance <= string:
            return state.point, state.normal
        return self._on_surface(state.point + (1.0 - string / distance) * way)

    def _put(self, point: NDArray, normal: NDArray, brush: BrushSpec) -> None:
        """Bring the brush to a point; its tip is dragged along the surface behind it."""
        state, trail = self._state, self._trail(brush)
        back = state.tip - point
        back = back - (back @ normal) * normal
        distance = float(np.linalg.norm(back))
        if distance < 1e-9:
            back = _any_tangent(normal, state.tip - state.point) * trail
        elif distance > trail:
            back *= trail / distance
        state.point, state.normal, state.tip = point, normal, point + back

    def _glide(self, brush: BrushSpec) -> list[DeviceSample]:
        """Samples on the way to where the pointer was last."""
        state = self._state
        start, way = state.point, state.target - state.point
        length = float(np.linalg.norm(way))
        n = math.ceil(length / _GLIDE_STEP_MM)
        step_ns = round(length / max(n, 1) / _GLIDE_MM_S * 1e9)
        samples = []
        for k in range(1, n + 1):
            self._put(*self._on_surface(start + (k / n) * way), brush)
            at = state.sent_ns + max(step_ns, _STEP_NS)
            samples.append(self._sample(brush, at, pressure=state.pressure))
        return samples

    def _press_keys(self, event: PointerInput) -> None:
        settings, state = self.settings, self._state
        seconds = 0.0 if state is None else max(0.0, (event.time_ns - state.time_ns) * 1e-9)
        change = settings.newtons_per_s * seconds * (int(event.harder) - int(event.softer))
        change += settings.newtons_per_notch * event.wheel
        self.force = min(MAX_FORCE_N, max(0.0, self.force + change))

    def _follow_speed(self, time_ns: int, point: NDArray) -> None:
        """The pointer's speed, mm/s, over the last hundredths of a second."""
        state = self._state
        seconds = (time_ns - state.time_ns) * 1e-9
        if seconds > 0.0:
            now = float(np.linalg.norm(point - state.target)) / seconds
            weight = 1.0 - math.exp(-seconds / _FILTER_S)
            state.speed += weight * (now - state.speed)

    def _pressure(self, event: PointerInput) -> float:
        state, settings = self._state, self.settings
        if event.pressure is not None:
            pressure = settings.curve(as_number(event.pressure, "pressure", 0.0, 1.0))
        else:
            pressure = self.force / MAX_FORCE_N
            if settings.pressure_by == "speed":
                pressure *= 1.0 / (1.0 + state.speed / settings.steady_mm_s)
            since = (event.time_ns - state.began_ns) * 1e-9
            if since < settings.landing_s:
                pressure *= since / settings.landing_s
        state.pressure = pressure
        return pressure

    def _lead(self, brush: BrushSpec, pressure: float) -> float:
        """How far the root goes ahead, mm, for the footprint's middle to lie under the pointer."""
        if not self.settings.centred or pressure <= 0.0:
            return 0.0
        state = self._state
        tilt = math.asin(min(1.0, max(0.5, float(state.lean @ state.normal))))
        return _middle_reach(build_tuft(brush), pressure, tilt)

    def _rise(self, brush: BrushSpec, time_ns: int) -> list[DeviceSample]:
        """The brush goes up where it is; the footprint shrinks about its own middle."""
        pressure, samples = self._state.pressure, []
        for k in range(1, _RISE_STEPS if self.settings.centred and pressure > 0.0 else 1):
            share = 1.0 - k / _RISE_STEPS
            samples.append(self._sample(brush, time_ns, pressure=share * pressure))
            time_ns += _STEP_NS
        return [*samples, self._sample(brush, time_ns, pressure=0.0)]

    def _trail(self, brush: BrushSpec) -> float:
        return self.settings.trail * brush.length_mm

    def _sample(
        self, brush: BrushSpec, time_ns: int, pressure: float = 0.0, lifted: bool = False
    ) -> DeviceSample:
        state = self._state
        z = state.lean
        bend = state.tip - state.point
        x = _any_tangent(z, bend)
        if state.twist is not None:
            x = _turned(_any_tangent(z, np.array([1.0, 0.0, 0.0])), z, -state.twist)
        orientation = quaternions_from_matrices(np.stack([x, np.cross(z, x), z], axis=-1)[None])[0]
        height = brush.length_mm - pressure * brush.full_press_mm
        height += _HOVER * brush.length_mm if lifted else 0.0
        state.sent_ns = time_ns
        lead = self._lead(brush, pressure)
        return DeviceSample(
            time_ns,
            state.point + height * state.normal - lead * _any_tangent(state.normal, x),
            orientation,
            pressure,
            state.buttons,
            np.zeros(3),
            _REST,
        )


def _middle_reach(tuft: Tuft, pressure: float, tilt: float) -> float:
    """How far along the bend the middle of a footprint lies from the foot, mm; 0 for none."""
    reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    descent = min(pressure * tuft.full_press, greatest_descent(tuft, tilt))
    n = trace_outline(tuft, descent, tilt, pressure, np.empty(SCRATCH_SIZE), reach, half)
    return 0.5 * float(reach[0] + reach[n - 1]) if n else 0.0


def _lean(normal: NDArray, event: PointerInput) -> NDArray:
    """Up the handle: the surface's normal, leaned over as the pen leans in the picture."""
    if event.right is None or event.up is None or not (event.x_tilt or event.y_tilt):
        return normal
    x, y = (math.tan(math.radians(_limited(t))) for t in (event.x_tilt, event.y_tilt))
    aside = x * as_array(event.right, "right", (3,)) - y * as_array(event.up, "up", (3,))
    aside = aside - (aside @ normal) * normal
    length = float(np.linalg.norm(aside))
    if length < 1e-9:
        return normal
    angle = min(math.atan(length), _MOST_LEAN)
    return math.cos(angle) * normal + math.sin(angle) / length * aside


def _limited(degrees: float) -> float:
    return min(max(as_number(degrees, "tilt (degrees)"), -85.0), 85.0)


def _any_tangent(normal: NDArray, wanted: NDArray) -> NDArray:
    """The unit vector across the normal that is nearest to the wanted one."""
    for candidate in (wanted, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])):
        across = candidate - (candidate @ normal) * normal
        length = float(np.linalg.norm(across))
        if length > 1e-9 * max(1.0, float(np.linalg.norm(candidate))):
            return across / length
    return np.array([0.0, 0.0, 1.0])


def _turned(vector: NDArray, axis: NDArray, angle: float) -> NDArray:
    return math.cos(angle) * vector + math.sin(angle) * np.cross(axis, vector)
