"""How the brush pushes back: a spring along the averaged normal, and friction against the slip."""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.core.quaternion import compiled_turn
from paint3d.mesh.kernels.bvh import find_foot_within, mean_normal

__all__ = [
    "CLICK_S",
    "add_click",
    "contact_force",
    "nearing_force",
    "nearing_store",
    "stored_in_contact",
]

# ---- Cues ----------------------------------------------------------------------------------------
# What is felt besides the brush: the surface before it is touched, and a click at a dip.
#
# Both are part of the wanted force, which is made safe afterwards like any other.


CLICK_S = 0.02
"""A click is one wave of this length, s: it pushes and pulls alike."""


@kernel(error_model="numpy")
def nearing_force(settings, state, gap):
    """The force (N) at a gap (mm) before the surface: grows by its square to `ahead_n` at contact.

    Anticipation of a collision, which Guo 2017 (section 6) leaves to the future. It is never
    stiffer than the device can hold.
    """
    if settings.ahead <= 0.0 or gap >= settings.ahead:
        return 0.0
    most = min(settings.ahead_n, 0.5 * settings.stiffest * state.softening * settings.ahead)
    share = 1.0 - max(0.0, gap) / settings.ahead
    return most * share * share


@kernel(error_model="numpy")
def nearing_store(settings, state, gap):
    """The energy (N mm) that the hand has put in up to a gap (mm): the integral of the force."""
    if settings.ahead <= 0.0 or gap >= settings.ahead:
        return 0.0
    share = 1.0 - max(0.0, gap) / settings.ahead
    return nearing_force(settings, state, gap) * share * settings.ahead / 3.0


@kernel(error_model="numpy")
def stored_in_contact(settings, state, stiffness, descent):
    """The energy (N mm) at a descent (mm), where the force is the greater of spring and nearing."""
    at_contact = nearing_force(settings, state, 0.0)
    before = nearing_store(settings, state, 0.0)
    if stiffness <= 0.0 or at_contact <= 0.0:
        return 0.5 * stiffness * descent * descent + before + at_contact * descent
    even = min(descent, at_contact / stiffness)
    return before + at_contact * even + 0.5 * stiffness * (descent * descent - even * even)


@kernel(error_model="numpy")
def add_click(settings, state, up, dt, force):
    """Add a click along the handle (3,) to a force (3,), N, where one was asked for."""
    if settings.clicks != state.clicks_heard:
        state.clicks_heard = settings.clicks
        state.click_s = CLICK_S
    if state.click_s <= 0.0:
        return
    push = settings.click_n * np.sin(2.0 * math.pi * (1.0 - state.click_s / CLICK_S))
    state.click_s -= dt
    for axis in range(3):
        force[axis] += push * up[axis]


# --------------------------------------------------------------------------------------------------


_FEWEST_STEPS = 4.0  # for one wave of the grain; what would have less is not felt
_PACE_SHARE = 0.2  # of a new step's way in the smoothed one
_RISE = 0.5 * math.sqrt(5.0)
_NORM = 1.0 / math.hypot(1.0, 0.5 + _RISE)
_SHORT, _LONG = _NORM, _NORM * (0.5 + _RISE)
# Six directions, evenly spread (through the corners of an icosahedron), how long waves are along
# each, of the grain's length, and where they begin: no two are alike, so nothing repeats soon.
_WAVES = (
    (0.0, _SHORT, _LONG, 1.0, 0.4),
    (0.0, -_SHORT, _LONG, 1.17, 2.9),
    (_SHORT, _LONG, 0.0, 1.06, 5.1),
    (-_SHORT, _LONG, 0.0, 1.23, 1.3),
    (_LONG, 0.0, _SHORT, 1.11, 3.6),
    (_LONG, 0.0, -_SHORT, 1.03, 4.4),
)
_EVEN = 1.0 / math.sqrt(1.2)  # so that it varies as much as one sine along any way


@kernel(error_model="numpy")
def contact_force(tree, settings, state, root, q, work, force):
    """The brush's force on the hand in the object's frame, N, before anything is made safe.

    F = lambda_c S D_s along the averaged normal (Guo 2017, Eq. 4), plus friction of at most mu F
    against the slip: a proxy point is held on the surface by a stiff spring and let go where that
    would pull harder. The grain of the surface makes the friction vary from place to place. No
    torque: the tuft bends freely. Where it is asked for, a gentle force grows before the surface is
    touched.

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
    _keep_pace(state, foot)
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
def _keep_pace(state, foot):
    """Note how far the foot went since the last step, smoothed; nothing at the first touch."""
    if state.touching == 0.0:
        state.pace = 0.0
        return
    square = 0.0
    for axis in range(3):
        square += (foot[axis] - state.foot[axis]) ** 2
    state.pace += _PACE_SHARE * (np.sqrt(square) - state.pace)


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
    rubbing = stick * share
    if slip > 0.0 and settings.texture > 0.0:
        rubbing *= 1.0 + _roughness(settings, state, foot, pull, slip, rubbing * slip)
    for axis in range(3):
        state.proxy[axis] = foot[axis] - share * pull[axis]
        force[axis] -= rubbing * pull[axis]
    return 0.5 * stick * (share * slip) ** 2


@kernel(error_model="numpy")
def _roughness(settings, state, foot, pull, slip, friction):
    """By what share the grain makes the friction (N) greater or less at this place.

    Waves that stand in the object, of the grain's length and somewhat longer ones. Along the slip
    they have no mean: those that lie across it do not count. The share falls to nothing where the
    hand goes so fast that a wave would have less than four steps, and is so small that the force
    changes along the way no faster than the stiffness that the device can hold.
    """
    fade = 1.0 - (_FEWEST_STEPS * state.pace / settings.wave) ** 2
    if fade <= 0.0 or friction <= 0.0:
        return 0.0
    height = 0.0
    turns = 2.0 * math.pi / settings.wave
    for k in range(6):
        x, y, z, longer, start = _WAVES[k]
        along = (x * pull[0] + y * pull[1] + z * pull[2]) / slip
        place = x * foot[0] + y * foot[1] + z * foot[2]
        height += along * along * math.sin(turns / longer * place + start)
    most = settings.stiffest * state.softening / (turns * friction)
    return min(settings.texture, most) * fade * fade * _EVEN * height
