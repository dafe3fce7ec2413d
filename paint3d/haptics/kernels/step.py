"""One step of the force servo: follow the object, find the contact, make the force safe."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.core.quaternion import compiled_relative, compiled_turn, compiled_turn_back
from paint3d.haptics.kernels.force import add_click, contact_force
from paint3d.haptics.kernels.safety import limit_power, make_safe
from paint3d.haptics.kernels.state import BUDGET_SPENT

__all__ = ["NODE_BUDGET", "servo_step"]

NODE_BUDGET = 1500
"""Tree nodes that one step may look at."""


@kernel(error_model="numpy")
def servo_step(tree, the_settings, the_state, target, pose, moment, out):
    """One step: follow the object, find the contact, make the force safe.

    Parameters
    ----------
    tree : ContactTree
    the_settings : (1,) SETTINGS
    the_state : (1,) STATE
        Kept from step to step; zeros (softening 1) at the start.
    target : (7,) float64
        world_from_object of the last snapshot: position mm, quaternion.
    pose : (7,) float64
        world_from_pen: the root, mm, and quaternion.
    moment : Moment
    out : (3,) float64
        Gets the force on the hand, world, N.

    Returns
    -------
    int
        Flags of what was done to it.
    """
    settings, state = the_settings[0], the_state[0]
    _follow(settings, state, target, moment.dt)
    work = np.empty(1, np.int64)
    work[0] = NODE_BUDGET
    force, way = np.empty(3), np.zeros(3)
    _feel(tree, settings, state, pose, work, force, way, moment.dt)
    state.spent = NODE_BUDGET - work[0]
    flags = make_safe(settings, state, force, moment)
    flags |= limit_power(state, force, way)
    if work[0] <= 0:
        flags |= BUDGET_SPENT
    state.last_force[:] = force
    out[0], out[1], out[2] = compiled_turn(state.object_turn, force[0], force[1], force[2])
    state.force[:] = out
    return flags


@kernel(error_model="numpy")
def _feel(tree, settings, state, pose, work, force, way, dt):
    """Find the force (3,) that is wanted at a pose, and the root's way (3,); object's frame."""
    q, place = state.object_turn, state.object_place
    x, y, z = compiled_turn_back(q, pose[0] - place[0], pose[1] - place[1], pose[2] - place[2])
    held = np.empty(4)
    compiled_relative(q, pose[3:7], held)
    finite = x * x + y * y + z * z < 1e12 and held[0] * held[0] <= 2.0
    if not finite:
        force[:] = np.nan
        state.has_last = 0.0
        return
    root = np.array([x, y, z])
    if state.has_last > 0.0:
        for axis in range(3):
            way[axis] = root[axis] - state.last[axis]
    touching = contact_force(tree, settings, state, root, held, work, force)
    state.touching = 1.0 if touching else 0.0
    add_click(settings, state, compiled_turn(held, 0.0, 0.0, 1.0), dt, force)
    state.last[:] = root
    state.has_last = 1.0


@kernel(error_model="numpy")
def _follow(settings, state, target, dt):
    """Move the object smoothly after the snapshots, which come only 30 to 60 times a second."""
    share = 1.0
    if state.has_object > 0.0:
        share = 1.0 - np.exp(-dt / settings.follow_s)
    state.has_object = 1.0
    dot = 0.0
    for k in range(4):
        dot += state.object_turn[k] * target[3 + k]
    sign = -1.0 if dot < 0.0 else 1.0
    norm = 0.0
    for k in range(4):
        state.object_turn[k] += share * (sign * target[3 + k] - state.object_turn[k])
        norm += state.object_turn[k] ** 2
    norm = np.sqrt(norm)
    for k in range(4):
        state.object_turn[k] /= norm if norm > 0.0 else 1.0
    for k in range(3):
        state.object_place[k] += share * (target[k] - state.object_place[k])
