"""Ink in single hairs: what they give, what they share with their neighbours, what they take up.

Guo 2017, Eqs. 12, 13 in their continuous form hold for the tuft: of the ink R in it, the way ds at
the pressure pe takes R (1 - exp(-eta' pe ds)). Here each hair gives by that law, those that lie on
the surface for all, some more readily than others; neighbours that are wet level out. A tuft that
is equally wet everywhere thus gives what a solid one gives, and one that runs dry does so hair by
hair.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels.bristle_tuft import BLOCK

__all__ = ["LEVEL_BINS", "ask_hairs", "give_to_hairs", "level_hairs", "settle_gifts", "sum_hairs",
           "take_from_hairs"]  # fmt: skip

LEVEL_BINS = 64  # across the tuft, within which hairs share
_MOST_PER_HAIR = 4.0  # times its own share that a hair gives for those that do not touch
_THIRST = 0.4  # of a hair's room: the thirstiest hairs hold back what they have below it
_SOFT = 0.06  # of it, over which they do so
_PASSING = 0.2  # share of the thirst that changes along the way
_STAGE = 7.0  # mm of way, over which it becomes another
_STEP = 6  # places that change alike
_FLOWS = (0.08, 0.35)  # of a hair's room for ink: where ink begins to move, and moves freely
_SIDE = BLOCK  # place of b in the rows of `turned`


@njit(cache=True, nogil=True, error_model="numpy")
def ask_hairs(bristles, turned, contact, load, capacity, way_done, given):
    """What the hairs are ready to give, as against one another; returns the sum of their wishes.

    Parameters
    ----------
    bristles : Bristles
    turned, contact : arrays of `Hairs`
    load : (B, P) float64
        Ink in each hair, coats x mm2.
    capacity : float
        Ink in a full hair.
    way_done : float
        Of the tuft since it was dipped, mm: streaks come and go along it.
    given : (B,) float64
        Filled: its wish times its ink, coats x mm2.
    """
    count, n_pigments = load.shape
    cells = bristles.appetite.shape[0]
    stage = int(way_done / _STAGE)
    fraction = way_done / _STAGE - stage
    wanted = 0.0
    for i in range(count):
        given[i] = 0.0
        piece = contact[1, i]
        if piece < 0.0:
            continue
        b = turned[i // BLOCK, _SIDE + i % BLOCK]
        cell = min(cells - 1, max(0, int((b + 1.0) * 0.5 * cells)))
        held = 0.0
        for p in range(n_pigments):
            held += load[i, p]
        place = _STEP * (cell // _STEP) + 1
        now = bristles.thirst[(place * (stage + 7) * 31) % cells]
        soon = bristles.thirst[(place * (stage + 8) * 31) % cells]
        thirst = (1.0 - _PASSING) * bristles.thirst[cell]
        thirst += _PASSING * ((1.0 - fraction) * now + fraction * soon)
        flow = min(1.0, max(0.0, (held / capacity - _THIRST * thirst) / _SOFT))
        wish = min(1.0, 0.2 + np.float64(piece - contact[0, i])) * bristles.appetite[cell] * flow
        wanted += wish
        given[i] = wish * held
    return wanted


@njit(cache=True, nogil=True, error_model="numpy")
def settle_gifts(load, wanted, rate, given):
    """Turn wishes into what each hair gives over a way; returns the sum.

    Parameters
    ----------
    load : (B, P) float64
    wanted : float
        Sum of the wishes, from `ask_hairs`.
    rate : float
        eta' pe ds.
    given : (B,) float64
        From `ask_hairs`; overwritten, coats x mm2.
    """
    count, n_pigments = load.shape
    each = min(count / wanted, _MOST_PER_HAIR) * rate
    total = 0.0
    for i in range(count):
        if given[i] > 0.0:
            held = 0.0
            for p in range(n_pigments):
                held += load[i, p]
            given[i] = held * (1.0 - np.exp(-each * given[i] / held))
            total += given[i]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def sum_hairs(load, out):
    """Ink in all hairs, one after another: `out` (P,) of `load` (B, P)."""
    out[:] = 0.0
    for i in range(load.shape[0]):
        for p in range(load.shape[1]):
            out[p] += load[i, p]


@njit(cache=True, nogil=True, error_model="numpy")
def take_from_hairs(load, given, scale, released):
    """Take `scale` of what each hair is ready to give; `released` (P,) gets the sums."""
    count, n_pigments = load.shape
    released[:] = 0.0
    for i in range(count):
        if given[i] <= 0.0:
            continue
        held = 0.0
        for p in range(n_pigments):
            held += load[i, p]
        share = scale * given[i] / held
        for p in range(n_pigments):
            part = share * load[i, p]
            load[i, p] -= part
            released[p] += part


@njit(cache=True, nogil=True, error_model="numpy")
def give_to_hairs(load, contact, taken):
    """Share `taken` (P,) evenly among the hairs that touch."""
    count = load.shape[0]
    touching = 0
    for i in range(count):
        touching += contact[1, i] >= 0.0
    for i in range(count):
        if contact[1, i] >= 0.0:
            for p in range(load.shape[1]):
                load[i, p] += taken[p] / touching


@njit(cache=True, nogil=True, error_model="numpy")
def level_hairs(bristles, turned, load, capacity, way, bins):
    """Let hairs beside one another share their ink, the freer the wetter they are.

    Parameters
    ----------
    bristles, turned, load : as for `ask_hairs`
    capacity : float
        Ink in a full hair.
    way : float
        Of the tuft, mm.
    bins : (LEVEL_BINS, P + 1) float64
        Scratch.
    """
    count, n_pigments = load.shape
    bins[:] = 0.0
    for i in range(count):
        b = turned[i // BLOCK, _SIDE + i % BLOCK]
        at = min(LEVEL_BINS - 1, max(0, int((b + 1.0) * 0.5 * LEVEL_BINS)))
        for p in range(n_pigments):
            bins[at, p] += load[i, p]
        bins[at, n_pigments] += 1.0
    reach = 1.0 - np.exp(-way / bristles.levelling_mm)
    for i in range(count):
        b = turned[i // BLOCK, _SIDE + i % BLOCK]
        at = min(LEVEL_BINS - 1, max(0, int((b + 1.0) * 0.5 * LEVEL_BINS)))
        n = bins[at, n_pigments]
        mean = 0.0
        for p in range(n_pigments):
            mean += bins[at, p]
        flow = (mean / (n * capacity) - _FLOWS[0]) / (_FLOWS[1] - _FLOWS[0])
        share = reach * min(1.0, max(0.0, flow))
        for p in range(n_pigments):
            load[i, p] += share * (bins[at, p] / n - load[i, p])
