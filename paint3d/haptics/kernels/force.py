"""How the brush pushes back: a spring along the averaged normal, and friction against the slip."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.core.quaternion import compiled_turn
from paint3d.haptics.kernels.cues import nearing_force, nearing_store, stored_in_contact
from paint3d.mesh.kernels.bounded_bvh import find_foot_within, mean_normal

__all__ = ["contact_force"]


@kernel(error_model="numpy")
def contact_force(tree, settings, state, root, q, work, force):
    """The brush's force on the hand in the object's frame, N, before anything is made safe.

    F = lambda_c S D_s along the averaged normal (Guo 2017, Eq. 4), plus friction of at most mu F
    against the slip: a proxy point is held on the surface by a stiff spring and let go where that
    would pull harder. No torque: the tuft bends freely. Where it is asked for, a gentle force
    grows before the surface is touched.

    Parameters
    ----------
    tree : ContactTree
    settings, state : records
        See `haptics.kernels.state`.
    root : (3,) float64
        The tuft's, in the object's frame, mm.
    q : (4,) float64
        object_from_pen.
    work : (1,) int64
        See `bounded_bvh.nearest_within`.
    force : (3,) float64
        Filled.

    Returns
    -------
    bool
        Whether the brush touches.
    """
    force[:] = 0.0
    up, ahead = compiled_turn(q, 0.0, 0.0, 1.0), compiled_turn(q, 1.0, 0.0, 0.0)
    place = (root[0], root[1], root[2])
    length = settings.length
    foot = np.empty(6)
    foot[:3] = state.foot
    foot[3:] = state.foot_normal
    triangle = find_foot_within(tree, place, up, length + settings.ahead, state.warm, work, foot)
    before, state.descent, state.stored, state.credit = state.descent, 0.0, 0.0, 0.0
    if triangle < 0:
        return False
    normal = mean_normal(tree, foot, up, ahead, settings.patch, triangle, state.near, work)
    sine = up[0] * normal[0] + up[1] * normal[1] + up[2] * normal[2]
    sine = min(1.0, max(settings.lowest_sine, sine))
    height, along_way = _keep_foot(state, root, foot, normal)
    descent = length * sine - height
    if descent <= 0.0:
        return _near(settings, state, foot, normal, -descent, force)
    state.descent = descent
    stiffness = min(settings.spring, settings.stiffest) * state.softening
    pressing = stiffness * descent
    if state.touching == 0.0:
        state.proxy[:] = foot[:3]
    elif before > 0.0:
        state.credit = 0.5 * stiffness * (descent + before) * (descent - before + along_way)
    felt = max(pressing, nearing_force(settings, state, 0.0))
    for axis in range(3):
        force[axis] = felt * normal[axis]
    held = _hold_proxy(settings, state, foot, normal, pressing, force)
    state.stored = stored_in_contact(settings, state, stiffness, descent) + held
    return True


@kernel(error_model="numpy")
def _near(settings, state, foot, normal, gap, force):
    """Fill in the force (3,), N, at a gap (mm) before the surface; whether there is any."""
    nearing = nearing_force(settings, state, gap)
    state.stored = nearing_store(settings, state, gap)
    for axis in range(3):
        force[axis] = nearing * normal[axis]
        state.proxy[axis] = foot[axis]
    return nearing > 0.0


@kernel(error_model="numpy")
def _keep_foot(state, root, foot, normal):
    """Remember a foot and the mean normal there.

    Returns how high the root stands over it, and its way since the last step, along the mean of
    both normals; mm.
    """
    height = 0.0
    along_way = 0.0
    for axis in range(3):
        place = root[axis]
        height += (place - foot[axis]) * normal[axis]
        way = place - state.last[axis]
        along_way += 0.5 * way * (normal[axis] + state.normal[axis])
        state.foot[axis] = foot[axis]
        state.foot_normal[axis] = foot[3 + axis]
        state.normal[axis] = normal[axis]
    return height, along_way


@kernel(error_model="numpy")
def _hold_proxy(settings, state, foot, normal, pressing, force):
    """Add the friction of a proxy that slips where it is pulled by more than mu F.

    Returns the energy that its spring stores, N mm.
    """
    stick = max(min(settings.stick, settings.stiffest) * state.softening, 1e-9)
    along = 0.0
    for axis in range(3):
        along += (foot[axis] - state.proxy[axis]) * normal[axis]
    pull = np.empty(3)
    slip2 = 0.0
    for axis in range(3):
        pull[axis] = foot[axis] - state.proxy[axis] - along * normal[axis]
        slip2 += pull[axis] * pull[axis]
    slip = np.sqrt(slip2)
    most = settings.friction * min(pressing, settings.device_limit) / stick
    share = most / slip if slip > most else 1.0
    for axis in range(3):
        state.proxy[axis] = foot[axis] - share * pull[axis]
        force[axis] -= stick * share * pull[axis]
    return 0.5 * stick * (share * slip) ** 2
