"""What is felt besides the brush: the surface before it is touched, and a click at a dip.

Both are part of the wanted force, which is made safe afterwards like any other.
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["CLICK_S", "add_click", "nearing_force", "nearing_store", "stored_in_contact"]

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
