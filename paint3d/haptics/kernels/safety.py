"""What makes a force safe: limits in a fixed order, and no more energy out than came in."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.haptics.kernels.state import (
    CLAMPED,
    NOT_FINITE,
    SLEWED,
    STALE_POSE,
    STALE_SNAPSHOT,
    STOPPING,
    TAMED,
    WAITING,
)

__all__ = ["limit_power", "make_safe"]

_ABSURD = 1e18  # N2; NaN is not below it either
_FORESIGHT = 1.5  # the hand may speed up by so much until the next step
_SPARE = 0.02  # N mm that the energy tank may hold beyond what the springs store


@kernel(error_model="numpy")
def make_safe(settings, state, force, moment):
    """Make a wanted force (3,), object frame, one that may be sent; in this order.

    1. not finite: zero; 2. a contact fades in; 3. at most what the device and the user allow;
    4. changes no faster than the slew limit; 5. zero where the pose or the surface's snapshot is
    too old, or the servo stops; 6. at the start nothing until the brush is off the surface, then a
    slow rise.

    Returns the flags of what was done. `state` holds the last force and the times; it and the
    settings are records, `moment` a `Moment`.
    """
    dt = moment.dt
    flags = 0
    squared = force[0] ** 2 + force[1] ** 2 + force[2] ** 2
    if not squared < _ABSURD:
        force[:] = 0.0
        state.touching = 0.0
        squared = 0.0
        flags |= NOT_FINITE
    state.wanted = np.sqrt(squared)
    state.contact_s = state.contact_s + dt if state.touching > 0.0 else 0.0
    if state.touching > 0.0:
        force *= min(1.0, state.contact_s / settings.ramp_s)
    flags |= _clamp(settings, force)
    flags |= _slew(settings, state, force, dt)
    if moment.pose_age > settings.max_pose_age_s:
        flags |= STALE_POSE
    if moment.snapshot_age > settings.max_snapshot_age_s:
        flags |= STALE_SNAPSHOT
    if moment.stopping:
        flags |= STOPPING
    if flags & (STALE_POSE | STALE_SNAPSHOT | STOPPING | NOT_FINITE):
        force[:] = 0.0
        state.contact_s = 0.0
        if flags & (STALE_SNAPSHOT | STOPPING):
            state.started = 0.0
    for axis in range(3):
        state.slewed[axis] = force[axis]
    return flags | _start(settings, state, force, dt)


@kernel(error_model="numpy")
def _start(settings, state, force, dt):
    """Nothing until the wanted force is small, then a rise from nothing to all of it."""
    if state.started == 0.0:
        if state.wanted >= settings.start_force:
            force[:] = 0.0
            return WAITING
        state.started = 1.0
        state.risen_s = 0.0
    before = state.risen_s / settings.rise_s
    state.risen_s = min(settings.rise_s, state.risen_s + dt)
    rise = state.risen_s / settings.rise_s
    force *= rise
    state.credit = rise * state.credit + (rise - before) * state.stored
    state.stored *= rise
    return 0


@kernel(error_model="numpy")
def _clamp(settings, force):
    limit = max(0.0, min(settings.device_limit, settings.user_limit))
    size = np.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if size <= limit:
        return 0
    force *= limit / size
    return CLAMPED


@kernel(error_model="numpy")
def _slew(settings, state, force, dt):
    change = 0.0
    for axis in range(3):
        change += (force[axis] - state.slewed[axis]) ** 2
    change = np.sqrt(change)
    most = settings.slew * dt
    if change <= most:
        return 0
    for axis in range(3):
        before = state.slewed[axis]
        force[axis] = before + (force[axis] - before) * most / change
    return SLEWED


@kernel(error_model="numpy")
def limit_power(state, force, way):
    """Let the device give back no more energy than the hand put in (Hannaford and Ryu 2002).

    The tank gains what the hand did against the last force, and what turning the pen put into the
    spring, for which no torque could be felt. It never holds more than the springs store: what
    friction used up, or a limit kept from the hand, cannot come back. While the hand moves with
    the force, the force is that of a spring which holds what is in the tank, and never so large
    as to empty it before the next step.

    `way` (3,) is the root's since the last step, object frame, mm.
    """
    given = 0.0
    ahead = 0.0
    size = 0.0
    for axis in range(3):
        d = way[axis]
        given -= state.last_force[axis] * d
        ahead += force[axis] * d
        size += force[axis] * force[axis]
    size = np.sqrt(size)
    stored = state.stored
    energy = min(state.energy + given + state.credit, stored + _SPARE)
    state.energy = energy
    if ahead <= 0.0 or size <= 0.0:
        return 0
    most = size * max(0.0, energy) / (_FORESIGHT * ahead)
    if stored > 0.0 and energy < stored:
        most = min(most, state.wanted * np.sqrt(max(0.0, energy) / stored))
    if most >= size:
        return 0
    force *= most / size
    for axis in range(3):
        state.slewed[axis] *= most / size  # it comes back no faster than any force
    return TAMED
