"""One step of the force servo: follow the object, find the contact, make the force safe."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.core.quaternion import relative, turn, turn_back
from paint3d.haptics.kernels.force import push_back
from paint3d.haptics.kernels.safety import make_safe, tame
from paint3d.haptics.kernels.state import (
    BUDGET_SPENT,
    FOLLOW_S,
    FORCE_X,
    HAS_LAST,
    HAS_OBJECT,
    LAST_FORCE_X,
    LAST_X,
    OBJECT_W,
    OBJECT_X,
    SPENT,
    TOUCHING,
)

__all__ = ["NODE_BUDGET", "servo_step"]

NODE_BUDGET = 1500
"""Tree nodes that one step may look at."""


@kernel(error_model="numpy")
def servo_step(tree, settings, state, target, pose, dt, pose_age, snapshot_age, stopping, out):
    """One step: follow the object, find the contact, make the force safe.

    Parameters
    ----------
    tree : ContactTree
    settings : (N_SETTINGS,) float64
    state : (N_STATE,) float64
        Kept from step to step; zeros (softening 1) at the start.
    target : (7,) float64
        world_from_object of the last snapshot: position mm, quaternion.
    pose : (7,) float64
        world_from_pen: the root, mm, and quaternion.
    dt, pose_age, snapshot_age : float
        s.
    stopping : bool
    out : (3,) float64
        Gets the force on the hand, world, N.

    Returns
    -------
    int
        Flags of what was done to it.
    """
    _follow(settings, state, target, dt)
    q = state[OBJECT_W : OBJECT_W + 4]
    x, y, z = turn_back(
        q,
        pose[0] - state[OBJECT_X],
        pose[1] - state[OBJECT_X + 1],
        pose[2] - state[OBJECT_X + 2],
    )
    held = np.empty(4)
    relative(q, pose[3:7], held)
    work = np.empty(1, np.int64)
    work[0] = NODE_BUDGET
    force = np.empty(3)
    dx, dy, dz = 0.0, 0.0, 0.0
    finite = x * x + y * y + z * z < 1e12 and held[0] * held[0] <= 2.0
    if not finite:
        force[:] = np.nan
        state[HAS_LAST] = 0.0
    else:
        if state[HAS_LAST] > 0.0:
            dx = x - state[LAST_X]
            dy = y - state[LAST_X + 1]
            dz = z - state[LAST_X + 2]
        touching = push_back(tree, settings, state, x, y, z, held, work, force)
        state[TOUCHING] = 1.0 if touching else 0.0
        state[LAST_X] = x
        state[LAST_X + 1] = y
        state[LAST_X + 2] = z
        state[HAS_LAST] = 1.0
    state[SPENT] = NODE_BUDGET - work[0]
    flags = make_safe(settings, state, force, dt, pose_age, snapshot_age, stopping)
    flags |= tame(state, force, dx, dy, dz)
    if work[0] <= 0:
        flags |= BUDGET_SPENT
    for axis in range(3):
        state[LAST_FORCE_X + axis] = force[axis]
    wx, wy, wz = turn(q, force[0], force[1], force[2])
    out[0] = wx
    out[1] = wy
    out[2] = wz
    state[FORCE_X] = wx
    state[FORCE_X + 1] = wy
    state[FORCE_X + 2] = wz
    return flags


@kernel(error_model="numpy")
def _follow(settings, state, target, dt):
    """Move the object smoothly after the snapshots, which come only 30 to 60 times a second."""
    share = 1.0
    if state[HAS_OBJECT] > 0.0:
        share = 1.0 - np.exp(-dt / settings[FOLLOW_S])
    state[HAS_OBJECT] = 1.0
    dot = 0.0
    for k in range(4):
        dot += state[OBJECT_W + k] * target[3 + k]
    sign = -1.0 if dot < 0.0 else 1.0
    norm = 0.0
    for k in range(4):
        state[OBJECT_W + k] += share * (sign * target[3 + k] - state[OBJECT_W + k])
        norm += state[OBJECT_W + k] ** 2
    norm = np.sqrt(norm)
    for k in range(4):
        state[OBJECT_W + k] /= norm if norm > 0.0 else 1.0
    for k in range(3):
        state[OBJECT_X + k] += share * (target[k] - state[OBJECT_X + k])
