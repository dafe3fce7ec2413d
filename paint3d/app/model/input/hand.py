"""From a pointer over a picture of the object to a brush standing on it.

A window says where the pointer's ray meets the object, or gives the ray. That point is what every
sample says as its contact: the middle of the footprint comes to lie there, however the pen leans.
What a mouse cannot say is made up: the pressure from keys, wheel or speed, and the bend from the
way, for the tuft trails behind, unless a direction is given (Guo 2015, Table 2: device I). A stroke
waits until it is known whither it goes, so that the tuft comes down trailing and need not turn
round. Strokes can be steadied by a string that pulls the brush; its end is reached when the stroke
ends.

One step after the other over events; nothing here has a clock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from paint3d.app.model.input.pressure_curve import PressureCurve
from paint3d.brush.bending import build_tuft
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, trace_outline
from paint3d.brush_engine.tuft import Tuft, greatest_descent
from paint3d.core.arrays import AnyArray, as_array, as_number, cross, length_of
from paint3d.core.quaternion import quaternions_from_matrices
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.sample import DeviceSample
from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints

__all__ = [
    "Hand",
    "HandSettings",
    "PointerInput",
    "root_over",
]

# ---- How the brush stands ------------------------------------------------------------------------
# How a brush stands over the point that a pointer means: its lean, and where its root is.


_MOST_LEAN = math.radians(60.0)
_STEEPEST_TILT = 85.0  # degrees that a tablet may say


def _lean_of(
    normal: AnyArray,
    right: Sequence[float] | AnyArray | None,
    up: Sequence[float] | AnyArray | None,
    x_tilt: float,
    y_tilt: float,
) -> AnyArray:
    """Up the handle: the surface's normal, leaned over as the pen leans in the picture.

    Parameters
    ----------
    normal : (3,)
        Of the surface, unit.
    right, up : (3,) or None
        The picture's axes; None: the pen has no tilt.
    x_tilt, y_tilt : float
        Degrees that the pen leans to the right, and towards the user (down in the picture).

    Returns
    -------
    (3,) float64
        Unit, at most 60 degrees from the normal.
    """
    if right is None or up is None or not (x_tilt or y_tilt):
        return normal
    tilts = (as_number(degrees, "tilt (degrees)") for degrees in (x_tilt, y_tilt))
    x, y = (math.tan(math.radians(min(max(t, -_STEEPEST_TILT), _STEEPEST_TILT))) for t in tilts)
    aside = x * as_array(right, "right", (3,)) - y * as_array(up, "up", (3,))
    aside = aside - (aside @ normal) * normal
    length = length_of(aside)
    if length < 1e-9:
        return normal
    angle = min(math.atan(length), _MOST_LEAN)
    return math.cos(angle) * normal + math.sin(angle) / length * aside


def _limit_lean(lean: AnyArray, normal: AnyArray) -> AnyArray:
    """Handle's direction, limited to 60 degrees from a normal that turns towards it.

    Parameters
    ----------
    lean, normal : (3,)
        Unit.
    """
    along = float(lean @ normal)
    if along >= math.cos(_MOST_LEAN) - 1e-9:
        return lean
    aside = _any_tangent(normal, lean)
    return math.cos(_MOST_LEAN) * normal + math.sin(_MOST_LEAN) * aside


def _rotate_between(before: AnyArray, after: AnyArray, vector: AnyArray) -> AnyArray:
    """Turn a vector as one normal turns into another, the shortest way.

    Parameters
    ----------
    before, after : (3,)
        Unit; where they are opposite, the vector stays as it is.
    vector : (3,)
    """
    both = before + after
    one_plus_cosine = 0.5 * float(both @ both)
    if one_plus_cosine < 1e-9:
        return vector
    across = float(both @ vector) / one_plus_cosine
    return vector - across * both + 2.0 * float(before @ vector) * after


def root_over(
    brush: BrushSpec,
    point: AnyArray,
    normal: AnyArray,
    bend: AnyArray,
    handle: AnyArray,
    pressure: float,
) -> AnyArray:
    """Root of the tuft when the middle of its footprint lies at a point, on a plane there.

    Painting asks for the point and not for the root (`DeviceSample.contact`); the root is what a
    recording says besides, and a program that knows no points paints by it.

    Parameters
    ----------
    brush : BrushSpec
    point, normal : (3,)
        On the surface, mm, and the unit normal there.
    bend : (3,)
        Unit, along the surface, from the root's foot to the tip.
    handle : (3,)
        Unit, up the handle.
    pressure : float
        0 to 1; 0: the straight tuft's tip is at the point.

    Returns
    -------
    (3,) float64
        mm.
    """
    if pressure <= 0.0:
        return point + brush.length_mm * handle
    upright, ahead = float(handle @ normal), float(handle @ bend)
    tilt = math.acos(min(1.0, max(0.0, -ahead)))
    tuft = build_tuft(brush)
    descent = min(pressure * tuft.full_press, greatest_descent(tuft, max(tilt, tuft.lowest_tilt)))
    foot = point - _middle_reach(tuft, descent, tilt, pressure) * bend
    height = max(0.0, brush.length_mm * upright - descent)
    aside = handle - upright * normal - min(0.0, ahead) * bend  # what is no lean along the bend
    result: AnyArray = foot + height * normal + brush.length_mm * aside
    return result


def _middle_reach(tuft: Tuft, descent: float, tilt: float, pressure: float) -> float:
    """Distance along the bend from the foot to a footprint's middle, mm; 0 without one."""
    reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    n = trace_outline(tuft, descent, tilt, pressure, np.empty(SCRATCH_SIZE), reach, half)
    return 0.5 * float(reach[0] + reach[n - 1]) if n else 0.0


def _any_tangent(normal: AnyArray, wanted: AnyArray) -> AnyArray:
    """Unit vector across the normal that is nearest to the wanted one."""
    for candidate in (wanted, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])):
        across = candidate - (candidate @ normal) * normal
        length = length_of(across)
        if length > 1e-9 * max(1.0, length_of(candidate)):
            result: AnyArray = across / length
            return result
    return np.array([0.0, 0.0, 1.0])


# ---- The hand ------------------------------------------------------------------------------------


_REST = np.array([1.0, 0.0, 0.0, 0.0])
_HOVER = 0.25  # of the tuft's length: the gap under a brush that is lifted
_STEP_NS = 1_000_000
_GLIDE_MM_S = 150.0  # how fast a steadied brush is brought to the end of its string
_GLIDE_STEP_MM = 0.5
_LEAST_GAP_MM = 3.0
_FRACTIONS_BETWEEN = (0.25, 0.5, 0.75)
_MOST_OFF = 0.2  # of the way between two events: a quarter of a sphere's outline leaves it by 0.21
_HALVINGS = 7  # of the angle between two rays, to find an edge between them
_LEAST_SHRINKING = 0.6  # of a way: a part that stays greater is an edge's
_FILTER_S = 0.03  # over which the pointer's speed is taken
# of the trail: a path so long shows a stroke's direction, and the shorter one if need be
_SURE_DIRECTION, _LEAST_DIRECTION = 0.3, 0.15
_STANDS_NS = 150_000_000  # after which a brush that does not move comes down as it is
_LEANS = math.sin(math.radians(5.0))  # a pen that leans more has its tip on the other side
_UNDER = 0.07  # of the tuft's length: half a footprint, about
_SUNK = 0.35  # of that: how far under the surface its rim is looked for
_OTHER_SIDE = -0.5  # cosine to the normal: what faces farther away is the other side of a wall
_RIM = np.stack([f(0.25 * math.pi * np.arange(8)) for f in (np.cos, np.sin)], axis=1)
_TURNS = math.radians(12.0)  # a surface that turns by more between two points is looked at there
_LIFTED_OVER = 0.15  # of the tuft's length: a release farther from the last point is no path to it


@dataclass(frozen=True, eq=False)
class PointerInput:
    """State of a pointer at one instant; all vectors in the object's frame.

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
        Degrees clockwise about the pen's own axis; None where the device does not report it.
    buttons : int
        Bit field of `DeviceSample`.
    harder, softer : bool
        Whether these keys are held, for a device without pressure.
    wheel : float
        Notches since the last event, for the same.
    bend : (3,) or None
        Direction that the tuft's tip shall point in, of any length; None: it trails behind.
    """

    time_ns: int
    point: Sequence[float] | AnyArray | None = None
    normal: Sequence[float] | AnyArray | None = None
    origin: Sequence[float] | AnyArray | None = None
    direction: Sequence[float] | AnyArray | None = None
    right: Sequence[float] | AnyArray | None = None
    up: Sequence[float] | AnyArray | None = None
    pressure: float | None = None
    x_tilt: float = 0.0
    y_tilt: float = 0.0
    rotation: float | None = None
    buttons: int = 0
    harder: bool = False
    softer: bool = False
    wheel: float = 0.0
    bend: Sequence[float] | AnyArray | None = None


RULERS = ("none", "straight", "ring", "profile")
"""What strokes are led along: nothing; a straight way; level around the object; up or down it, in a
plane through its upright axis."""

_RULED = 4  # steps to where the ruler and the surface meet
_LEAST_ARM_MM = 2.0  # from which a ruler's direction is taken


@dataclass(frozen=True)
class HandSettings:
    """Settings for reading the hand.

    Attributes
    ----------
    curve : PressureCurve
    smoothing : float
        0 to 1: the string's length over `longest_string_mm`.
    mouse_smoothing : float
        The same at least, for a device that has no pressure: a mouse, or a finger.
    longest_string_mm : float
    ruler : str
        One of `RULERS`: what a stroke is led along.
    trail : float
        Fraction of the tuft's length that its tip trails behind the brush.
    pressure_by : {"keys", "speed"}
        What gives the pressure of a device that has none.
    newtons_per_s, newtons_per_notch : float
        How fast keys and wheel change it.
    steady_mm_s : float
        By speed: that at which the pressure has fallen to a half of the set one.
    landing_s : float
        Over which the pressure of a device that has none rises when it goes down.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    curve: PressureCurve = field(default_factory=PressureCurve)
    smoothing: float = 0.0
    mouse_smoothing: float = 0.0
    longest_string_mm: float = 20.0
    trail: float = 0.12
    pressure_by: str = "keys"
    newtons_per_s: float = 3.0
    newtons_per_notch: float = 0.25
    steady_mm_s: float = 150.0
    landing_s: float = 0.06
    ruler: str = "none"

    def __post_init__(self) -> None:
        as_number(self.smoothing, "smoothing", 0.0, 1.0)
        as_number(self.mouse_smoothing, "smoothing of a mouse", 0.0, 1.0)
        if self.ruler not in RULERS:
            raise InputError(
                "ruler is {ruler!r}; expected {known}", ruler=self.ruler, known=" or ".join(RULERS)
            )
        as_number(self.longest_string_mm, "longest string (mm)", 0.0, 1000.0)
        as_number(self.trail, "trail", 0.01, 1.0)
        as_number(self.steady_mm_s, "steady speed (mm/s)", 1.0, 1e5)
        as_number(self.landing_s, "landing (s)", 0.0, 1.0)
        if self.pressure_by not in ("keys", "speed"):
            raise InputError(
                "pressure_by is {pressure_by!r}; expected 'keys' or 'speed'",
                pressure_by=self.pressure_by,
            )


@dataclass
class _StrokeState:
    """State between events."""

    time_ns: int
    target: AnyArray  # where the pointer is, on the surface
    goal: AnyArray  # whither that leads the brush: by a ruler, elsewhere
    point: AnyArray  # where the brush is
    normal: AnyArray
    tip: AnyArray  # where the tuft's tip trails
    ray: tuple[AnyArray, AnyArray] | None = None  # by which the pointer met the surface
    began_ns: int | None = None
    beside: bool = False
    speed: float = 0.0
    sent_ns: int = 0
    began_at: AnyArray | None = None  # where the stroke begins, on the surface
    across: AnyArray | None = None  # unit, of the plane that a ruler keeps it in
    has_pressure: bool = True  # of the device that paints


@dataclass(frozen=True, eq=False)
class _Stand:
    """Pose of the brush at one instant, but for the direction in which its tip trails."""

    time_ns: int
    target: AnyArray  # where the pointer is
    point: AnyArray  # where the brush is
    normal: AnyArray
    lean: AnyArray  # unit, up the handle
    rest: AnyArray  # whither a tip points that nothing drags
    twist: float | None  # rad
    pressure: float
    buttons: int
    bend: AnyArray | None = None  # unit, in which the tip shall point


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
        self._state: _StrokeState | None = None
        self._waiting: list[_Stand] = []  # of a stroke that does not yet say whither it goes
        self._last: _Stand | None = None

    @property
    def _now(self) -> _StrokeState:
        assert self._state is not None, "the pointer has been over the object"
        return self._state

    @property
    def _latest(self) -> _Stand:
        assert self._last is not None, "a stroke goes on"
        return self._last

    def hover(self, event: PointerInput, brush: BrushSpec) -> DeviceSample | None:
        """Hold the brush above the surface; None where the pointer is beside the object."""
        stand = self._follow(event, self._meet(event), brush, pulled=False)
        return None if stand is None else self._sample(stand, brush, lifted=True)

    def begin(self, event: PointerInput, brush: BrushSpec) -> list[DeviceSample] | None:
        """Put the brush down; None where the pointer is beside the object.

        Samples may only come with later events, when it is known whither the stroke goes.
        """
        stand = self._follow(event, self._meet(event), brush, pulled=False)
        if stand is None:
            return None
        state = self._now
        state.began_ns = event.time_ns
        state.beside, state.speed, state.sent_ns = False, 0.0, event.time_ns
        state.began_at, state.across = stand.point, None
        state.has_pressure = event.pressure is not None
        pressure = self._pressure(event)
        self._waiting = [replace(stand, time_ns=stand.time_ns - _STEP_NS)]
        if pressure > 0.0:  # it was pressed when it was first heard of
            self._waiting.append(replace(stand, pressure=pressure))
        return self._land_if_sure(brush)

    def move(self, event: PointerInput, brush: BrushSpec) -> list[DeviceSample]:
        """Follow the pointer; no samples where it is beside the object or time stood still.

        Where it comes back from beside the object, or from one part of it to another that lies
        behind, the brush is lifted and put down again.
        """
        state = self._state
        if state is None or state.began_ns is None or event.time_ns <= state.sent_ns:
            return []
        meeting = self._meet(event)
        if meeting is None:
            state.beside = True
        elif state.beside or self._is_apart(meeting[0], event):
            lifted = self.end(self._now.sent_ns, brush)
            landed = max(event.time_ns, lifted[-1].time_ns + 2 * _STEP_NS)
            return lifted + (self.begin(replace(event, time_ns=landed), brush) or [])
        before = state.sent_ns
        stand = self._follow(event, meeting, brush, pulled=True, pressed=True)
        if stand is None:
            return []
        state.sent_ns = event.time_ns
        samples = []
        for between in self._stands_over_fold(stand, event, brush, before):
            samples += self._put_down(between, brush)
        return samples + self._put_down(stand, brush)

    def end(
        self, time_ns: int, brush: BrushSpec, event: PointerInput | None = None
    ) -> list[DeviceSample]:
        """Bring the brush to where the pointer is, and lift it.

        Parameters
        ----------
        time_ns : int
        brush : BrushSpec
        event : PointerInput, optional
            Of the pen that was lifted: on the way to its point the pressure falls to nothing.
        """
        state = self._state
        if state is None or state.began_ns is None:
            return []
        if event is not None and event.pressure is None and len(self._waiting) == 1:
            # a mouse that stands says nothing until its button is let go: a click is a dot, and
            # that of a tap on a touchpad, which takes no time, is no smaller
            state.sent_ns = max(event.time_ns, state.sent_ns + _STEP_NS)
            landed_ns = state.began_ns + round(1e9 * self.settings.landing_s)
            landed = replace(event, time_ns=max(event.time_ns, landed_ns))
            pressed = replace(
                self._waiting[0], time_ns=state.sent_ns, pressure=self._pressure(landed)
            )
            self._waiting.append(pressed)
        samples = self._land(brush) + self._glide(brush)
        state.began_ns = None
        meeting = None if event is None or state.beside else self._meet(event)
        lifted = replace(self._latest, time_ns=max(time_ns, state.sent_ns + _STEP_NS), pressure=0.0)
        if meeting is not None and self.settings.ruler != "none":
            meeting = self._follow_ruler(*meeting)
        if meeting is not None:
            far = length_of(meeting[0] - lifted.point) > _LIFTED_OVER * brush.length_mm
            if not far and event is not None and not self._is_apart(meeting[0], event):
                normal = self._normal_under(*meeting, brush)
                lifted = replace(lifted, point=meeting[0], normal=normal)
        return [*samples, self._sample(lifted, brush)]

    # -- steps ------------------------------------------------------------------------------

    def _is_apart(self, point: AnyArray, event: PointerInput) -> bool:
        """True if the path to a point leaves the surface, as from a rim to what is behind."""
        step = point - self._now.target
        distance = length_of(step)
        if distance < _LEAST_GAP_MM:
            return False
        between = self._now.target + np.outer(_FRACTIONS_BETWEEN, step)
        off = np.linalg.norm(self._surface.find(between).points - between, axis=1)
        return bool(off.max() > _MOST_OFF * distance) or self._crosses_edge(point, event)

    def _crosses_edge(self, point: AnyArray, event: PointerInput) -> bool:
        """Return whether an edge is seen between the last point and this: no ray meets the path.

        Of two rays the one in the middle halves the way between what they meet, or, where the
        surface is seen from the side, all but. Over an edge the greater part stays as it is.
        """
        rays = [self._now.ray, _ray_of(event)]
        if rays[0] is None or rays[1] is None:
            return False
        points = [self._now.target, point]
        gap = length_of(point - self._now.target)
        for _ in range(_HALVINGS):
            origin, direction = (0.5 * (a + b) for a, b in zip(*rays, strict=True))
            middle = origin, direction / length_of(direction)
            hit = self._surface.cast(middle[0][None], middle[1][None])
            if not hit.hit[0]:
                return True
            gaps = [length_of(hit.points[0] - end) for end in points]
            if max(gaps) < _LEAST_SHRINKING * gap:
                return False
            behind = int(gaps[0] >= gaps[1])
            rays[behind], points[behind] = middle, hit.points[0]
        return True

    def _stands_over_fold(
        self, stand: _Stand, event: PointerInput, brush: BrushSpec, before_ns: int
    ) -> list[_Stand]:
        """Stands between the last and this one, where the surface turns between them.

        Between two samples the handle turns evenly, but the surface at once: over a fold the brush
        would lie down on it for a moment, and its footprint be twice as long.
        """
        last = self._waiting[-1] if self._waiting else self._latest
        cosine = float(np.clip(last.normal @ stand.normal, -1.0, 1.0))
        n = min(math.ceil(math.acos(cosine) / _TURNS), (stand.time_ns - before_ns) // _STEP_NS)
        step = stand.point - last.point
        stands = []
        for k in range(1, n):
            fraction = k / n
            point, normal = self._on_surface(last.point + fraction * step)
            normal = self._normal_under(point, normal, brush)
            lean = _lean_of(normal, event.right, event.up, event.x_tilt, event.y_tilt)
            stands.append(
                replace(
                    stand,
                    time_ns=before_ns + round(fraction * (stand.time_ns - before_ns)),
                    target=last.target + fraction * (stand.target - last.target),
                    point=point,
                    normal=normal,
                    lean=lean,
                    rest=self._resting_direction(lean, normal, event),
                    pressure=last.pressure + fraction * (stand.pressure - last.pressure),
                )
            )
        return stands

    def _follow(
        self,
        event: PointerInput,
        meeting: tuple[AnyArray, AnyArray] | None,
        brush: BrushSpec,
        pulled: bool,
        pressed: bool = False,
    ) -> _Stand | None:
        """Take the point where the pointer meets the surface; None where it does not."""
        settings, state = self.settings, self._state
        seconds = 0.0 if state is None else (event.time_ns - state.time_ns) * 1e-9
        change = settings.newtons_per_s * max(0.0, seconds)
        change *= int(event.harder) - int(event.softer)
        change += settings.newtons_per_notch * event.wheel
        self.force = min(MAX_FORCE_N, max(0.0, self.force + change))
        if meeting is None:
            return None
        point, normal = meeting
        if state is None:
            tip = point + _any_tangent(normal, np.zeros(3))
            state = self._state = _StrokeState(event.time_ns, point, point, point, normal, tip)
        if seconds > 0.0:  # the speed is a mean over the last hundredths of a second
            speed = length_of(point - state.target) / seconds
            weight = 1.0 - math.exp(-seconds / _FILTER_S)
            state.speed += weight * (speed - state.speed)
        state.time_ns, state.target, state.ray = event.time_ns, point, _ray_of(event)
        if pulled and self.settings.ruler != "none":
            point, normal = self._follow_ruler(point, normal)
        state.goal = point
        steadiness = settings.smoothing
        if event.pressure is None:
            steadiness = max(steadiness, settings.mouse_smoothing)
        string = steadiness * settings.longest_string_mm if pulled else 0.0  # length, mm
        if string > 0.0:
            step = point - state.point
            distance = length_of(step)
            if distance <= string:
                point, normal = state.point, state.normal
            else:
                point, normal = self._on_surface(state.point + (1.0 - string / distance) * step)
        normal = self._normal_under(point, normal, brush)
        state.point, state.normal = point, normal
        lean = _lean_of(normal, event.right, event.up, event.x_tilt, event.y_tilt)
        return _Stand(
            event.time_ns,
            state.goal,
            point,
            normal,
            lean,
            self._resting_direction(lean, normal, event),
            None if event.rotation is None else math.radians(event.rotation),
            self._pressure(event) if pressed else 0.0,
            event.buttons,
            None
            if event.bend is None
            else _any_tangent(normal, as_array(event.bend, "bend", (3,))),
        )

    def _resting_direction(self, lean: AnyArray, normal: AnyArray, event: PointerInput) -> AnyArray:
        """Direction of a tip that nothing drags: away from the lean, else up left as seen."""
        aside = lean - (lean @ normal) * normal
        if length_of(aside) > _LEANS:
            return _any_tangent(normal, -aside)
        if event.right is None or event.up is None:
            return _any_tangent(normal, self._now.tip - self._now.point)
        return _any_tangent(normal, np.subtract(event.up, event.right))

    # -- coming down ------------------------------------------------------------------------

    def _put_down(self, stand: _Stand, brush: BrushSpec) -> list[DeviceSample]:
        """Samples of one stand more: now, or when the stroke's direction is known."""
        if not self._waiting:
            self._drag(stand, brush)
            return [self._sample(stand, brush)]
        self._waiting.append(stand)
        return self._land_if_sure(brush)

    def _land_if_sure(self, brush: BrushSpec) -> list[DeviceSample]:
        """Samples of all that waits, if it need not wait any longer."""
        first, last = self._waiting[0], self._waiting[-1]
        far = length_of(last.target - first.point) >= _SURE_DIRECTION * self._trail(brush)
        stands = last.time_ns - first.time_ns >= _STANDS_NS
        given = first.twist is not None or last.bend is not None
        return self._land(brush) if far or stands or given else []

    def _land(self, brush: BrushSpec) -> list[DeviceSample]:
        """Samples of all that waited; the tip trails behind the path, or points as it rests."""
        stands, self._waiting = self._waiting, []
        if not stands:
            return []
        first = stands[0]
        step = stands[-1].target - first.point
        moved = length_of(step) >= _LEAST_DIRECTION * self._trail(brush)
        back = _any_tangent(first.normal, -step) if moved else first.rest
        if stands[-1].bend is not None:
            back = _any_tangent(first.normal, stands[-1].bend)
        self._now.tip = first.point + self._trail(brush) * back
        self._last = first
        samples = []
        for stand in stands:
            self._drag(stand, brush)
            samples.append(self._sample(stand, brush))
        return samples

    def _drag(self, stand: _Stand, brush: BrushSpec) -> None:
        """Bring the brush to its point; its tip is dragged along the surface behind it.

        Over an edge the tip is turned with the surface: laid into the new plane instead, it would
        come to lie under the brush, and point along the edge.
        """
        state, last, trail = self._now, self._latest, self._trail(brush)
        back = _rotate_between(last.normal, stand.normal, state.tip - last.point)
        step = stand.point - last.point
        back = back - length_of(step) * _project_along(stand.normal, step)
        back = back - (back @ stand.normal) * stand.normal
        distance = length_of(back)
        if stand.bend is not None:
            back = stand.bend * trail
        elif distance < 1e-9:
            back = stand.rest * trail
        elif distance > trail:
            back *= trail / distance
        state.tip = stand.point + back
        self._last = stand

    def _meet(self, event: PointerInput) -> tuple[AnyArray, AnyArray] | None:
        """Point where the pointer's ray meets the surface, and the normal there."""
        if event.point is not None and event.normal is not None:
            normal = as_array(event.normal, "normal", (3,))
            return as_array(event.point, "point", (3,)), normal / length_of(normal)
        if event.origin is None or event.direction is None:
            return None
        origin = as_array(event.origin, "origin", (3,))
        hits = self._surface.cast(origin[None], as_array(event.direction, "direction", (3,))[None])
        return self._on_surface(hits.points[0]) if hits.hit[0] else None

    def _on_surface(self, point: AnyArray) -> tuple[AnyArray, AnyArray]:
        nearest = self._surface.find(point[None])
        return nearest.points[0], nearest.normals[0]

    def _normal_under(self, point: AnyArray, normal: AnyArray, brush: BrushSpec) -> AnyArray:
        """The mean normal under a footprint: over a crease the handle turns by and by.

        The points on its rim lie a little under the surface, so that those beyond an edge are
        nearest to the other face.
        """
        ahead = _any_tangent(normal, np.array([1.0, 0.0, 0.0]))
        rim = _RIM @ np.stack([ahead, cross(normal, ahead)]) - _SUNK * normal
        normals = self._surface.find(point + _UNDER * brush.length_mm * rim).normals
        mean = 2.0 * normal + normals[normals @ normal > _OTHER_SIDE].sum(axis=0)
        result: AnyArray = mean / length_of(mean)
        return result

    def _follow_ruler(self, point: AnyArray, normal: AnyArray) -> tuple[AnyArray, AnyArray]:
        """The point nearest to another where the ruler leads from the stroke's beginning.

        Rulers are planes that the surface is cut by: through the first way and the normal there,
        level, or through the object's axis.
        """
        state = self._now
        start = state.began_at
        if start is None:
            return point, normal
        if state.across is None:
            state.across = self._ruler_plane(start, point)
            if state.across is None:
                return self._on_surface(start)
        for _ in range(_RULED):
            off = float((point - start) @ state.across)
            point, normal = self._on_surface(point - off * state.across)
        return point, normal

    def _ruler_plane(self, start: AnyArray, point: AnyArray) -> AnyArray | None:
        """Normal of the ruler's plane; None while its direction is not known."""
        if self.settings.ruler == "ring":
            return np.array([0.0, 0.0, 1.0])
        if self.settings.ruler == "profile":
            corners = self._surface.mesh.vertices
            middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
            arm = start[:2] - middle[:2]
            if length_of(arm) < _LEAST_ARM_MM:  # on the axis every way is a profile
                arm = point[:2] - middle[:2]
            if length_of(arm) < _LEAST_ARM_MM:
                return None
            return np.array([-arm[1], arm[0], 0.0]) / length_of(arm)
        if length_of(point - start) < _LEAST_ARM_MM:
            return None
        across: AnyArray = cross(self._on_surface(start)[1], point - start)
        return across / max(length_of(across), 1e-12)

    def _glide(self, brush: BrushSpec) -> list[DeviceSample]:
        """Samples on the path to where the pointer was last."""
        state = self._now
        start, path = state.point, state.goal - state.point
        length = length_of(path)
        n = math.ceil(length / _GLIDE_STEP_MM)
        step_ns = round(length / max(n, 1) / _GLIDE_MM_S * 1e9)
        pressure, samples = self._latest.pressure, []
        for k in range(1, n + 1):
            state.point, normal = self._on_surface(start + (k / n) * path)
            state.normal = self._normal_under(state.point, normal, brush)
            state.sent_ns += max(step_ns, _STEP_NS)
            stand = replace(
                self._latest, time_ns=state.sent_ns, point=state.point, normal=state.normal,
                pressure=pressure if state.has_pressure else pressure * _ease(1.0 - k / n),
            )  # fmt: skip
            self._drag(stand, brush)
            samples.append(self._sample(stand, brush))
        return samples

    def _pressure(self, event: PointerInput) -> float:
        settings = self.settings
        if event.pressure is not None:
            pressure = settings.curve(as_number(event.pressure, "pressure", 0.0, 1.0))
        else:
            pressure = self.force / MAX_FORCE_N
            state = self._now
            if settings.pressure_by == "speed":
                pressure *= 1.0 / (1.0 + state.speed / settings.steady_mm_s)
            began_ns = event.time_ns if state.began_ns is None else state.began_ns
            since = (event.time_ns - began_ns) * 1e-9
            if since < settings.landing_s:
                pressure *= _ease(since / settings.landing_s)
        return pressure

    def _trail(self, brush: BrushSpec) -> float:
        return self.settings.trail * brush.length_mm

    def _sample(self, stand: _Stand, brush: BrushSpec, lifted: bool = False) -> DeviceSample:
        normal = stand.normal
        # gliding and lifted, the brush comes to points with another normal than the lean's
        z = _limit_lean(stand.lean, normal)
        if stand.twist is None:  # laid on the surface, the bend is along the trailing tip
            bend = _any_tangent(normal, self._now.tip - stand.point)
            x = bend - (bend @ z) / (normal @ z) * normal
            x /= length_of(x)
        else:
            vector = _any_tangent(z, np.array([1.0, 0.0, 0.0]))
            angle = -stand.twist
            x = math.cos(angle) * vector + math.sin(angle) * cross(z, vector)
            bend = _any_tangent(normal, x)
        orientation = quaternions_from_matrices(np.stack([x, cross(z, x), z], axis=-1)[None])[0]
        root = root_over(brush, stand.point, normal, bend, z, stand.pressure)
        if lifted:
            root = root + _HOVER * brush.length_mm * z
        return DeviceSample(
            stand.time_ns,
            root,
            orientation,
            stand.pressure,
            stand.buttons,
            np.zeros(3),
            _REST,
            stand.point,
        )


def _ease(fraction: float) -> float:
    """Fraction of its pressure that a mouse has while it comes down or goes up, 0 to 1.

    It changes fastest where the tuft is hardly down, and has no corner where it is: an end is round
    as a tuft's print, not cut to a point like a pencil.
    """
    return fraction * (2.0 - fraction)


def _ray_of(event: PointerInput) -> tuple[AnyArray, AnyArray] | None:
    if event.origin is None or event.direction is None:
        return None
    return np.asarray(event.origin, np.float64), np.asarray(event.direction, np.float64)


def _project_along(normal: AnyArray, vector: AnyArray) -> AnyArray:
    """The direction of a step along a surface; zero where it leads straight up or down."""
    across = vector - (vector @ normal) * normal
    length = length_of(across)
    return across / length if length > 1e-9 else np.zeros(3)
