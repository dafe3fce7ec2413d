"""Mouse and keyboard as a brush: two degrees of freedom, force by key or wheel.

The papers' device I (Guo 2015, section 4): the magnitude of the force comes from the keyboard, the
bending and painting directions from the mouse. Here the tuft is dragged behind the pointer (a
tractrix, as on paper), or, while a modifier is held, the brush stays and the pointer shows where
it bends.

Pure steps from events to readings; a window turns its own events into `PointerEvent`.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from paint3d.arrays import as_number
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.stylus_reading import DIP, StylusReading
from paint3d.errors import DeviceError

__all__ = ["PointerEvent", "PointerSettings", "PointerState", "point"]


@dataclass(frozen=True, slots=True)
class PointerEvent:
    """What mouse and keyboard said at one instant.

    Attributes
    ----------
    time_ns : int
    x, y : float
        The pointer on the pad, mm, y away from the user.
    down : bool
        Whether the painting button is held.
    harder, softer : bool
        Whether these keys are held: the force changes with the time they are, not with key
        repeats.
    wheel : float
        Notches turned since the last event, away from the user counting up.
    bending : bool
        Whether the modifier is held.
    dip : bool
        Whether the key that dips the brush is held.
    """

    time_ns: int
    x: float
    y: float
    down: bool = False
    harder: bool = False
    softer: bool = False
    wheel: float = 0.0
    bending: bool = False
    dip: bool = False


@dataclass(frozen=True, slots=True)
class PointerSettings:
    """How the force moves: N/s while a key is held, N a notch; and how long the tuft trails, mm."""

    newtons_per_s: float = 3.0
    newtons_per_notch: float = 0.25
    trail_mm: float = 4.0

    def __post_init__(self) -> None:
        as_number(self.newtons_per_s, "newtons_per_s", 0.0, 100.0, DeviceError)
        as_number(self.newtons_per_notch, "newtons_per_notch", 0.0, 10.0, DeviceError)
        as_number(self.trail_mm, "trail_mm", 0.01, 100.0, DeviceError)


@dataclass(frozen=True, slots=True)
class PointerState:
    """What is remembered between events: force N, brush and dragged tip on the pad, mm."""

    time_ns: int = 0
    force: float = 1.5
    x: float = 0.0
    y: float = 0.0
    tip_x: float = -1.0
    tip_y: float = 0.0
    started: bool = False


def point(
    settings: PointerSettings, state: PointerState, event: PointerEvent
) -> tuple[PointerState, StylusReading]:
    """The state after an event, and the reading of the brush: upright, pressed while `down`.

    Raises
    ------
    DeviceError
        If the event's place or wheel is not finite.
    """
    if not all(map(math.isfinite, (event.x, event.y, event.wheel))):
        raise DeviceError(f"a pointer event at ({event.x}, {event.y}), wheel {event.wheel}")
    force = _force(settings, state, event)
    if not state.started:
        state = dataclasses.replace(state, x=event.x, y=event.y, tip_x=event.x - 1.0, tip_y=event.y)
    if event.bending:
        x, y, tip_x, tip_y = state.x, state.y, event.x, event.y
        if math.hypot(tip_x - x, tip_y - y) < 1e-6:
            tip_x, tip_y = state.tip_x, state.tip_y
    else:
        x, y = event.x, event.y
        tip_x, tip_y = _drag(settings, state, x, y)
    after = PointerState(event.time_ns, force, x, y, tip_x, tip_y, True)
    heading = 0.5 * math.atan2(tip_y - y, tip_x - x)
    reading = StylusReading(
        event.time_ns,
        np.array([x, y, 0.0]),
        np.array([math.cos(heading), 0.0, 0.0, math.sin(heading)]),
        force / MAX_FORCE_N if event.down else 0.0,
        DIP if event.dip else 0,
    )
    return after, reading


def _force(settings: PointerSettings, state: PointerState, event: PointerEvent) -> float:
    seconds = (event.time_ns - state.time_ns) * 1e-9 if state.started else 0.0
    change = settings.newtons_per_s * max(0.0, seconds) * (int(event.harder) - int(event.softer))
    change += settings.newtons_per_notch * event.wheel
    return min(MAX_FORCE_N, max(0.0, state.force + change))


def _drag(
    settings: PointerSettings, state: PointerState, x: float, y: float
) -> tuple[float, float]:
    """The tip after the brush moved: it stays within the trail's length, and else is pulled."""
    dx, dy = state.tip_x - x, state.tip_y - y
    distance = math.hypot(dx, dy)
    if distance <= settings.trail_mm or distance == 0.0:
        return state.tip_x, state.tip_y
    share = settings.trail_mm / distance
    return x + share * dx, y + share * dy
