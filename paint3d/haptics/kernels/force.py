"""How the brush pushes back: a spring along the averaged normal, and friction against the slip."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.core.quaternion import turn
from paint3d.haptics.kernels.state import (
    CREDIT,
    DESCENT,
    DEVICE_LIMIT,
    FOOT_NORMAL_X,
    FOOT_X,
    FRICTION,
    LAST_X,
    LENGTH,
    LOWEST_SINE,
    NEAR,
    NORMAL_X,
    PATCH,
    PATCH_SAMPLES,
    PROXY_X,
    SOFTENING,
    SPRING,
    STICK,
    STIFFEST,
    STORED,
    TOUCHING,
    WARM,
)
from paint3d.mesh.kernels.bounded_bvh import find_foot_within, mean_normal

__all__ = ["push_back"]


@kernel(error_model="numpy")
def push_back(tree, settings, state, x, y, z, q, work, force):
    """The brush's force on the hand in the object's frame, N, before anything is made safe.

    F = lambda_c S D_s along the averaged normal (Guo 2017, Eq. 4), plus friction of at most mu F
    against the slip: a proxy point is held on the surface by a stiff spring and let go where that
    would pull harder. No torque: the tuft bends freely.

    Parameters
    ----------
    tree : ContactTree
    settings, state : arrays
        See `haptic_state`.
    x, y, z : float
        The root in the object's frame, mm.
    q : (4,) float64
        object_from_pen.
    work : (1,) int64
        See `bounded_contact.nearest_within`.
    force : (3,) float64
        Filled.

    Returns
    -------
    bool
        Whether the brush touches.
    """
    force[:] = 0.0
    ux, uy, uz = turn(q, 0.0, 0.0, 1.0)
    bx, by, bz = turn(q, 1.0, 0.0, 0.0)
    length = settings[LENGTH]
    foot = np.empty(6)
    foot[:3] = state[FOOT_X : FOOT_X + 3]
    foot[3:] = state[FOOT_NORMAL_X : FOOT_NORMAL_X + 3]
    warm = state[WARM : WARM + 5]
    triangle = find_foot_within(tree, x, y, z, ux, uy, uz, length, warm, work, foot)
    before, state[DESCENT], state[STORED], state[CREDIT] = state[DESCENT], 0.0, 0.0, 0.0
    if triangle < 0:
        return False
    normal = np.empty(3)
    near = state[NEAR : NEAR + PATCH_SAMPLES]
    mean_normal(tree, foot, ux, uy, uz, bx, by, bz, settings[PATCH], triangle, near, work, normal)
    sine = ux * normal[0] + uy * normal[1] + uz * normal[2]
    sine = min(1.0, max(settings[LOWEST_SINE], sine))
    height = 0.0
    along_way = 0.0  # of the root since the last step, along the mean of both normals
    for axis, place in ((0, x), (1, y), (2, z)):
        height += (place - foot[axis]) * normal[axis]
        way = place - state[LAST_X + axis]
        along_way += 0.5 * way * (normal[axis] + state[NORMAL_X + axis])
        state[FOOT_X + axis] = foot[axis]
        state[FOOT_NORMAL_X + axis] = foot[3 + axis]
        state[NORMAL_X + axis] = normal[axis]
    descent = length * sine - height
    if descent <= 0.0:
        return False
    state[DESCENT] = descent
    stiffness = min(settings[SPRING], settings[STIFFEST]) * state[SOFTENING]
    pressing = stiffness * descent
    if state[TOUCHING] == 0.0:
        state[PROXY_X : PROXY_X + 3] = foot[:3]
    elif before > 0.0:
        state[CREDIT] = 0.5 * stiffness * (descent + before) * (descent - before + along_way)
    for axis in range(3):
        force[axis] = pressing * normal[axis]
    held = _hold_proxy(settings, state, foot, normal, pressing, force)
    state[STORED] = 0.5 * stiffness * descent * descent + held
    return True


@kernel(error_model="numpy")
def _hold_proxy(settings, state, foot, normal, pressing, force):
    """Add the friction of a proxy that slips where it is pulled by more than mu F.

    Returns the energy that its spring stores, N mm.
    """
    stick = max(min(settings[STICK], settings[STIFFEST]) * state[SOFTENING], 1e-9)
    along = 0.0
    for axis in range(3):
        along += (foot[axis] - state[PROXY_X + axis]) * normal[axis]
    pull = np.empty(3)
    slip2 = 0.0
    for axis in range(3):
        pull[axis] = foot[axis] - state[PROXY_X + axis] - along * normal[axis]
        slip2 += pull[axis] * pull[axis]
    slip = np.sqrt(slip2)
    most = settings[FRICTION] * min(pressing, settings[DEVICE_LIMIT]) / stick
    share = most / slip if slip > most else 1.0
    for axis in range(3):
        state[PROXY_X + axis] = foot[axis] - share * pull[axis]
        force[axis] -= stick * share * pull[axis]
    return 0.5 * stick * (share * slip) ** 2
