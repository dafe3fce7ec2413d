"""What makes a force safe: limits in a fixed order, and no more energy out than came in."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.haptics.kernels.state import (
    CLAMPED,
    CONTACT_S,
    CREDIT,
    DEVICE_LIMIT,
    ENERGY,
    LAST_FORCE_X,
    MAX_POSE_AGE_S,
    MAX_SNAPSHOT_AGE_S,
    NOT_FINITE,
    RAMP_S,
    RISE_S,
    RISEN_S,
    SLEW,
    SLEWED,
    SLEWED_X,
    STALE_POSE,
    STALE_SNAPSHOT,
    START_FORCE,
    STARTED,
    STOPPING,
    STORED,
    TAMED,
    TOUCHING,
    USER_LIMIT,
    WAITING,
    WANTED,
)

__all__ = ["make_safe", "tame"]

_ABSURD = 1e18  # N2; NaN is not below it either
_FORESIGHT = 1.5  # the hand may speed up by so much until the next step
_SPARE = 0.02  # N mm that the energy tank may hold beyond what the springs store


@kernel(error_model="numpy")
def make_safe(settings, state, force, dt, pose_age, snapshot_age, stopping):
    """Make a wanted force (3,), object frame, one that may be sent; in this order.

    1. not finite: zero; 2. a contact fades in; 3. at most what the device and the user allow;
    4. changes no faster than the slew limit; 5. zero where the pose or the surface's snapshot is
    too old, or the servo stops; 6. at the start nothing until the brush is off the surface, then a
    slow rise.

    Returns the flags of what was done. `state` holds the last force and the times.
    """
    flags = 0
    squared = force[0] ** 2 + force[1] ** 2 + force[2] ** 2
    if not squared < _ABSURD:
        force[:] = 0.0
        state[TOUCHING] = 0.0
        squared = 0.0
        flags |= NOT_FINITE
    state[WANTED] = np.sqrt(squared)
    state[CONTACT_S] = state[CONTACT_S] + dt if state[TOUCHING] > 0.0 else 0.0
    if state[TOUCHING] > 0.0:
        force *= min(1.0, state[CONTACT_S] / settings[RAMP_S])
    flags |= _clamp(settings, force)
    flags |= _slew(settings, state, force, dt)
    if pose_age > settings[MAX_POSE_AGE_S]:
        flags |= STALE_POSE
    if snapshot_age > settings[MAX_SNAPSHOT_AGE_S]:
        flags |= STALE_SNAPSHOT
    if stopping:
        flags |= STOPPING
    if flags & (STALE_POSE | STALE_SNAPSHOT | STOPPING | NOT_FINITE):
        force[:] = 0.0
        state[CONTACT_S] = 0.0
        if flags & (STALE_SNAPSHOT | STOPPING):
            state[STARTED] = 0.0
    for axis in range(3):
        state[SLEWED_X + axis] = force[axis]
    return flags | _start(settings, state, force, dt)


@kernel(error_model="numpy")
def _start(settings, state, force, dt):
    """Nothing until the wanted force is small, then a rise from nothing to all of it."""
    if state[STARTED] == 0.0:
        if state[WANTED] >= settings[START_FORCE]:
            force[:] = 0.0
            return WAITING
        state[STARTED] = 1.0
        state[RISEN_S] = 0.0
    before = state[RISEN_S] / settings[RISE_S]
    state[RISEN_S] = min(settings[RISE_S], state[RISEN_S] + dt)
    rise = state[RISEN_S] / settings[RISE_S]
    force *= rise
    state[CREDIT] = rise * state[CREDIT] + (rise - before) * state[STORED]
    state[STORED] *= rise
    return 0


@kernel(error_model="numpy")
def _clamp(settings, force):
    limit = max(0.0, min(settings[DEVICE_LIMIT], settings[USER_LIMIT]))
    size = np.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if size <= limit:
        return 0
    force *= limit / size
    return CLAMPED


@kernel(error_model="numpy")
def _slew(settings, state, force, dt):
    change = 0.0
    for axis in range(3):
        change += (force[axis] - state[SLEWED_X + axis]) ** 2
    change = np.sqrt(change)
    most = settings[SLEW] * dt
    if change <= most:
        return 0
    for axis in range(3):
        before = state[SLEWED_X + axis]
        force[axis] = before + (force[axis] - before) * most / change
    return SLEWED


@kernel(error_model="numpy")
def tame(state, force, dx, dy, dz):
    """Let the device give back no more energy than the hand put in (Hannaford and Ryu 2002).

    The tank gains what the hand did against the last force, and what turning the pen put into the
    spring, for which no torque could be felt. It never holds more than the springs store: what
    friction used up, or a limit kept from the hand, cannot come back. While the hand moves with
    the force, the force is that of a spring which holds what is in the tank, and never so large
    as to empty it before the next step.

    (dx, dy, dz) is the root's way since the last step, object frame, mm.
    """
    given = 0.0
    ahead = 0.0
    size = 0.0
    for axis, d in ((0, dx), (1, dy), (2, dz)):
        given -= state[LAST_FORCE_X + axis] * d
        ahead += force[axis] * d
        size += force[axis] * force[axis]
    size = np.sqrt(size)
    stored = state[STORED]
    energy = min(state[ENERGY] + given + state[CREDIT], stored + _SPARE)
    state[ENERGY] = energy
    if ahead <= 0.0 or size <= 0.0:
        return 0
    most = size * max(0.0, energy) / (_FORESIGHT * ahead)
    if stored > 0.0 and energy < stored:
        most = min(most, state[WANTED] * np.sqrt(max(0.0, energy) / stored))
    if most >= size:
        return 0
    force *= most / size
    for axis in range(3):
        state[SLEWED_X + axis] *= most / size  # it comes back no faster than any force
    return TAMED
